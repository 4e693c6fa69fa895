"""What stands between every command and every device: limits, and zero after any failure."""

from __future__ import annotations

import numpy as np
from pydantic import BaseModel, ConfigDict

from tissue_probe.devices.device import Device, Samples
from tissue_probe.excitation import Excitation
from tissue_probe.settings import setting


class Limits(BaseModel):
    """What must not be passed while the coil is driven."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    force_limit: float = setting(
        8.0,
        "N",
        "largest force on the load cell, either way; above it the coil goes to zero",
        gt=0.0,
        le=22.0,
    )
    travel_limit: float = setting(
        0.006,
        "m",
        "largest displacement of the coil, either way; beyond it the coil goes to zero",
        gt=0.0,
        le=0.0065,
    )
    command_limit: float = setting(
        5.0,
        "V",
        "largest voltage on the coil, either way; an excitation above it is refused",
        gt=0.0,
        le=10.0,
    )


class LimitExceeded(RuntimeError):
    """A limit was passed; the coil is at zero."""


class GuardedDevice:
    """A device within its limits: whatever goes wrong, the coil is at zero before anyone hears.

    It is itself a ``Device``.
    """

    def __init__(self, device: Device, limits: Limits) -> None:
        self._device = device
        self._limits = limits

    @property
    def sample_period(self) -> float:
        """Time between two samples [s]."""
        return self._device.sample_period

    @property
    def samples_per_read(self) -> int:
        """How many samples the device likes to hand over at once."""
        return self._device.samples_per_read

    @property
    def commanded_voltage(self) -> float:
        """Voltage that the coil is told now [V]."""
        return self._device.commanded_voltage

    @property
    def description(self) -> str:
        """What the device is, in YAML."""
        return self._device.description

    @property
    def worst_lateness(self) -> float:
        """Longest delay between a sample and its being fetched since last asked [s]."""
        return self._device.worst_lateness

    def start(self, excitation: Excitation) -> None:
        """Begin to sample with the excitation on the coil.

        Raises
        ------
        LimitExceeded
            If the excitation would pass the command limit; nothing is started then, and what ran
            before is stopped.
        """
        try:
            if excitation.amplitude > self._limits.command_limit:
                raise LimitExceeded(
                    f"the excitation's amplitude is {excitation.amplitude:g} V, above the command "
                    f"limit of {self._limits.command_limit:g} V: lower it"
                )
            self._device.start(excitation)
        except BaseException:
            self._device.stop()
            raise

    def read(self, count: int) -> Samples:
        """Read ``count`` samples.

        Raises
        ------
        LimitExceeded
            If a sample passed a limit. NaN passes none: it is what was measured, and those who
            use it say so.
        """
        try:
            samples = self._device.read(count)
            self._check("force", samples.force, self._limits.force_limit, "N")
            self._check("position", samples.position, self._limits.travel_limit, "m")
        except BaseException:
            self._device.stop()
            raise
        return samples

    def _check(self, name: str, values: np.ndarray, limit: float, unit: str) -> None:
        for value in values.tolist():
            if abs(value) > limit:
                raise LimitExceeded(
                    f"the {name} was {value:.4g} {unit}, beyond its limit of {limit:g} {unit}: "
                    "the coil is at zero; look at the probe before you activate it again"
                )

    def stop(self) -> None:
        """Put the coil at zero volts and end sampling."""
        self._device.stop()

    def close(self) -> None:
        """Stop, and let go of the hardware."""
        self._device.close()
