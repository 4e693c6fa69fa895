"""How much samples tell of stiffness and damping.

Contents: whether there are enough samples, by their information, not by their count.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.signals import BoolArray, FloatArray

ENOUGH_DEVIATION = 0.1
"""Standard deviation of the stiffness beside force over position at which samples tell enough: two
of them then tell a tissue from one half as stiff again."""

FEWEST_IN_RESIDUAL = 64
"""Fewer samples leave a residual that cannot be judged: eight blocks of eight are held out of it,
as spectra of it are averaged over eight segments."""


def stiffness_deviation(
    position: FloatArray, force: FloatArray, sample_period: float, known: BoolArray | None = None
) -> float:
    """Return how well samples determine the stiffness, in shares of force over position.

    The standard deviation that least squares give of k in F = k u + beta du/dt + F0, by the
    samples' own scatter about it. Neither a model nor the noise need be known; further parts of the
    true model count as scatter, so that it is never too small. Infinite where nothing moves.

    Parameters
    ----------
    position, force : array, shape (n,)
        [m], [N]; finite.
    sample_period : float
        [s].
    known : array of bool, shape (n,), optional
        Which count; by default all.
    """
    if position.size < FEWEST_IN_RESIDUAL:
        return np.inf
    speed = np.gradient(position, sample_period)
    chosen = slice(None) if known is None else known
    columns = [_of_size_one(column[chosen]) for column in (position, speed, force)]
    scales = [float(np.std(column)) for column in columns]
    if columns[0].size < FEWEST_IN_RESIDUAL or not scales[0] > 0.0 or not scales[1] > 0.0:
        return np.inf
    if not scales[2] > 0.0:
        return 0.0  # no force: that is known exactly, and is told otherwise
    u, v, f = (column / scale for column, scale in zip(columns, scales, strict=True))
    likeness = float(np.mean(u * v))
    own = 1.0 - likeness**2  # the part of the position that does not come from the velocity
    if own < 1e-9:
        return np.inf
    right = np.array([np.mean(u * f), np.mean(v * f)])
    values = np.linalg.solve([[1.0, likeness], [likeness, 1.0]], right)
    left = max(1.0 - float(values @ right), 0.0)
    return float(np.sqrt(left / ((u.size - 3) * own)))


def _of_size_one(column: FloatArray) -> FloatArray:
    """Return a column without its mean, of a size of which no square is lost or too large."""
    size = float(np.max(np.abs(column), initial=0.0)) or 1.0
    return column / size - np.mean(column / size)
