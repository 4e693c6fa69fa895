"""Every device by its name; a device's own packages are imported when it is chosen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

from pydantic import BaseModel

from tissue_probe.devices.calibration import Calibration
from tissue_probe.devices.device import Device
from tissue_probe.devices.nidaqmx.settings import NiDaqmxSettings
from tissue_probe.devices.simulated_settings import SimulatedProbeSettings


@dataclass(frozen=True)
class Registered:
    """A device that can be chosen.

    Attributes
    ----------
    settings : type
        Its settings; they become parameters of the driver.
    place : str
        ``module:class``; the class is made of the settings and a ``Calibration``.
    """

    settings: type[BaseModel]
    place: str

    def load(self) -> Callable[[BaseModel, Calibration], Device]:
        """Import the device's class, and with it the packages that it needs."""
        module, _, name = self.place.partition(":")
        kind: Callable[[BaseModel, Calibration], Device] = getattr(import_module(module), name)
        return kind


#: Every device by the name that the driver's parameter ``device`` takes.
DEVICES = {
    "simulated": Registered(
        SimulatedProbeSettings, "tissue_probe.devices.simulated:SimulatedProbe"
    ),
    "nidaqmx": Registered(NiDaqmxSettings, "tissue_probe.devices.nidaqmx.probe:NiDaqmxProbe"),
}
