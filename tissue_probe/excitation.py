"""The coil's commands: periodic and swept signals as functions of time.

Contents: signals that excite the tissue, each with its amplitude in the unit of the driven quantity
(volts at the coil of a probe, metres of its tip in a simulation).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from fractions import Fraction
from functools import cached_property
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, model_validator

from tissue_probe.settings import SettingsError, build, setting
from tissue_probe.signals import FloatArray

#: Points in a period of a multisine's fastest sine where its peak is looked for.
PEAK_POINTS = 64
#: A multisine that repeats after more base periods than this counts as one that never repeats.
REPEATED_PERIODS = 32


def _frequency(default: float, description: str) -> Any:
    return setting(default, "Hz", description, ge=0.01, le=100.0)


class _Signal(BaseModel, ABC):
    """The common part of all excitations: an amplitude, and a value at any time."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    amplitude: float = setting(1.0, "", "largest value of the signal", ge=0.0, le=10.0)

    def __call__(self, time: FloatArray) -> FloatArray:
        """Return the signal at ``time`` [s since activation], in the amplitude's unit."""
        return self.amplitude * self._unit(np.asarray(time, dtype=np.float64))

    @property
    @abstractmethod
    def period(self) -> float | None:
        """After which time the signal repeats exactly [s]; None if it does not."""

    @property
    @abstractmethod
    def highest_frequency(self) -> float:
        """Frequency of the fastest sine in the signal [Hz]."""

    @abstractmethod
    def _unit(self, time: FloatArray) -> FloatArray:
        """Return the signal at amplitude 1."""


class Sine(_Signal):
    """A sin(2 pi f t), the paper's excitation (section II-B)."""

    kind: Literal["sine"] = "sine"
    frequency: float = _frequency(10.0, "frequency")

    @property
    def period(self) -> float:
        """After which time the signal repeats [s]."""
        return 1.0 / self.frequency

    @property
    def highest_frequency(self) -> float:
        """The frequency [Hz]."""
        return self.frequency

    def _unit(self, time: FloatArray) -> FloatArray:
        return np.sin(2.0 * np.pi * self.frequency * time)


class _Sweep(_Signal):
    start: float = _frequency(1.0, "first frequency")
    stop: float = _frequency(30.0, "last frequency")
    duration: float = setting(10.0, "s", "time of one sweep", gt=0.0, le=3600.0)

    @model_validator(mode="after")
    def _rises(self) -> _Sweep:
        if self.stop <= self.start:
            raise ValueError(f"stop is {self.stop:g} Hz; give one above start, {self.start:g} Hz")
        return self

    @property
    def period(self) -> float | None:
        """The duration of a sweep, if it holds whole cycles [s]: the phase is carried over."""
        cycles = 0.5 * (self.start + self.stop) * self.duration
        return self.duration if abs(cycles - round(cycles)) < 1e-9 else None

    @property
    def highest_frequency(self) -> float:
        """Where the sweep ends [Hz]."""
        return self.stop


class SteppedSweep(_Sweep):
    """Sines one after another, equally long, from ``start`` to ``stop``; then from the start again.

    The phase is carried over from step to step, so the signal has no jumps.
    """

    kind: Literal["stepped_sweep"] = "stepped_sweep"
    steps: int = setting(10, "", "number of frequencies", ge=2, le=1000)

    def _unit(self, time: FloatArray) -> FloatArray:
        step = self.duration / self.steps
        frequencies = np.linspace(self.start, self.stop, self.steps)
        cycles_before = np.concatenate([[0.0], np.cumsum(frequencies * step)])
        sweeps, within = np.divmod(time, self.duration)
        index = np.minimum((within / step).astype(np.int64), self.steps - 1)
        cycles = cycles_before[index] + frequencies[index] * (within - index * step)
        wave: FloatArray = np.sin(2.0 * np.pi * (cycles + sweeps * cycles_before[-1]))
        return wave


