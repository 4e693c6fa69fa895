"""What the coil does: analytic displacement and velocity at any time, before the record included.

Contents: the five excitations, and how the probe is pressed in before them and before one that was
measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from tissue_probe.challenge.coil import PERFECT, Coil
from tissue_probe.challenge.measured_motion import Measured
from tissue_probe.challenge.periodic import periodic
from tissue_probe.signals import FloatArray

Kind = Literal["sine10", "sine10ss", "stepped30", "chirp60", "msine60"]

DURATIONS: dict[Kind, float] = {
    "sine10": 2.0,
    "sine10ss": 2.0,
    "stepped30": 8.0,
    "chirp60": 4.0,
    "msine60": 4.0,
}
"""Excitations by name, and how long each is recorded [s]."""

HIGHEST_FREQUENCY: dict[str, float] = {
    "sine10": 10.0,
    "sine10ss": 10.0,
    "stepped30": 30.0,
    "chirp60": 60.0,
    "msine60": 60.0,
}
"""Their highest frequencies [Hz]."""

PRESSING = 0.5  # s, in which the probe is pressed in to its preload
ESTABLISHING = 2.0  # s of motion before a record in steady state
FADING = 0.1  # s, in which motions begin that would jump otherwise
STAIRCASE_FREQUENCIES = (1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0)  # Hz, equally long
CORNER_WIDTH = 0.02  # s, in which one frequency passes to the next
MULTISINE_LINES = 60  # of the multisine, 1 Hz apart


@dataclass(frozen=True)
class Trajectory:
    """Displacement of the coil in one record, whose time counts from its first sample.

    Before the record the coil is pressed in smoothly to ``preload`` within 0.5 s and held there for
    ``hold``; in ``sine10ss`` it has then vibrated for 2 s more, and so it has in what was measured
    of a motion under way. Where that was measured from rest, it is held where the record begins.

    Attributes
    ----------
    kind : str
        One of ``DURATIONS``, or ``measured``.
    amplitude : float
        Largest displacement from the preload [m].
    duration : float
        Of the record [s].
    preload : float
        Mean displacement of the coil [m], positive into the tissue.
    hold : float
        Time at rest between pressing in and motion [s].
    phases : tuple of float
        Of the multisine's 60 lines [rad]; of ``sine10ss`` the first is its phase at the start.
    coil : Coil
        How the coil departs from what it is told.
    measured : Measured, optional
        The motion, where it is no named one.
    """

    kind: str
    amplitude: float
    duration: float
    preload: float = 0.0
    hold: float = 0.0
    phases: tuple[float, ...] = (0.0,) * MULTISINE_LINES
    coil: Coil = PERFECT
    measured: Measured | None = None

    @classmethod
    def follow_motion(cls, measured: Measured) -> Trajectory:
        """Return a motion as it was measured; no fault of a coil is added to those in it."""
        return cls(
            "measured",
            measured.amplitude,
            measured.duration,
            measured.preload,
            measured=measured,
        )

    @property
    def highest(self) -> float:
        """Highest frequency of the motion [Hz]."""
        return HIGHEST_FREQUENCY[self.kind] if self.measured is None else self.measured.highest

    @property
    def from_rest(self) -> bool:
        """Whether the coil rests until the record begins."""
        return self.kind != "sine10ss" if self.measured is None else self.measured.at_rest

    @property
    def held(self) -> float:
        """Displacement in which the coil is held before it moves [m]."""
        if self.measured is None:
            return self.preload
        return self.preload + self.amplitude * self.measured.held

    @property
    def start_of_motion(self) -> float:
        """Time at which the vibration begins [s], 0 or before."""
        return 0.0 if self.from_rest else -ESTABLISHING

    @property
    def lead(self) -> float:
        """Time from the undisturbed tissue to the first sample [s]."""
        pressed = self.held != 0.0 or self.hold > 0.0
        return (PRESSING + self.hold if pressed else 0.0) - self.start_of_motion

    def before(self, rate: int) -> int:
        """Return how many samples come before the first of the record at ``rate`` [Hz]."""
        return round(self.lead * rate)

    def sample_motion(self, rate: int) -> tuple[FloatArray, FloatArray]:
        """Return displacement [m] and velocity [m/s] of the coil at ``rate`` [Hz].

        From the beginning of the lead to the end of the record, both included; read-only.
        """
        return _sample_measured(self, rate)

    def _motion(self, since: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the motion at amplitude 1 and its derivative [1/s], by time since its start."""
        if self.measured is not None:
            motion = self.measured.at(since + self.start_of_motion)
            return motion if self.from_rest else _fade_in(since, *motion)
        if self.kind == "msine60":
            return _fade_in(since, *_multisine(since, self.phases))
        if self.kind == "sine10ss":
            angle = 2.0 * np.pi * 10.0 * since + self.phases[0]
            rate = np.full_like(since, 2.0 * np.pi * 10.0)
            return _fade_in(since, np.sin(angle), rate * np.cos(angle))
        angle, rate = _ANGLES[self.kind](since, self.duration)
        return np.sin(angle), rate * np.cos(angle)


