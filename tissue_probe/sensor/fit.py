"""The fit: numbers that explain the wrench of all stretches best, with their covariance.

Gauss and Newton's steps from the best of a row of delays, after each of which the noise is whitened
anew. The weights of a cable's functions are 0 within a size of their own, which is taken where the
data are most probable (MacKay, Neural Computation 4, 1992): weights that the data do not ask for
vanish.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tissue_probe.sensor.belief import Belief, first_unrest, normal_equations
from tissue_probe.sensor.cable import CableFunctions
from tissue_probe.sensor.free_air import SIZES
from tissue_probe.sensor.noise import Colour, colour_of, white_noise
from tissue_probe.sensor.numbers import (
    BIAS_PLACES,
    CORE,
    DELAY_PLACE,
    LOAD,
    PRIOR_DEVIATIONS,
    RATE_PLACES,
    Point,
)
from tissue_probe.sensor.smoothed_air import FLOOR, LONGEST_SENSOR_DELAY, Smoothed
from tissue_probe.signals import FloatArray

DELAYS = np.arange(-0.5 * LONGEST_SENSOR_DELAY, LONGEST_SENSOR_DELAY + 1e-9, 0.005)
"""Where the search begins [s]: closer than a quarter of the filter's fastest period."""
STEPS_WITHOUT_CABLE = 6
"""After five the numbers change by less than a hundredth of their errors."""
STEPS_WITH_CABLE = 12
"""The sizes of the weights settle more slowly."""
LEAST_EVIDENCE = 5.0
"""More is left than noise where its variance is off by so many standard deviations."""


@dataclass(frozen=True)
class SensorFit:
    """The numbers, and the rest of the wrench.

    Attributes
    ----------
    belief : Belief
        Told for the middle of all stretches.
    left : list of arrays, each of shape (n, 6)
        The rest of each stretch's wrench, smoothed.
    evidence : float
        Logarithm of how probable the data are.
    expected : array, shape (6,)
        Variance of the rest that the noise of wrench and poses makes.
    """

    belief: Belief
    left: list[FloatArray]
    evidence: float
    expected: FloatArray


def fit(runs: Sequence[Smoothed], cable: CableFunctions | None = None) -> SensorFit:
    """Fit all stretches together.

    Parameters
    ----------
    runs : sequence of Smoothed
        Made with the same cable.
    cable : CableFunctions or None
        Whether a cable is part of it.
    """
    middle = float(np.concatenate([run.time for run in runs]).mean())
    point = _start(runs, middle, cable.count if cable else 0)
    colours: Sequence[Colour] = [white_noise(size) for size in SIZES]
    sizes = _Sizes(cable)
    for step in range(STEPS_WITH_CABLE if cable else STEPS_WITHOUT_CABLE):
        left, slopes = _left(runs, point)
        if step:
            axes = range(6)
            floors = FLOOR * SIZES
            colours = [colour_of([r[:, axis] for r in left], floors[axis]) for axis in axes]
        hessian, gradient = normal_equations(left, slopes, colours)
        precision = sizes.precision
        covariance = _inverse(hessian + np.diag(precision))
        values = point.values + covariance @ (gradient - precision * point.values)
        point = Point(values, middle)
        if step > 1:
            sizes.settle(values, covariance)
    left, _ = _left(runs, point)
    times = [run.time for run in runs]
    rates, errors = point.values[RATE_PLACES], covariance[RATE_PLACES, RATE_PLACES]
    unrest = first_unrest(rates, errors, times, left, colours)
    expected = _expected(runs, point)
    unexplained = _unexplained(left, expected)
    belief = Belief(point, covariance, tuple(colours), unrest, unexplained)
    return SensorFit(belief, left, _evidence(left, belief, precision), expected)