class Chirp(_Sweep):
    """A sine whose frequency rises linearly from ``start`` to ``stop``, again and again."""

    kind: Literal["chirp"] = "chirp"

    def _unit(self, time: FloatArray) -> FloatArray:
        sweeps, within = np.divmod(time, self.duration)
        rate = (self.stop - self.start) / self.duration
        cycles_a_sweep = 0.5 * (self.start + self.stop) * self.duration
        cycles = self.start * within + 0.5 * rate * within**2
        return np.sin(2.0 * np.pi * (cycles + sweeps * cycles_a_sweep))


class Multisine(_Signal):
    """A sum of equally strong sines with Schroeder's phases, scaled to the amplitude.

    The frequencies are ``start``, ``start + spacing``, and so on up to ``stop``; the signal repeats
    every 1 / spacing where ``start`` is a multiple of ``spacing``. Schroeder (1970), "Synthesis of
    low-peak-factor signals": phase_n = -pi n (n - 1) / N keeps the crest factor low.
    """

    kind: Literal["multisine"] = "multisine"
    start: float = _frequency(1.0, "lowest frequency")
    stop: float = _frequency(30.0, "highest frequency")
    spacing: float = _frequency(1.0, "distance between the frequencies")

    @model_validator(mode="after")
    def _spans(self) -> Multisine:
        if self.stop < self.start + self.spacing:
            raise ValueError(
                f"stop is {self.stop:g} Hz; give at least start + spacing, "
                f"{self.start + self.spacing:g} Hz, so that there are two sines"
            )
        return self

    def _unit(self, time: FloatArray) -> FloatArray:
        total = np.zeros_like(time)
        for n, phase in enumerate(self._phases):
            total += np.sin(2.0 * np.pi * (self.start + n * self.spacing) * time + phase)
        return total / self._peak

    @property
    def period(self) -> float | None:
        """The inverse of ``spacing`` [s], if ``start`` is a multiple of it."""
        turn = self.start / self.spacing
        return 1.0 / self.spacing if abs(turn - round(turn)) < 1e-9 else None

    @property
    def highest_frequency(self) -> float:
        """Frequency of the fastest sine [Hz], ``stop`` at the most."""
        return self.stop

    @property
    def _phases(self) -> FloatArray:
        count = int((self.stop - self.start) / self.spacing * (1.0 + 1e-12)) + 1
        n = np.arange(count)
        return -np.pi * n * (n + 1) / count

    @cached_property
    def _peak(self) -> float:
        """Upper bound of the sum of sines over all time, too high by 0.12 % at the most.

        The sum is Im(exp(2 pi i start t) e(t)), with e of period 1 / spacing. From one period to
        the next the first factor turns by start / spacing revolutions: through a few angles where
        that is a simple fraction, else through all, and then the bound is that of abs(e).
        """
        size = PEAK_POINTS * int(np.ceil(self.stop / self.spacing))
        envelope = size * np.fft.ifft(np.exp(1j * self._phases), size)
        turn = self.start / self.spacing
        fraction = Fraction(turn).limit_denominator(REPEATED_PERIODS)
        if abs(turn - fraction) < 1e-9:
            wave = envelope * np.exp(2j * np.pi * turn * np.arange(size) / size)
            turns = np.exp(2j * np.pi * np.arange(fraction.denominator) / fraction.denominator)
            largest = max(np.abs((wave * each).imag).max() for each in turns)
        else:
            largest = np.abs(envelope).max()
        # Between points a sum of sines rises by no more than this (Ehlich and Zeller, 1964).
        return float(largest / np.cos(np.pi / PEAK_POINTS))


Excitation = Sine | SteppedSweep | Chirp | Multisine

EXCITATIONS: dict[str, type[Excitation]] = {
    "sine": Sine,
    "stepped_sweep": SteppedSweep,
    "chirp": Chirp,
    "multisine": Multisine,
}


def parse_excitation(description: dict[str, Any]) -> Excitation:
    """Make an excitation of a dictionary with its ``kind`` and values, as read from YAML or a bag.

    Raises
    ------
    SettingsError
        If the kind is unknown, a value is out of its range, or the values do not go together.
    """
    kind = description.get("kind")
    if not isinstance(kind, str) or kind not in EXCITATIONS:
        raise SettingsError(f"excitation.kind is {kind!r}: give one of {', '.join(EXCITATIONS)}")
    return build(EXCITATIONS[kind], description, "excitation.")
