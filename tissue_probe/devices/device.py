"""The functions of every probe, by any maker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from tissue_probe.excitation import Excitation
from tissue_probe.signals import FloatArray


class DeviceError(RuntimeError):
    """A device cannot go on; the message says the reason and the remedy."""


@dataclass(frozen=True, slots=True)
class Samples:
    """The samples of one read, each of shape (n,): position [m], force [N], command [V]."""

    position: FloatArray
    force: FloatArray
    command: FloatArray


class Device(Protocol):
    """A coil that takes a voltage and two sensors that are read, all on one sample clock.

    It is made from the ``Settings`` that its class names, and a ``Calibration``.

    Attributes
    ----------
    sample_period : float
        Time between two samples [s], kept by the device's own clock.
    samples_per_read : int
        How many samples the device likes to hand over at once; 1 where each comes by itself.
    force_range : tuple of float
        Smallest and largest force that the device can measure [N]; infinite where it knows none.
    commanded_voltage : float
        The voltage that the coil is told now [V].
    worst_lateness : float
        Longest delay between a sample and its being fetched since last asked [s].
    description : str
        The device's description, in YAML, as far as it is needed to understand a recording.
    """

    sample_period: float
    samples_per_read: int
    force_range: tuple[float, float]
    commanded_voltage: float
    worst_lateness: float
    description: str

    def start(self, excitation: Excitation) -> None:
        """Begin to sample, with the excitation [V] on the coil; sample 0 is taken now."""

    def read(self, count: int) -> Samples:
        """Wait until ``count`` more samples are taken and return them, none lost, none twice.

        Raises
        ------
        DeviceError
            If the device failed, or samples were not fetched in time and are lost.
        """

    def stop(self) -> None:
        """Put the coil at zero volts and end sampling.

        Allowed at any time, any number of times, from any thread, also while another one reads.

        Raises
        ------
        DeviceError
            If the coil could not be put at zero; the message says how it will be.
        """

    def close(self) -> None:
        """Stop, and let go of the hardware."""
