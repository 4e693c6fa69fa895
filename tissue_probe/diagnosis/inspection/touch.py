"""Where the tip touches, in a record that begins in the air.

What belongs here: finding the first touch. What does not: what is done with it (``cleaning``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import legvander

from tissue_probe.signals import FloatArray

#: A force is felt from so many standard deviations of its noise on, in so many samples in a row.
FELT, IN_A_ROW = 4.0, 4
#: Of the slope that follows, the force in the air has this share at the most, doubt included: the
#: softest law of contact, a cone's square, has a third of it in as long a way.
FLAT = 0.1
#: Samples that tell a slope.
FEWEST = 16
#: Degree of the course of a zero that drifts or settles, in time.
DRIFT = 3
#: Where it ends is sought in the means of so many spans, which tell it well enough to begin with.
BLOCKS = 1000


@dataclass(frozen=True)
class Touch:
    """The first touch: number of the last sample in the air, and the position there [m]."""

    sample: int
    position: float


def first_touch(position: FloatArray, force: FloatArray, noise: float) -> Touch | None:
    """Find where a record that begins in the air first feels the tissue; None where it does not.

    In the air the force is the same wherever the tip is, and its zero drifts slowly at the most; in
    contact it grows with the way.

    Parameters
    ----------
    position, force : array, shape (n,)
        [m], positive into the tissue; [N].
    noise : float
        Standard deviation of the force's noise [N].
    """
    last = _last_in_air(force[: _first_way(position)], noise)
    if last is None:
        return None
    way = position[last] - position[0] if last > 0 else 0.0
    beyond = np.flatnonzero(position[last:] > position[last] + way)
    after = last + (int(beyond[0]) if beyond.size else position.size - last)
    if last < FEWEST or after - last < FEWEST or way <= 0.0:
        return None
    if np.ptp(position[last:after]) == 0.0:  # a tip at rest comes from nowhere
        return None
    slope, doubt = _slope(position[: last + 1], force[: last + 1])
    following, _ = _slope(position[last:after], force[last:after])
    if not abs(slope) + 2.0 * doubt < FLAT * following:
        return None
    return Touch(last, float(position[last]))


def _first_way(position: FloatArray) -> int:
    """Count the samples until the tip has first come as far as it does before it goes back."""
    farthest = np.maximum.accumulate(position)
    back = farthest - position > 0.5 * np.ptp(position)
    until = int(np.argmax(back)) if back.any() else position.size
    return int(np.argmax(position[:until])) + 1


def _last_in_air(force: FloatArray, noise: float) -> int | None:
    """Return the last sample before the force leaves the course of its zero; None if none does."""
    changed = _change(force)
    if changed is None:
        return None
    time = np.linspace(-1.0, 1.0, force.size)
    zero = Polynomial.fit(time[:changed], force[:changed], DRIFT)
    left = np.abs(force - zero(time))
    usual = max(noise, float(np.sqrt(np.mean(left[:changed] ** 2))))
    rows = np.convolve(left > FELT * usual, np.ones(IN_A_ROW), mode="valid") == IN_A_ROW
    return int(np.argmax(rows)) - 1 if rows.any() else None


def _change(force: FloatArray) -> int | None:
    """Return the sample at which two courses, each a polynomial in time, part best."""
    each = max(1, force.size // BLOCKS)
    means = force[: force.size // each * each].reshape(-1, each).mean(axis=1)
    count = means.size
    if count < 2 * FEWEST:
        return None
    basis = legvander(np.linspace(-1.0, 1.0, count), DRIFT)
    grams = np.cumsum(basis[:, :, None] * basis[:, None, :], axis=0)
    sides = np.cumsum(basis * (means - means.mean())[:, None], axis=0)
    at = np.arange(FEWEST - 1, count - FEWEST)
    explained = _explained(grams[at], sides[at])
    explained += _explained(grams[-1] - grams[at], sides[-1] - sides[at])
    return (int(at[np.argmax(explained)]) + 1) * each


def _explained(grams: FloatArray, sides: FloatArray) -> FloatArray:
    """Return the sums of squares that the best of linear models explain."""
    return np.einsum("ni,ni->n", sides, np.linalg.solve(grams, sides[..., None])[..., 0])


def _slope(position: FloatArray, force: FloatArray) -> tuple[float, float]:
    """Return the slope of a force over a position, and its standard deviation [N/m]."""
    at = position - position.mean()
    size = float(at @ at)
    slope = float(at @ force) / size
    left = force - force.mean() - slope * at
    return slope, float(np.sqrt(left @ left / ((at.size - 2) * size)))
