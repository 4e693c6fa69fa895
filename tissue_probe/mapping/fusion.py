"""What several estimators found at each site, fused into one map.

What belongs here: which estimates count for which cell, and how the estimators' values become one.
What does not: interpolation between cells (``surface``).

Within a dwell the latest converged estimate of each estimator counts. A filter without forgetting
has put every earlier sample into it, and its variance is the variance of that very estimate; an
average over the converged part would be no better, and no variance would be known for it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.stiffness_map import StiffnessMapData
from tissue_probe.signals import FloatArray, PalpationSite, Phase, Status, TissueEstimates

_OPEN_END = int(np.iinfo(np.int64).max)


class Estimate(NamedTuple):
    """What one estimator found at one site; units as in ``TissueEstimates``."""

    stamp: int
    stiffness: float
    damping: float
    covariance_trace: float
    stiffness_variance: float
    damping_variance: float

    def is_usable(self) -> bool:
        """Whether all is finite and both variances are positive: nothing else has a weight."""
        return (
            0.0 < self.stiffness_variance < math.inf
            and 0.0 < self.damping_variance < math.inf
            and math.isfinite(self.stiffness)
            and math.isfinite(self.damping)
            and math.isfinite(self.covariance_trace)
        )


def inverse_variance_weights(variance: FloatArray) -> FloatArray:
    """Return w_i = (1 / variance_i) / sum_j (1 / variance_j), shape (n,).

    Parameters
    ----------
    variance : array, shape (n,)
        Positive and finite, in any one unit.
    """
    relative = variance.min() / variance  # never overflows, as 1 / variance could
    return relative / relative.sum()


def fused_stddev(weights: FloatArray, variance: FloatArray) -> float:
    """Return sigma = sum_i w_i sqrt(variance_i), the bound for fully correlated errors.

    The estimators saw the same samples with the same noise, so their errors are nearly the same
    error, and more estimators do not make it smaller. The weighted sum of the standard deviations
    is never too small, whatever the correlation; 1 / sqrt(sum_i 1 / variance_i) would be.
    """
    return float(weights @ np.sqrt(variance))


@dataclass(slots=True, eq=False)
class _Dwell:
    """One stay at one cell, from ``begin`` up to, not including, ``end`` [ns since the epoch]."""

    visit: int
    cell: tuple[int, int]
    begin: int
    end: int = _OPEN_END
    latest: dict[str, Estimate] = field(default_factory=dict)


class MapBuilder:
    """Gathers estimates site by site and fuses them into a map.

    An announcement holds from its stamp on and replaces whatever was announced before for later
    times; so a scan may announce phases ahead and be cut short, and a replay may begin again. An
    estimate counts for the dwell that its stamp falls into, however late it arrives.

    A cell that is visited again keeps its values until an estimator has converged in the new
    dwell; then the new dwell alone counts, since the tissue may have changed in between. A cell in
    which no estimator ever converged stays NaN.

    Parameters
    ----------
    grid : Grid
        The cells of the map.

    Attributes
    ----------
    revision : int
        Rises with every change of the map; whoever publishes the map compares it with the revision
        published last.
    """

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self.revision = 0
        self._visits = 0
        self._dwells: list[_Dwell] = []  # by rising begin
        self._cells: dict[tuple[int, int], _Dwell] = {}

    def announce(self, site: PalpationSite) -> None:
        """Note where the probe is; the cell is the one nearest to the announced position.

        Raises
        ------
        ValueError
            If a dwell is announced outside the grid. The dwell before has then ended all the same,
            and estimates of the dwell outside are not counted for any cell.
        """
        self._dwells = [dwell for dwell in self._dwells if dwell.begin < site.stamp]
        if self._dwells:
            self._dwells[-1].end = min(self._dwells[-1].end, site.stamp)
        if site.phase == Phase.DWELL:
            self._visits += 1
            cell = self.grid.nearest(site.position)
            self._dwells.append(_Dwell(self._visits, cell, site.stamp))

    def add(self, estimates: TissueEstimates) -> None:
        """Take estimates of one estimator, in any order.

        Left out are those that have not converged, that lack a finite value or a positive
        variance, or that were made outside every dwell.
        """
        converged = estimates[estimates.status == Status.CONVERGED]
        for dwell in self._dwells:
            rows = np.flatnonzero((converged.stamp >= dwell.begin) & (converged.stamp < dwell.end))
            newest_first = rows[np.argsort(-converged.stamp[rows], kind="stable")]
            candidates = (_row(converged, row) for row in newest_first)
            latest = next((found for found in candidates if found.is_usable()), None)
            if latest is not None:
                self._take(dwell, estimates.estimator, latest)

    def add_one(self, estimator: str, status: int, estimate: Estimate) -> None:
        """Take one estimate as ``add`` does; cheap enough for every message of a live run."""
        if status != Status.CONVERGED or not estimate.is_usable():
            return
        for dwell in reversed(self._dwells):
            if estimate.stamp >= dwell.begin:
                if estimate.stamp < dwell.end:
                    self._take(dwell, estimator, estimate)
                return

    def _take(self, dwell: _Dwell, estimator: str, estimate: Estimate) -> None:
        known = dwell.latest.get(estimator)
        if known is not None and known.stamp >= estimate.stamp:
            return
        shown = self._cells.get(dwell.cell)
        if shown is not None and shown.visit > dwell.visit:
            return
        dwell.latest[estimator] = estimate
        self._cells[dwell.cell] = dwell
        self.revision += 1

    def map(self) -> StiffnessMapData:
        """Return the map as known now, each cell fused over its estimators.

        Stiffness and damping are averaged by inverse variance, each by its own; the covariance
        trace with the weights of the stiffness. For the standard deviations see ``fused_stddev``.
        """
        layers = np.full((5, *self.grid.shape), np.nan)
        stamp = 0
        for (row, column), dwell in self._cells.items():
            layers[:, row, column] = _fuse(dwell.latest)
            stamp = max(stamp, *(estimate.stamp for estimate in dwell.latest.values()))
        return StiffnessMapData(self.grid, stamp, *layers)


def _row(estimates: TissueEstimates, row: int) -> Estimate:
    return Estimate(*(getattr(estimates, name)[row].item() for name in Estimate._fields))


def _fuse(estimates: dict[str, Estimate]) -> tuple[float, float, float, float, float]:
    """Return stiffness, damping, covariance trace, stddev of stiffness and of damping."""
    # Sorted, so that the order of arrival does not show in the last digit.
    _, stiffness, damping, trace, stiffness_variance, damping_variance = np.array(
        [estimates[name] for name in sorted(estimates)]
    ).T
    stiffness_weights = inverse_variance_weights(stiffness_variance)
    damping_weights = inverse_variance_weights(damping_variance)
    return (
        stiffness_weights @ stiffness,
        damping_weights @ damping,
        stiffness_weights @ trace,
        fused_stddev(stiffness_weights, stiffness_variance),
        fused_stddev(damping_weights, damping_variance),
    )
