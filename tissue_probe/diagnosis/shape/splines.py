"""Natural cubic splines: free functions of one signal, in directions from smooth to rough.

Contents: values and second derivatives of a basis, and how likely smoothness makes each direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from tissue_probe.signals import FloatArray


@dataclass(frozen=True, eq=False)
class Spline:
    """A free function of a signal without constant and straight part, straight beyond its knots.

    Attributes
    ----------
    knots : array, shape (m,)
        In the unit of the signal, rising.
    """

    knots: FloatArray

    @property
    def count(self) -> int:
        """How many directions it has: those of m values but constant and straight part."""
        return self.knots.size - 2

    def columns(self, signal: FloatArray) -> FloatArray:
        """Return the function's directions at values of the signal, shape (n, ``count``).

        Each is as likely as any other to be large: its bend, squared and integrated over the
        signal in units of the range of the knots, is 1.
        """
        inside = np.clip(signal, self.knots[0], self.knots[-1])
        beyond = (signal - inside)[:, None]
        through = self._through
        values = through(inside) + beyond * through(inside, 1)
        return np.asarray(values @ self._directions)

    def at_knots(self, weights: FloatArray) -> FloatArray:
        """Return the function's values at its knots, for weights of its directions."""
        return np.asarray(self._directions @ weights)

    @cached_property
    def _through(self) -> CubicSpline:
        return CubicSpline(self.knots, np.eye(self.knots.size), bc_type="natural")

    @cached_property
    def _directions(self) -> FloatArray:
        length = self.knots[-1] - self.knots[0]
        gaps = np.diff(self.knots) / length
        bend = self._through(self.knots, 2) * length**2
        # The second derivative is straight between knots: the integral of its square is exact.
        mass = np.zeros((self.knots.size, self.knots.size))
        for index, gap in enumerate(gaps):
            mass[index : index + 2, index : index + 2] += gap / 6.0 * np.array([[2, 1], [1, 2]])
        sizes, directions = np.linalg.eigh(bend.T @ mass @ bend)
        return np.asarray(directions[:, 2:] / np.sqrt(sizes[2:]))


def even_knots(low: float, high: float, count: int) -> FloatArray:
    """Return knots at even distances."""
    return np.linspace(low, high, count)


def knots_about_zero(largest: float, least: float, count: int) -> FloatArray:
    """Return an odd number of knots, one at 0, close about it and wide far from it.

    Parameters
    ----------
    largest : float
        The outermost knot, on either side.
    least : float
        Below it distances are even; above they grow as the signal does.
    count : int
        How many; one more where it is even.
    """
    side = count // 2
    steps = np.arange(-side, side + 1) / side
    return np.asarray(least * np.sinh(np.arcsinh(largest / least) * steps))
