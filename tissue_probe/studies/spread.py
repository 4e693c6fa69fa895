"""How a value spreads over specimens and over repeats, beside the error that each recording states.

y = X b + u + w + e: group means b, a specimen's own u ~ N(0, between^2), a repeat's own
w ~ N(0, within^2), and the recording's error e ~ N(0, sd^2), whose sd it states. The two spreads
have flat priors (A. Gelman, Prior distributions for variance parameters in hierarchical models,
Bayesian Analysis 1 (2006) 515) and the restricted likelihood (D. A. Harville, J. Am. Stat. Assoc.
72 (1977) 320); intervals are those of the posterior, over a grid of both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import norm

from tissue_probe.errors import ParameterError
from tissue_probe.signals import FloatArray, IntArray

#: Points of a grid along each spread; there are two, a wide and a fine one.
_POINTS = 32
#: The grid ends at so many times the spread of all values, and begins at so much of it.
_WIDEST, _LEAST = 10.0, 1e-3
#: States of less weight, of the largest, tell nothing.
_NEGLIGIBLE = 1e-6
#: What two repeats differ by in 95 % of the cases, over the spread of one.
_DETECTABLE = 1.96 * np.sqrt(2.0)


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
    return np.linspace(axis[max(first - 1, 0)], axis[min(last + 1, axis.size - 1)], _POINTS)


class _Posterior:
    """The states of both spreads, with their weights, and what follows at each."""

    def __init__(
        self, values: FloatArray, deviations: FloatArray, of: IntArray, design: FloatArray
    ) -> None:
        # Values are in units of their own spread, so that the grid fits any.
        self._unit = float(np.std(values)) or float(np.max(deviations)) or 1.0
        self._y, self._sd = values / self._unit, deviations / self._unit
        self._of, self._design, self._count = of, design, int(of.max()) + 1
        axis = np.concatenate([[0.0], np.geomspace(_LEAST, _WIDEST, _POINTS)])
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
        """Return log restricted likelihood, group means and their covariance at two spreads."""
        variance = self._sd**2 + within**2
        if variance.min() <= 0.0:
            return -np.inf, np.zeros(self._design.shape[1]), np.eye(self._design.shape[1])
        w = 1.0 / variance
        total = np.bincount(self._of, w, self._count)
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
        return log, mean, covariance

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
        order = np.argsort(states)
        below = np.cumsum(self._weight[order]) - 0.5 * self._weight[order]
        low, middle, high = np.interp([0.025, 0.5, 0.975], below, states[order])
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
        mean, square = np.zeros(self._y.size), np.zeros(self._y.size)
        same = self._of[:, None] == self._of[None, :]
        for weight, b, w, group in zip(
            self._weight, self._between, self._within, self._means, strict=True
        ):
            if weight < 1e-3 * self._weight.max():
                continue
            truth = b**2 * same + w**2 * np.eye(self._y.size)
            gain = np.linalg.solve(truth + np.diag(self._sd**2), truth).T
            middle = self._design @ group
            middle = middle + gain @ (self._y - middle)
            mean += weight * middle
            square += weight * (np.maximum(np.diag(truth - gain @ truth), 0.0) + middle**2)
        total = self._weight[self._weight >= 1e-3 * self._weight.max()].sum()
        mean, square = mean / total, square / total
        return self._unit * mean, self._unit * np.sqrt(np.maximum(square - mean**2, 0.0))
