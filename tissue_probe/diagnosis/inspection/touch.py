"""Where the tip touches, in a record that begins in the air.

Contents: finding the first touch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import legvander

from tissue_probe.signals import FloatArray

#: A force is felt from so many standard deviations of its noise on, in so many samples in a row.
FELT, IN_A_ROW = 4.0, 4
#: In the air the force changes by at most this share of its rise over as long a way after the
#: touch, doubt included, and swings beyond its noise by no more. By the softest law of contact, a
#: cone's square, the share is a third.
FLAT = 0.1
#: Samples that tell a slope, and a mean.
FEWEST_IN_SLOPE = 16
#: The way into the tissue ends where the tip goes back by such a share of its range: before cycles
#: that are small beside the way there, or, where a hand shakes more than that, before wide ones.
BACK = (0.05, 0.5)
#: Share of the samples before a touch that count as air. The force of a soft tissue may still be
#: below ``FELT`` standard deviations in the last tenth.
AIR_SHARE = 0.9
#: Degree of the zero's course in time: a cubic follows a zero that settles for two and a half time
#: constants to a hundredth of its fall.
DRIFT = 3
#: The end of that course is sought first in the means of so many spans, so to a thousandth of the
#: way. The first sample that feels the tissue is then sought in all samples.
COURSE_BLOCKS = 1000
#: Relative size from which on a direction of the normal equations is more than their rounding, the
#: root of which is that of the polynomials.
ROUNDED_DIRECTION = 1e-12


@dataclass(frozen=True)
class FirstTouch:
    """The first touch.

    Attributes
    ----------
    sample : int
        Number of the last sample in the air.
    position : float
        There [m].
    zero : float
        Force there, which is of no tissue [N]; 0 where that may be, too.
    """

    sample: int
    position: float
    zero: float


def first_touch(position: FloatArray, force: FloatArray, noise: float) -> FirstTouch | None:
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
    for back in BACK:
        found = _find_touch(position, force, _first_way(position, back), noise)
        if found is not None:
            return found
    return None


def _first_way(position: FloatArray, back: float) -> int:
    """Count the samples until the tip is farthest, before it goes back by a share of its range."""
    farthest = np.maximum.accumulate(position)
    gone = farthest - position > back * np.ptp(position)
    until = int(np.argmax(gone)) if gone.any() else position.size
    return int(np.argmax(position[:until])) + 1


def _find_touch(
    position: FloatArray, force: FloatArray, until: int, noise: float
) -> FirstTouch | None:
    """Find a touch before a sample."""
    changed = _change(position[:until], force[:until])
    if changed is None:
        return None
    time = np.arange(until) / changed
    course = Polynomial.fit(time[:changed], force[:changed], DRIFT)
    left = np.abs(force[:until] - course(time))
    least = np.finfo(float).tiny  # of a simulation that has no noise
    usual = max(noise, float(np.sqrt(np.mean(left[:changed] ** 2))), least)
    rows = np.convolve(left > FELT * usual, np.ones(IN_A_ROW), mode="valid") == IN_A_ROW
    last = int(np.argmax(rows)) - 1 if rows.any() else -1
    way = position[last] - position[0] if last > 0 else 0.0
    beyond = np.flatnonzero(position[last:until] > position[last] + way)
    after = last + int(beyond[0]) if beyond.size else until
    if last < FEWEST_IN_SLOPE or after - last < FEWEST_IN_SLOPE or way <= 0.0:
        return None
    if np.ptp(position[last:after]) == 0.0:  # a tip at rest comes from nowhere
        return None
    slope, doubt = _slope(position[: last + 1], force[: last + 1])
    rises = float(force[after - FEWEST_IN_SLOPE : after].mean() - course(time[last]))
    swing = float(np.sqrt(usual**2 - noise**2)) if usual > noise else 0.0
    if not max((abs(slope) + 2.0 * doubt) * way, swing) < FLAT * rises:
        return None
    return FirstTouch(last, float(position[last]), _zero(force[: last + 1], usual))


def _zero(force: FloatArray, noise: float) -> float:
    """Return the zero of a force at the end of its samples in the air; 0 where it may be that.

    By a course of the likeliest degree (G. Schwarz, Ann. Statist. 6 (1978), 461), of the samples
    that are sure to be in the air: a soft tissue is not felt at once.
    """
    time = np.linspace(0.0, 1.0, force.size)
    sure = force[: max(int(AIR_SHARE * force.size), FEWEST_IN_SLOPE // 2)]
    basis = [np.vander(time, degree + 1) for degree in range(DRIFT + 1)]
    fits = [np.linalg.lstsq(each[: sure.size], sure, rcond=None)[0] for each in basis]
    left = [
        np.sum((sure - each[: sure.size] @ fit) ** 2) for each, fit in zip(basis, fits, strict=True)
    ]
    # The noise is known: a further degree must lower the sum of squares by more than it.
    degree = int(np.argmin(np.array(left) / noise**2 + np.arange(len(left)) * np.log(sure.size)))
    there, chosen = basis[degree][-1], basis[degree][: sure.size]
    zero = float(there @ fits[degree])
    doubt = noise * np.sqrt(there @ np.linalg.inv(chosen.T @ chosen) @ there)
    return zero if abs(zero) > FELT * doubt else 0.0


def _change(position: FloatArray, force: FloatArray) -> int | None:
    """Return the sample at which two courses part best: a polynomial in time, then in the way.

    In the air the zero drifts in time; in contact the force goes by how deep the tip is, whether
    its way there is even or not.
    """
    each = max(1, force.size // COURSE_BLOCKS)
    count = force.size // each
    if count < 2 * FEWEST_IN_SLOPE:
        return None
    means, way = (
        signal[: count * each].reshape(-1, each).mean(axis=1) for signal in (force, position)
    )
    means -= means.mean()
    air = _sums(np.linspace(-1.0, 1.0, count), means)
    tissue = _sums(2.0 * (way - way.min()) / (np.ptp(way) or 1.0) - 1.0, means)
    at = np.arange(FEWEST_IN_SLOPE - 1, count - FEWEST_IN_SLOPE)
    explained = _sum_explained(*(each[at] for each in air))
    explained += _sum_explained(*(each[-1] - each[at] for each in tissue))
    return (int(at[np.argmax(explained)]) + 1) * each


def _sums(over: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the running sums of the normal equations of a polynomial over -1 to 1."""
    basis = legvander(over, DRIFT)
    return (
        np.cumsum(basis[:, :, None] * basis[:, None, :], axis=0),
        np.cumsum(basis * values[:, None], axis=0),
    )


def _sum_explained(grams: FloatArray, sides: FloatArray) -> FloatArray:
    """Return the sums of squares that the best of linear models explain.

    A tip at rest tells nothing of the way: an unknown slope counts as none.
    """
    inverse = np.linalg.pinv(grams, rcond=ROUNDED_DIRECTION, hermitian=True)
    explained: FloatArray = np.einsum("ni,nij,nj->n", sides, inverse, sides)
    return explained


def _slope(position: FloatArray, force: FloatArray) -> tuple[float, float]:
    """Return the slope of a force over a position, and its standard deviation [N/m]."""
    at = position - position.mean()
    size = float(at @ at)
    slope = float(at @ force) / size
    left = force - force.mean() - slope * at
    return slope, float(np.sqrt(left @ left / ((at.size - 2) * size)))
