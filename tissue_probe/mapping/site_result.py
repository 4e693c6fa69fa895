"""What was found at one visit of one site.

Contents: the result, and a list of them as ``Sites``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tissue_probe.mapping.sites import Sites
from tissue_probe.mapping.verdict import CellVerdict
from tissue_probe.signals import NANOSECONDS, Leaving


@dataclass(frozen=True)
class SiteResult:
    """One dwell; values are NaN where the verdict gives none.

    Attributes
    ----------
    site : int
        Number in its scan.
    repeat : int
        How often the place was visited before.
    stamp : int
        When the dwell began [ns since the epoch].
    position, normal : (float, float, float)
        On the tissue's surface [m], and the surface's outward normal.
    stiffness, stiffness_stddev : float
        k and its standard deviation, with the spread between the filters [N/m].
    damping, damping_stddev : float
        beta and its standard deviation [N s/m].
    covariance_trace : float
        Trace of the filters' covariance, units mixed as in the paper.
    verdict : Verdict
        Why there is a value, or none.
    leaving : Leaving
        Why the dwell ended; UNTOLD while it goes on.
    """

    site: int
    repeat: int
    stamp: int
    position: tuple[float, float, float]
    normal: tuple[float, float, float]
    stiffness: float
    damping: float
    covariance_trace: float
    stiffness_stddev: float
    damping_stddev: float
    verdict: CellVerdict
    leaving: Leaving

    @property
    def has_value(self) -> bool:
        """Whether it tells a stiffness."""
        return math.isfinite(self.stiffness)


def sites_of(results: Sequence[SiteResult]) -> Sites:
    """Return the sites of these results; times are in s since the first."""
    place = np.array([result.position for result in results], dtype=float).reshape(-1, 3)
    stamps = np.array([result.stamp for result in results], dtype=np.int64)
    since = stamps - (stamps.min() if stamps.size else 0)
    k, k_sd = (
        np.array([getattr(result, name) for result in results], dtype=float)
        for name in ("stiffness", "stiffness_stddev")
    )
    x, y, z = place.T
    return Sites(x, y, z, since / NANOSECONDS, k, k_sd)
