"""The probe on a National Instruments DAQ, on this machine or behind NI's gRPC device server.

What belongs here: all that knows the package ``nidaqmx``, which takes a tenth of a second to
import: that waits until a probe is made. What does not: limits (``safety``), and volts and counts
as forces and positions (``calibration``).
"""

from __future__ import annotations

from tissue_probe.devices.calibration import Calibration
from tissue_probe.devices.nidaqmx.settings import NiDaqmxSettings


class NiDaqmxProbe:
    """The probe on a DAQ by its name and settings; what is made is a ``probe.DaqProbe``."""

    Settings = NiDaqmxSettings

    def __new__(cls, settings: NiDaqmxSettings, calibration: Calibration) -> NiDaqmxProbe:
        """Make a ``DaqProbe``, as ``Path`` makes a path of the system's own kind."""
        from tissue_probe.devices.nidaqmx.probe import DaqProbe

        return super().__new__(DaqProbe)


__all__ = ["NiDaqmxProbe", "NiDaqmxSettings"]
