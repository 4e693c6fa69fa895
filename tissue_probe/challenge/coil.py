"""How a voice coil departs from the motion that it is told to make.

Contents: harmonics and jitter.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tissue_probe.challenge.change import log_uniform
from tissue_probe.challenge.periodic import periodic
from tissue_probe.signals import FloatArray

HARMONICS = (1e-3, 1e-2)
"""Range of the second and of the third harmonic of a sine, over its amplitude [-]."""

JITTER = (0.3e-6, 3e-6)
"""Range of the rms of the jitter [m]."""

LOWEST, HIGHEST, PERIOD = 1.0, 100.0, 2.0
"""Band of the jitter [Hz], and the time after which it repeats [s]."""


class Coil(NamedTuple):
    """Faults of a coil; the default is without.

    Attributes
    ----------
    second, third : float
        Harmonics of a sine of full amplitude, over that [-]: a force that depends on the position.
    jitter : float
        Rms of what a servo leaves, whose amplitude falls as 1/f from 1 to 100 Hz [m].
    seed : int
        Of the phases of the jitter.
    """

    second: float = 0.0
    third: float = 0.0
    jitter: float = 0.0
    seed: int = 0

    @classmethod
    def draw(cls, random: np.random.Generator) -> Coil:
        """Draw a coil."""
        second, third = (log_uniform(random, *HARMONICS) for _ in range(2))
        return cls(second, third, log_uniform(random, *JITTER), int(random.integers(2**32)))

    def distort_motion(self, s: FloatArray, rate: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return a motion at amplitude 1, and its derivative, with harmonics.

        Chebyshev polynomials: of sin a, 2 s^2 is 1 - cos 2a, and 4 s^3 - 3 s is -sin 3a.
        """
        value = s + 2.0 * self.second * s**2 + self.third * (4.0 * s**3 - 3.0 * s)
        return value, rate * (1.0 + 4.0 * self.second * s + self.third * (12.0 * s**2 - 3.0))

    def draw_jitter(self, count: int, rate: int) -> tuple[FloatArray, FloatArray]:
        """Return the jitter [m] at ``count`` instants, ``rate`` [Hz] apart, and its derivative."""
        samples = round(PERIOD * rate)
        lines = np.arange(round(LOWEST * PERIOD), round(HIGHEST * PERIOD) + 1)
        phases = np.random.default_rng(self.seed).uniform(0.0, 2.0 * np.pi, lines.size)
        size = self.jitter * samples / np.sqrt(2.0 * np.sum(1.0 / lines**2))
        return periodic(lines, np.exp(1j * phases) / lines * size, PERIOD, samples, count)


PERFECT = Coil()
"""A coil without faults."""
