"""What the coil is told to do: periodic and swept signals as functions of time.

What belongs here: signals that excite the tissue, each with its amplitude in the unit of whatever
it drives (volts at the coil of a probe, metres of its tip in a simulation).
What does not: judging how well they excite (``estimation``), or playing them (``devices``).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, model_validator

from tissue_probe.signals import FloatArray

Frequency = Annotated[float, Field(ge=0.01, le=100.0)]


class _Signal(BaseModel, ABC):
    """What all excitations have in common: an amplitude, and a value at any time."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    amplitude: float = Field(1.0, ge=0.0, le=10.0, description="largest value of the signal")

    def __call__(self, time: FloatArray) -> FloatArray:
        """Return the signal at ``time`` [s since activation], in the amplitude's unit."""
        return self.amplitude * self._unit(np.asarray(time, dtype=np.float64))

    @abstractmethod
    def _unit(self, time: FloatArray) -> FloatArray:
        """Return the signal at amplitude 1."""


class Sine(_Signal):
    """A sin(2 pi f t), the paper's excitation (section II-B)."""

    kind: Literal["sine"] = "sine"
    frequency: Frequency = Field(10.0, description="frequency [Hz]")

    def _unit(self, time: FloatArray) -> FloatArray:
        return np.sin(2.0 * np.pi * self.frequency * time)


class _Sweep(_Signal):
    start: Frequency = Field(1.0, description="first frequency [Hz]")
    stop: Frequency = Field(30.0, description="last frequency [Hz]")
    duration: float = Field(10.0, gt=0.0, le=3600.0, description="time of one sweep [s]")

    @model_validator(mode="after")
    def _rises(self) -> _Sweep:
        if self.stop <= self.start:
            raise ValueError(f"stop is {self.stop} Hz; it must be above start, {self.start} Hz")
        return self


class SteppedSweep(_Sweep):
    """Sines one after another, equally long, from ``start`` to ``stop``; then from the start again.

    The phase is carried over from step to step, so the signal has no jumps.
    """

    kind: Literal["stepped_sweep"] = "stepped_sweep"
    steps: int = Field(10, ge=2, le=1000, description="number of frequencies")

    def _unit(self, time: FloatArray) -> FloatArray:
        step = self.duration / self.steps
        frequencies = np.linspace(self.start, self.stop, self.steps)
        cycles_before = np.concatenate([[0.0], np.cumsum(frequencies * step)])
        sweeps, within = np.divmod(time, self.duration)
        index = np.minimum((within / step).astype(np.int64), self.steps - 1)
        cycles = cycles_before[index] + frequencies[index] * (within - index * step)
        return np.sin(2.0 * np.pi * (cycles + sweeps * cycles_before[-1]))


class Chirp(_Sweep):
    """A sine whose frequency rises linearly from ``start`` to ``stop``; then from the start again."""

    kind: Literal["chirp"] = "chirp"

    def _unit(self, time: FloatArray) -> FloatArray:
        sweeps, within = np.divmod(time, self.duration)
        rate = (self.stop - self.start) / self.duration
        cycles_a_sweep = 0.5 * (self.start + self.stop) * self.duration
        cycles = self.start * within + 0.5 * rate * within**2
        return np.sin(2.0 * np.pi * (cycles + sweeps * cycles_a_sweep))


class Multisine(_Signal):
    """A sum of equally strong sines with Schroeder's phases, scaled to the amplitude.

    Frequencies lie at multiples of ``spacing`` from ``start`` to ``stop``; the signal repeats
    every 1 / spacing. Schroeder (1970), "Synthesis of low-peak-factor signals": phase_n =
    -pi n (n - 1) / N keeps the crest factor low.
    """

    kind: Literal["multisine"] = "multisine"
    start: Frequency = Field(1.0, description="lowest frequency [Hz]")
    stop: Frequency = Field(30.0, description="highest frequency [Hz]")
    spacing: Frequency = Field(1.0, description="distance between the frequencies [Hz]")

    @model_validator(mode="after")
    def _spans(self) -> Multisine:
        if self.stop < self.start + self.spacing:
            raise ValueError(
                f"stop is {self.stop} Hz; for two sines at least it must be "
                f"{self.start + self.spacing} Hz (start + spacing)"
            )
        return self

    def _unit(self, time: FloatArray) -> FloatArray:
        # The peak is taken over one period on a grid of 64 points to the fastest sine's period.
        period = 1.0 / self.spacing
        grid = np.linspace(0.0, period, int(64 * np.ceil(self.stop / self.spacing)))
        return self._sum(time) / np.abs(self._sum(grid)).max()

    def _sum(self, time: FloatArray) -> FloatArray:
        count = int((self.stop - self.start) / self.spacing * (1.0 + 1e-12)) + 1
        total = np.zeros_like(time)
        for n in range(count):
            frequency = self.start + n * self.spacing
            total += np.sin(2.0 * np.pi * frequency * time - np.pi * n * (n + 1) / count)
        return total


Excitation = Annotated[Sine | SteppedSweep | Chirp | Multisine, Field(discriminator="kind")]

EXCITATIONS: dict[str, type[_Signal]] = {
    "sine": Sine,
    "stepped_sweep": SteppedSweep,
    "chirp": Chirp,
    "multisine": Multisine,
}

_adapter: TypeAdapter[Excitation] = TypeAdapter(Excitation)


def parse_excitation(description: dict) -> Excitation:
    """Make an excitation of a dictionary with its ``kind`` and values, as read from YAML or a bag.

    Raises
    ------
    pydantic.ValidationError
        If the kind is unknown or a value is out of its range.
    """
    return _adapter.validate_python(description)
