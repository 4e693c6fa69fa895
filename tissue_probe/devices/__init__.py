"""Probes behind one small interface.

What belongs here: one file a device, the interface they share, and what stands between every
command and every device. What does not: ROS, and what the samples mean.
"""

from __future__ import annotations

from tissue_probe.devices.device import Device, DeviceError
from tissue_probe.devices.interlock import Interlock
from tissue_probe.devices.limits import LimitExceeded, Limits
from tissue_probe.devices.nidaqmx import NiDaqmxProbe, NiDaqmxSettings
from tissue_probe.devices.safety import GuardedDevice, Tripped
from tissue_probe.devices.simulated import SimulatedProbe, SimulatedProbeSettings

#: Every device by the name that the driver's parameter ``device`` takes; its ``Settings`` become
#: parameters of the driver.
DEVICES = {
    "simulated": SimulatedProbe,
    "nidaqmx": NiDaqmxProbe,
}

__all__ = [
    "DEVICES",
    "Device",
    "DeviceError",
    "GuardedDevice",
    "Interlock",
    "LimitExceeded",
    "Limits",
    "NiDaqmxProbe",
    "NiDaqmxSettings",
    "SimulatedProbe",
    "SimulatedProbeSettings",
    "Tripped",
]
