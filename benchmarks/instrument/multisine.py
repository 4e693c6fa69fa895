"""A sum of sines, known between the samples as exactly as at them.

Contents: drawing one, its values, what a linear system makes of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

Array = np.ndarray
#: Lines of a spectrum: with so many the values are nearly normal, and a peak is 3 to 4 rms.
LINES = 60
#: Instants looked at for a passage through the mean, for each period of the fastest line.
FINE = 8


@dataclass(frozen=True)
class Multisine:
    """The values mean + Re sum_k c_k exp(2 pi i f_k t).

    Attributes
    ----------
    frequencies : array, shape (lines,)
        f [Hz].
    amplitudes : complex array, shape (lines,)
        c, in the unit of the values.
    mean : float
        In the unit of the values.
    """

    frequencies: Array
    amplitudes: Array
    mean: float = 0.0

    def __call__(self, times: float | Array) -> Array:
        """Return the values at some times [s], of the shape of the times."""
        angles = 2.0 * np.pi * np.multiply.outer(times, self.frequencies)
        cosines = np.cos(angles) @ self.amplitudes.real
        return self.mean + cosines - np.sin(angles) @ self.amplitudes.imag

    def through(self, transfer: Callable[[Array], Array]) -> Multisine:
        """Return what a linear system makes of it that has felt it for ever.

        Parameters
        ----------
        transfer : callable
            Transfer function of s = 2 pi i f.
        """
        steady = transfer(np.zeros(1, dtype=complex))[0].real
        passed = transfer(2j * np.pi * self.frequencies) * self.amplitudes
        return Multisine(self.frequencies, passed, self.mean * steady)

    @property
    def rms(self) -> float:
        """Of the values about their mean."""
        return float(np.sqrt(0.5 * np.sum(np.abs(self.amplitudes) ** 2)))

    def of_rms(self, rms: float) -> Multisine:
        """Return it with another size about its mean."""
        return replace(self, amplitudes=self.amplitudes * (rms / self.rms))

    def about(self, mean: float) -> Multisine:
        """Return it about another mean."""
        return replace(self, mean=mean)

    def from_its_mean(self) -> Multisine:
        """Return it later, such that it passes its mean at the time 0: a tip at rest stays so."""
        grid = np.arange(0.0, 1.0, 1.0 / FINE) / self.frequencies.max()
        level, first = self.about(0.0), 0.0
        while np.ptp(np.sign(level(first + grid))) == 0.0:
            first += grid[-1]
        at = first + grid[np.flatnonzero(np.diff(np.sign(level(first + grid))))[0]]
        passed = brentq(level, at, at + grid[1], xtol=1e-15)
        turned = self.amplitudes * np.exp(2j * np.pi * self.frequencies * passed)
        return replace(self, amplitudes=turned)


def drawn(
    random: np.random.Generator, low: float, high: float, rms: float, resolution: float
) -> Multisine:
    """Return lines of one size and of random phases, about 0.

    Parameters
    ----------
    random : Generator
        Of frequencies and phases.
    low, high : float
        Bounds of the frequencies [Hz].
    rms : float
        Of the values.
    resolution : float
        The frequencies are multiples of it [Hz].
    """
    grid = np.arange(np.ceil(low / resolution), np.floor(high / resolution) + 1.0) * resolution
    chosen = np.sort(random.choice(grid, min(LINES, grid.size), replace=False))
    phases = np.exp(2j * np.pi * random.uniform(size=chosen.size))
    return Multisine(chosen, phases).of_rms(rms)
