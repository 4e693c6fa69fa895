"""The colour of the rest that a fit leaves, so that errors are stated as they are.

A filter colours noise, sensors have 1/f noise of their own, and the poses' noise comes twice
differentiated: none is white. The rest of each axis is taken for an autoregressive process,
r_n = a_1 r_(n-1) + ... + e_n, and everything is fitted after the filter that makes it white.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_toeplitz

from tissue_probe.signals import FloatArray

COLOUR_ORDER = 6
"""Of the process: .4 s at the coarse rate, where the filter's own colour has ended."""


@dataclass(frozen=True)
class Colour:
    """An autoregressive process: the filter that makes it white, shape (p + 1,), begins with 1."""

    whitener: FloatArray
    deviation: float

    def white(self, rows: FloatArray) -> FloatArray:
        """Return rows of one stretch, shape (n, ...), white and of variance 1: n - p of them."""
        order = len(self.whitener) - 1
        summed = sum(a * rows[order - k : len(rows) - k] for k, a in enumerate(self.whitener))
        return np.asarray(summed) / self.deviation

    def of_mean(self, count: int) -> float:
        """Return the variance of the mean of so many rows."""
        return float(self.deviation**2 / (self.whitener.sum() ** 2 * count))


def white_noise(deviation: float) -> Colour:
    """Return the process without a colour."""
    return Colour(np.ones(1), deviation)


def colour_of(stretches: list[FloatArray], floor: float) -> Colour:
    """Return the process of the rest in each stretch (Yule and Walker).

    Parameters
    ----------
    stretches : list of arrays, each of shape (n,)
        The rest.
    floor : float
        Deviation that noise has at least: an axis that is exact by rounding weighs no more.
    """
    total = sum(map(len, stretches))
    moments = np.array(
        [sum(r[: len(r) - k] @ r[k:] for r in stretches) / total for k in range(COLOUR_ORDER + 1)]
    )
    moments[0] = max(moments[0], floor**2) * (1.0 + 1e-9)
    weights = solve_toeplitz(moments[:COLOUR_ORDER], moments[1:])
    variance = moments[0] - weights @ moments[1:]
    return Colour(
        np.concatenate([[1.0], -weights]), float(np.sqrt(max(variance, 1e-6 * moments[0])))
    )