class _Sizes:
    """How large the weights of the cable's functions are: one size a group, of force and torque."""

    def __init__(self, cable: CableFunctions | None) -> None:
        self._members: list[FloatArray] = []
        if cable:
            for axes in (range(3), range(3, 6)):
                for group in cable.groups:
                    places = np.arange(group.start, group.stop)
                    rows = [CORE + axis * cable.count + places for axis in axes]
                    self._members.append(np.concatenate(rows))
        count = 6 * cable.count if cable else 0
        self.precision = np.concatenate([PRIOR_DEVIATIONS**-2.0, np.empty(count)])
        for number, members in enumerate(self._members):
            self.precision[members] = SIZES[0 if number < len(self._members) / 2 else 3] ** -2.0

    def settle(self, values: FloatArray, covariance: FloatArray) -> None:
        """Take for each group the size at which the data are more probable."""
        for members in self._members:
            precision = self.precision[members[0]]
            told = members.size - precision * np.trace(covariance[np.ix_(members, members)])
            square = max(float(np.sum(values[members] ** 2)), 1e-12)
            self.precision[members] = np.clip(told / square, 1e-6, 1e12)


def _start(runs: Sequence[Smoothed], middle: float, count: int) -> Point:
    """Return the best of a row of delays, by least squares of all that is linear then."""
    best: tuple[float, FloatArray] | None = None
    wrench = np.concatenate([run.wrench for run in runs]) / SIZES
    passed = np.concatenate([run.time for run in runs]) - middle
    fixed = np.stack([np.ones_like(passed), passed], axis=1)
    for delay in DELAYS:
        load = np.concatenate([run.load(delay) for run in runs]) / SIZES[:, None]
        found = _projected(load, wrench, fixed)
        rest = wrench - load @ found
        lines = np.linalg.lstsq(fixed, rest, rcond=None)[0]
        cost = float(np.sum((rest - fixed @ lines) ** 2))
        if best is None or cost < best[0]:
            values = np.zeros(CORE + 6 * count)
            values[LOAD], values[DELAY_PLACE] = found, delay
            values[BIAS_PLACES], values[RATE_PLACES] = lines[0] * SIZES, lines[1] * SIZES
            best = cost, values
    assert best is not None
    return Point(best[1], middle)


def _projected(load: FloatArray, wrench: FloatArray, fixed: FloatArray) -> FloatArray:
    """Return the load that fits best beside straight lines in time."""
    basis = np.linalg.qr(fixed)[0]
    flat = load.reshape(len(load), -1)
    columns = (flat - basis @ (basis.T @ flat)).reshape(-1, load.shape[2])
    values = (wrench - basis @ (basis.T @ wrench)).ravel()
    return np.asarray(np.linalg.lstsq(columns, values, rcond=1e-9)[0], float)


def _left(runs: Sequence[Smoothed], point: Point) -> tuple[list[FloatArray], list[FloatArray]]:
    made = [point.wrench(run) for run in runs]
    left = [run.wrench - wrench for run, (wrench, _) in zip(runs, made, strict=True)]
    return left, [slopes for _, slopes in made]


def _expected(runs: Sequence[Smoothed], point: Point) -> FloatArray:
    """Return the variance that the noise of wrench and poses leaves, shape (6,)."""
    parts = [run.in_band + run.noise_of_pose(point.values[LOAD]) for run in runs]
    return np.average(parts, axis=0, weights=[len(run.time) for run in runs])


def _unexplained(left: Sequence[FloatArray], expected: FloatArray) -> FloatArray:
    """Return the variance of the rest beyond that, shape (6,); 0 where it may be chance."""
    total = np.mean(np.concatenate(left) ** 2, axis=0)
    certain = 1.0 + LEAST_EVIDENCE * np.sqrt(2.0 / sum(map(len, left)))
    return np.where(total > certain * expected, total - expected, 0.0)


def _inverse(information: FloatArray) -> FloatArray:
    """Invert a matrix of numbers of very different sizes."""
    scale = 1.0 / np.sqrt(np.diagonal(information))
    return np.linalg.inv(information * scale[:, None] * scale) * scale[:, None] * scale


def _evidence(left: Sequence[FloatArray], belief: Belief, precision: FloatArray) -> float:
    """Return the logarithm of the data's probability, the numbers integrated out (Laplace)."""
    values = belief.point.values
    total = -0.5 * float(precision @ values**2) + 0.5 * float(np.sum(np.log(precision)))
    total += 0.5 * float(np.linalg.slogdet(belief.covariance)[1])
    for axis, colour in enumerate(belief.colours):
        for rest in left:
            white = colour.white(rest[:, axis])
            total -= 0.5 * float(white @ white) + white.size * np.log(colour.deviation)
    return total
