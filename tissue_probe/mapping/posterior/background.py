"""The tissue between inclusions: trend over place, drift over time, correlated variation, noise.

Contents: the covariance of log k at the sites without inclusions, for every level of variation that
is thought of.

Trend and drift are linear in coefficients with normal priors, which are integrated out: they add
to the covariance. Variation and noise have unknown size and length; a grid of both is laid, each
point of which has its precision matrix, computed once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.distance import cdist

from tissue_probe.mapping.kernel import correlate_places
from tissue_probe.mapping.posterior.outliers import VARIANCES, ErrorKinds, with_outliers
from tissue_probe.signals import FloatArray, IntArray

#: Standard deviations of the coefficients of log k: level, tilt from middle to edge, curvature.
#: A tilt of 50 % and a curvature of 10 % are ordinary.
_LEVEL, _TILT, _CURVATURE = 1.0, 0.4, 0.1
#: Tissue does not tilt as much over less [mm].
_LEAST_HALF = 5.0
#: Tissue relaxes by tens of per cent, at rates that are not known.
_DRIFT = 0.2
#: Times of relaxation over the time of the whole scan.
_RELAXATION = (0.12, 0.5)


@dataclass(frozen=True)
class Levels:
    """How large variation and noise may be, and how far variation is correlated.

    Attributes
    ----------
    sizes : array
        Standard deviations of variation and noise together, relative to k.
    kinds : tuple of (float, float, float)
        Share of the variance that is correlated over place, its length [mm], and prior weight.
    usual : float
        Mean of the exponential prior of the sizes, whose grid is one of their logs.
    """

    sizes: FloatArray
    kinds: tuple[tuple[float, float, float], ...]
    usual: float

    def size(self, level: int) -> float:
        """Return the standard deviation of a level."""
        return float(self.sizes[level % self.sizes.size])

    def kind(self, level: int) -> tuple[float, float]:
        """Return correlated share and length [mm] of a level."""
        share, length, _ = self.kinds[level // self.sizes.size]
        return share, length


#: 0.1 % is finer than any filter, 20 % ruins every map. Sizes are some per cent, or nodules would
#: be taken for variation.
ORDINARY = Levels(
    np.geomspace(0.001, 0.2, 14),
    ((0.0, 1.0, 0.4), (0.8, 3.0, 0.3), (0.8, 8.0, 0.3)),
    usual=0.02,
)


@dataclass(frozen=True)
class Trend:
    """The trend of log k: level in the middle with its error, tilt [1/mm], and drift."""

    level: float
    level_sd: float
    tilt: tuple[float, float]
    drift: float


@dataclass(frozen=True)
class Background:
    """The covariance of log k without inclusions, at each level of variation.

    Attributes
    ----------
    x, y : array, shape (n,)
        The sites [mm].
    levels : Levels
        Whose precisions are here, in the order of kinds, and of sizes within each.
    precision : array, shape (levels, n, n)
        Inverse covariances.
    log_weight : array, shape (levels,)
        Half the log determinant of each precision, and the log of its prior.
    """

    x: FloatArray
    y: FloatArray
    levels: Levels
    precision: FloatArray
    log_weight: FloatArray
    _middle: FloatArray
    _half: float
    _trend: FloatArray
    _drift: FloatArray

    @staticmethod
    def of(
        x: FloatArray,
        y: FloatArray,
        t: FloatArray | None,
        noise: FloatArray,
        levels: Levels = ORDINARY,
    ) -> Background:
        """Lay the grid of levels for sites at x, y [mm], times t [s], known noise of log k."""
        corners = np.array([[x.min(), x.max()], [y.min(), y.max()]])
        middle, half = (
            corners.mean(axis=1),
            max(float(np.ptp(corners, axis=1).max()) / 2.0, _LEAST_HALF),
        )
        trend = _trend(x, y, middle, half)
        known = trend @ trend.T + np.diag(noise**2)
        drift = _drift(t) if t is not None and np.ptp(t) > 0.0 else np.zeros((x.size, 1))
        known += drift @ drift.T
        distance = cdist(np.column_stack([x, y]), np.column_stack([x, y]))
        precision, weight = [], []
        for share, length, prior in levels.kinds:
            varied = share * correlate_places(distance / length) + (1.0 - share) * np.eye(x.size)
            for size in levels.sizes:
                factor = cho_factor(known + size**2 * varied, lower=True)
                precision.append(cho_solve(factor, np.eye(x.size)))
                weight.append(
                    np.log(prior) - size / levels.usual - np.log(np.diag(factor[0])).sum()
                )
        return Background(
            x, y, levels, np.array(precision), np.array(weight), middle, half, trend, drift
        )

    def cross(self, level: int, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return covariances of the background at places [mm] with the sites, and variances.

        Shapes (places, n) and (places,), at one level: of the tissue, without noise and drift.
        """
        share, length = self.levels.kind(level)
        size = self.levels.size(level)
        trend = _trend(self.x, self.y, self._middle, self._half)
        there = _trend(x, y, self._middle, self._half)
        distance = cdist(np.column_stack([x, y]), np.column_stack([self.x, self.y]))
        shared = there @ trend.T + share * size**2 * correlate_places(distance / length)
        return shared, (there**2).sum(axis=1) + share * size**2

    def precision_of(self, level: int, kinds: ErrorKinds) -> FloatArray:
        """Return the precision at one level, of sites that err as ``kinds`` say."""
        sound: FloatArray = self.precision[level]
        if not kinds.any():
            return sound
        precision = np.empty_like(sound)
        with_outliers(sound, kinds, precision)
        return precision

    def predict_background(
        self, level: IntArray, kinds: ErrorKinds, log_k: FloatArray, x: FloatArray, y: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return mean and variance of the background at places [mm], as the sites tell it.

        Both have shape (states, places).

        Parameters
        ----------
        level : array, shape (states,)
            Of each state.
        kinds : array, shape (states, n)
            How each site errs in each state.
        log_k : array, shape (states, n)
            Of the sites, less that of inclusions.
        x, y : array, shape (places,)
            The places [mm].
        """
        mean, variance = (np.empty((level.size, x.size)) for _ in range(2))
        for used in np.unique(level):
            here = np.flatnonzero(level == used)
            precision = self.precision[used]
            cross, own = self.cross(int(used), x, y)
            explained = cross @ precision
            mean[here] = log_k[here] @ explained.T
            variance[here] = own - (explained * cross).sum(axis=1)
            for state in here[kinds[here].any(axis=1)]:
                at = np.flatnonzero(kinds[state])
                through = explained[:, at]
                spread = np.diag(1.0 / VARIANCES[kinds[state, at]]) + precision[np.ix_(at, at)]
                lost = np.linalg.solve(spread, through.T)
                mean[state] -= (precision[at] @ log_k[state]) @ lost
                variance[state] += (through.T * lost).sum(axis=0)
        return mean, np.maximum(variance, 0.0)

    def trend(self, level: int, kinds: ErrorKinds, log_k: FloatArray) -> Trend:
        """Return the trend through log k of the sites, less that of inclusions, in one state."""
        precision = self.precision_of(level, kinds)
        weighted = precision @ log_k
        coefficients = self._trend.T @ weighted
        column = self._trend[:, 0]
        # Of a coefficient with prior variance 1, given the sites.
        left = 1.0 - float(column @ precision @ column)
        at_first = int(np.abs(self._drift).sum(axis=1).argmax())
        drift = self._drift[at_first] @ (self._drift.T @ weighted)
        along_x, along_y = (_TILT * float(each) / self._half for each in coefficients[1:3])
        return Trend(
            _LEVEL * float(coefficients[0]),
            _LEVEL * math.sqrt(max(left, 0.0)),
            (along_x, along_y),
            float(drift),
        )


def _trend(x: FloatArray, y: FloatArray, middle: FloatArray, half: float) -> FloatArray:
    u, v = (x - middle[0]) / half, (y - middle[1]) / half
    ones = np.ones_like(u)
    bent = [_CURVATURE * product for product in (u**2, u * v, v**2)]
    return np.column_stack([_LEVEL * ones, _TILT * u, _TILT * v, *bent])


def _drift(t: FloatArray) -> FloatArray:
    since = (t - t.min()) / np.ptp(t)
    # Zero at the end of the scan: the map is of the tissue as it was left.
    return np.column_stack(
        [_DRIFT * (np.exp(-since / tau) - np.exp(-1.0 / tau)) for tau in _RELAXATION]
    )
