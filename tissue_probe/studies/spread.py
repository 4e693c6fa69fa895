"""How a value spreads over specimens and over repeats, beside the error that each recording states.

y = X b + u + w + e: group means b, a specimen's own u ~ N(0, between^2), a repeat's own
w ~ N(0, within^2), and the recording's error e ~ N(0, sd^2), whose sd it states. The two spreads
have the restricted likelihood (D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320) and each the
prior of Jeffreys, beside which the posterior's intervals hold as often as they say (G. C. Tiao, W.
Y. Tan, Biometrika 52 (1965) 37, of a balanced study); with a flat one those of few specimens lie
too high. Intervals are those of the posterior, over a grid of both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import norm

from tissue_probe.errors import ParameterError
from tissue_probe.quantities import SIDE
from tissue_probe.signals import FloatArray, IntArray

#: Points of a grid along each spread; there are two, a wide and a fine one.
_POINTS = 32
#: The grid ends at so many times the spread of all values, and begins at so much of it.
_WIDEST, _LEAST = 10.0, 1e-3
#: States of less weight, of the largest, tell nothing.
_NEGLIGIBLE = 1e-6
#: What two repeats differ by in 95 % of the cases, over the spread of one.
_DETECTABLE = SIDE * np.sqrt(2.0)


@dataclass(frozen=True)
class Interval:
    """A value, and the ends of its 95 % interval."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.4g} ({self.low:.4g} to {self.high:.4g})"


@dataclass(frozen=True)
class Spread:
    """The spread of a value, in its own unit.

    Attributes
    ----------
    recordings, specimens : int
        How many there are.
    means : dict of str to Interval
        Of each group; of all where there are no groups.
    contrasts : dict of (str, str) to Interval
        The second group's mean less the first's.
    between : Interval
        Standard deviation over specimens.
    within : Interval
        Standard deviation over repeats on one specimen, beyond the recordings' own errors.
    reliability : Interval
        Intraclass correlation: the part of the variance of a repeat that is the specimens'.
    measurement_error : Interval
        Standard error of measurement: of one repeat, its own typical error included.
    detectable : float
        The smallest change of one specimen between two repeats that chance makes in 5 % at most.
    borrowed : array, shape (recordings,)
        Each recording's value with what its specimen and group tell of it.
    borrowed_sd : array, shape (recordings,)
        Its standard deviation.
    """

    recordings: int
    specimens: int
    means: dict[str, Interval]
    contrasts: dict[tuple[str, str], Interval]
    between: Interval
    within: Interval
    reliability: Interval
    measurement_error: Interval
    detectable: float
    borrowed: FloatArray
    borrowed_sd: FloatArray

    @property
    def text(self) -> str:
        """All of it in lines, 95 % intervals in brackets."""
        lines = [f"{self.recordings} recordings of {self.specimens} specimens; 95 % intervals"]
        for name, mean in self.means.items():
            lines.append(f"mean of {name}: {mean}" if name else f"mean: {mean}")
        lines += [f"{b} less {a}: {told}" for (a, b), told in self.contrasts.items()]
        return "\n".join(
            [
                *lines,
                f"between specimens (sd): {self.between}",
                f"within a specimen (sd): {self.within}",
                f"reliability (ICC): {self.reliability}",
                f"standard error of measurement: {self.measurement_error}",
                f"smallest detectable change: {self.detectable:.4g}",
            ]
        )

    def __repr__(self) -> str:
        return self.text


def spread_of(
    values: FloatArray,
    deviations: FloatArray,
    specimens: Sequence[str],
    groups: Sequence[str] | None = None,
) -> Spread:
    """Return the spread of values.

    Parameters
    ----------
    values, deviations : array, shape (n,)
        One a recording, with the standard deviation of its error.
    specimens : sequence of str, length n
        Of which specimen each is.
    groups : sequence of str, optional
        Of which group; a specimen may be in several.

    Raises
    ------
    ParameterError
        If there are fewer than three specimens, or none was measured twice.
    """
    names, of = np.unique(np.asarray(specimens, dtype=str), return_inverse=True)
    if names.size < 3:
        raise ParameterError(
            f"{names.size} specimens tell no spread between specimens: give three or more"
        )
    if names.size == len(values):
        raise ParameterError(
            "each specimen was measured once: without repeats the spread within a specimen is not "
            "told from that between them"
        )
    kinds, group = np.unique(
        np.asarray(groups if groups is not None else len(values) * [""], dtype=str),
        return_inverse=True,
    )
    design = np.eye(kinds.size)[group]
    return _Posterior(values, deviations, of, design).spread(list(map(str, kinds)))