def _sine(time: FloatArray, _: float) -> tuple[FloatArray, FloatArray]:
    return 2.0 * np.pi * 10.0 * time, np.full_like(time, 2.0 * np.pi * 10.0)


def _chirp(time: FloatArray, duration: float) -> tuple[FloatArray, FloatArray]:
    """Angle and its rate: the frequency rises linearly from 1 to 60 Hz."""
    rise = 59.0 / duration
    return 2.0 * np.pi * (time + 0.5 * rise * time**2), 2.0 * np.pi * (1.0 + rise * time)


def _step_frequency(time: FloatArray, duration: float) -> tuple[FloatArray, FloatArray]:
    """Angle and its rate: a staircase of frequencies, whose corners are rounded over 20 ms.

    The rounding keeps the velocity continuous; the angle takes the integral of ``_smooth``.
    """
    cycles, frequency = (
        STAIRCASE_FREQUENCIES[0] * time,
        np.full_like(time, STAIRCASE_FREQUENCIES[0]),
    )
    for number, rise in enumerate(np.diff(STAIRCASE_FREQUENCIES), start=1):
        begin = number * duration / len(STAIRCASE_FREQUENCIES)
        first, last = np.searchsorted(time, (begin, begin + CORNER_WIDTH))
        s = (time[first:last] - begin) / CORNER_WIDTH
        cycles[first:last] += rise * CORNER_WIDTH * s**4 * (2.5 - 3.0 * s + s**2)
        cycles[last:] += rise * (time[last:] - begin - 0.5 * CORNER_WIDTH)
        frequency[first:last] += rise * _smooth(s)[0]
        frequency[last:] += rise
    return 2.0 * np.pi * cycles, 2.0 * np.pi * frequency


@lru_cache(maxsize=4)
def _sample_measured(told: Trajectory, rate: int) -> tuple[FloatArray, FloatArray]:
    before = told.before(rate)
    time = (np.arange(before + round(told.duration * rate) + 1) - before) / rate
    pressed, pressing = _smooth((time + told.lead) / PRESSING)
    u, velocity = told.held * pressed, told.held / PRESSING * pressing
    moving = slice(before + round(told.start_of_motion * rate), None)
    since = time[moving] - told.start_of_motion
    motion, slope = told.coil.distort_motion(*told._motion(since))
    jitter, shaking = _fade_in(since, *told.coil.draw_jitter(since.size, rate))
    u[moving] += told.amplitude * motion + jitter
    velocity[moving] += told.amplitude * slope + shaking
    u.flags.writeable = velocity.flags.writeable = False
    return u, velocity


_ANGLES = {"sine10": _sine, "chirp60": _chirp, "stepped30": _step_frequency}


def _multisine(time: FloatArray, phases: tuple[float, ...]) -> tuple[FloatArray, FloatArray]:
    """Sum of sines at 1, 2, ... 60 Hz, peak 1, and its derivative, at evenly spaced times from 0.

    At n equidistant times in a period of 1 s the sum is a discrete Fourier transform, exactly.
    """
    count = round((time.size - 1) / time[-1])
    # sin(w t + phase) = Im e^(i phase) e^(i w t) = Re -i e^(i phase) e^(i w t)
    coefficients = -0.5j * count * np.exp(1j * np.asarray(phases)) / _peak(phases)
    return periodic(np.arange(1, MULTISINE_LINES + 1), coefficients, 1.0, count, time.size)


def _peak(phases: tuple[float, ...]) -> float:
    """Largest value over a period of 1 s, sought 64 times in a period of the fastest line."""
    spectrum = np.zeros(64 * MULTISINE_LINES, dtype=complex)
    spectrum[1 : MULTISINE_LINES + 1] = np.exp(1j * np.asarray(phases))
    return float(np.abs((np.fft.ifft(spectrum) * spectrum.size).imag).max())


def _fade_in(
    since: FloatArray, value: FloatArray, slope: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Let a motion begin smoothly from rest."""
    window, opening = _smooth(since / FADING)
    return window * value, window * slope + opening / FADING * value


def _smooth(s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Step from 0 to 1 within s = 0..1 with two continuous derivatives, and its derivative."""
    s = np.clip(s, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2), 30.0 * s**2 * (1.0 - s) ** 2