def _around(likely: FloatArray, axis: FloatArray) -> FloatArray:
    """Return a fine axis over the likely part of a coarse one, and one cell beyond."""
    first, last = np.searchsorted(axis, [likely.min(), likely.max()])
    return np.geomspace(axis[max(first - 1, 0)], axis[min(last + 1, axis.size - 1)], _POINTS)


def _log_prior(
    between: float, within: float, of_specimens: FloatArray, of_rows: FloatArray
) -> float:
    """Return the log prior of both spreads: each one's Fisher information, its root.

    ``of_specimens`` and ``of_rows`` are the inverse variances of a specimen's mean about its own
    value, and of a recording about its specimen's.
    """
    of_means = of_specimens / (1.0 + between**2 * of_specimens)
    return float(
        np.log(between)
        + 0.5 * np.log((of_means**2).sum())
        + np.log(within)
        + 0.5 * np.log((of_rows**2).sum())
    )


class _Posterior:
    """The states of both spreads, with their weights, and what follows at each."""

    def __init__(
        self, values: FloatArray, deviations: FloatArray, of: IntArray, design: FloatArray
    ) -> None:
        # Values are in units of their own spread, so that the grid fits any.
        self._unit = float(np.std(values)) or float(np.max(deviations)) or 1.0
        self._y, self._sd = values / self._unit, deviations / self._unit
        self._of, self._design, self._count = of, design, int(of.max()) + 1
        axis = np.geomspace(_LEAST, _WIDEST, _POINTS)
        self._weigh(axis, axis)
        # Anew where it is likely: of a large study that is a small part.
        self._weigh(*(_around(each, axis) for each in (self._between, self._within)))

    def _weigh(self, between: FloatArray, within: FloatArray) -> None:
        """Keep the likely states of a grid, and what follows at each."""
        cells = np.log(np.outer(np.gradient(within), np.gradient(between))).ravel()
        b, w = (each.ravel() for each in np.meshgrid(between, within))
        found = [self._at(*each) for each in zip(b, w, strict=True)]
        log_weight = cells + np.array([each[0] for each in found])
        weight = np.exp(log_weight - log_weight.max())
        likely = np.flatnonzero(weight > _NEGLIGIBLE)
        self._weight = weight[likely] / weight[likely].sum()
        self._between, self._within = b[likely], w[likely]
        self._means = np.array([found[i][1] for i in likely])
        self._covariances = np.array([found[i][2] for i in likely])

    def _at(self, between: float, within: float) -> tuple[float, FloatArray, FloatArray]:
        """Return log posterior, group means and their covariance at two spreads."""
        w = 1.0 / (self._sd**2 + within**2)
        total: FloatArray = np.bincount(self._of, w, self._count).astype(float)
        share = between**2 / (1.0 + between**2 * total)

        def product(a: FloatArray, b: FloatArray) -> float:
            """Return a' V^-1 b; V is a diagonal and one square a specimen (Woodbury)."""
            sums = [np.bincount(self._of, w * each, self._count) for each in (a, b)]
            return float((w * a * b).sum() - (share * sums[0] * sums[1]).sum())

        columns = self._design.T
        information = np.array([[product(a, b) for b in columns] for a in columns])
        covariance = np.linalg.inv(information)
        mean = covariance @ np.array([product(a, self._y) for a in columns])
        left = self._y - self._design @ mean
        log_determinant = -np.log(w).sum() + np.log1p(between**2 * total).sum()
        log = -0.5 * (log_determinant + np.linalg.slogdet(information)[1] + product(left, left))
        return log + _log_prior(between, within, total, w), mean, covariance

    def spread(self, names: list[str]) -> Spread:
        """Return all that is told."""
        typical = float(np.median(self._sd))
        error = np.hypot(self._within, typical)
        reliability = self._between**2 / np.maximum(self._between**2 + error**2, 1e-300)
        pairs = [(i, j) for i in range(len(names)) for j in range(i + 1, len(names))]
        unit = np.eye(len(names))
        borrowed, borrowed_sd = self._borrowed()
        sem = self._interval(error, self._unit)
        return Spread(
            self._y.size,
            self._count,
            {name: self._linear(unit[i]) for i, name in enumerate(names)},
            {(names[i], names[j]): self._linear(unit[j] - unit[i]) for i, j in pairs},
            self._interval(self._between, self._unit),
            self._interval(self._within, self._unit),
            self._interval(reliability, 1.0),
            sem,
            float(_DETECTABLE * sem.value),
            borrowed,
            borrowed_sd,
        )

    def _interval(self, states: FloatArray, unit: float) -> Interval:
        """Return median and 95 % interval of a function of the spreads."""
        # Many states of the grid have one value of a function of one spread alone.
        points, place = np.unique(states, return_inverse=True)
        weight = np.bincount(place, self._weight)
        low, middle, high = np.interp([0.025, 0.5, 0.975], np.cumsum(weight) - 0.5 * weight, points)
        return Interval(float(unit * middle), float(unit * low), float(unit * high))

    def _linear(self, weights: FloatArray) -> Interval:
        """Return mean and 95 % interval of a sum of group means: of a mixture of normals."""
        middles = self._means @ weights
        sds = np.sqrt(np.einsum("i,sij,j->s", weights, self._covariances, weights))
        low, high = middles.min() - 12.0 * sds.max(), middles.max() + 12.0 * sds.max()

        def quantile(share: float) -> float:
            return float(
                brentq(lambda x: self._weight @ norm.cdf(x, middles, sds) - share, low, high)
            )

        ends = (float(self._weight @ middles), quantile(0.025), quantile(0.975))
        return Interval(*(self._unit * each for each in ends))

    def _borrowed(self) -> tuple[FloatArray, FloatArray]:
        """Return each recording's own value given all, and its standard deviation."""
        mean, square, total = np.zeros(self._y.size), np.zeros(self._y.size), 0.0
        states = zip(
            self._weight, self._between, self._within, self._means, self._covariances, strict=True
        )
        for weight, *state in states:
            if weight < 1e-3 * self._weight.max():
                continue
            middle, variance = self._borrowed_at(*state)
            mean += weight * middle
            square += weight * (variance + middle**2)
            total += weight
        mean, square = mean / total, square / total
        return self._unit * mean, self._unit * np.sqrt(np.maximum(square - mean**2, 0.0))

    def _borrowed_at(
        self, between: float, within: float, group: FloatArray, covariance: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the same at two spreads, with its variance.

        A recording's value is X b + u + w. Given u, its part of the rest is w^2 / (w^2 + sd^2); u
        is drawn to nothing by its own spread; b has the covariance of the group means.
        """
        variance = self._sd**2 + within**2
        kept = self._sd**2 / variance
        share = between**2 / (1.0 + between**2 * np.bincount(self._of, 1.0 / variance, self._count))

        def specimen(values: FloatArray) -> FloatArray:
            """Return what the recordings of a specimen tell of it, a value a recording."""
            told = share * np.bincount(self._of, values / variance, self._count)
            return np.asarray(told[self._of], dtype=float)

        left = self._y - self._design @ group
        middle = self._y - kept * (left - specimen(left))
        # By how much a group's mean counts in a recording's value.
        counts = (
            kept[:, None] * np.array([column - specimen(column) for column in self._design.T]).T
        )
        of_means = np.einsum("ni,ij,nj->n", counts, covariance, counts)
        return middle, within**2 * kept + kept**2 * share[self._of] + of_means
