"""Sites that err far more than they state: a slip, a tip on an edge, a probe that was pushed.

Contents: how likely an outlier is, what it does to the precision, and the move that finds it.

An outlier has an extra variance of log k, one of a few. It changes the covariance by rank one, so
that the likelihood of another variance follows from the site's residual and diagonal element alone
(Sherman and Morrison). How large a share of the sites are outliers is integrated out.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from tissue_probe.mapping.posterior.moves import ChainState

#: How each site errs: the place of its variance in ``VARIANCES``.
ErrorKinds: TypeAlias = NDArray[np.int8]

#: Standard deviations of log k: from what the usual noise nearly explains to a factor of two.
OUTLIER_SIZES = (0.05, 0.1, 0.2, 0.4, 0.8)
#: Extra variance of a site, by its kind; sites of the first are no outliers.
VARIANCES = np.array([0.0, *(size**2 for size in OUTLIER_SIZES)])
#: Beta prior of the share: 1 % on average. As wide as one that is no surer than that allows, since
#: some instruments slip at none of a thousand sites, others at one of twenty.
SHARE_PRIOR = (1.0, 99.0)
#: A share that is stated is a beta prior as sure as that of so many sites.
_STATED = 1e12


def prior_of(share: float | None) -> np.ndarray:
    """Return the beta prior of the share of outliers: learnt where none is stated."""
    if share is None:
        return np.array(SHARE_PRIOR)
    return _STATED * np.array([share, 1.0 - share])


@njit(cache=True, nogil=True, error_model="numpy")
def log_odds_of_further(outliers: int, sites: int, prior: FloatArray) -> float:
    """Return the log odds of one more outlier, of a given kind, over none but those there are."""
    odds = (prior[0] + outliers) / (prior[1] + sites - outliers - 1.0)
    return math.log(odds / (VARIANCES.size - 1))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _add_variance(precision: FloatArray, i: int, variance: float) -> float:
    """Change a precision by an extra variance of a site; return the change of half its log det."""
    over = 1.0 + variance * precision[i, i]
    row, by = precision[i].copy(), variance / over
    for a in range(row.size):
        factor = by * row[a]
        if factor != 0.0:
            out = precision[a]
            for b in range(row.size):
                out[b] -= factor * row[b]
    return -0.5 * math.log(over)


@njit(cache=True, nogil=True, error_model="numpy")
def with_outliers(precision: FloatArray, kinds: ErrorKinds, out: FloatArray) -> float:
    """Write to ``out`` a precision with outliers; return the change of half its log determinant."""
    out[:] = precision
    change = 0.0
    for i in range(kinds.size):
        if kinds[i] > 0:
            change += _add_variance(out, i, VARIANCES[kinds[i]])
    return change


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def propose_errors(state: ChainState, beta: float, prior: FloatArray) -> None:
    """Propose to each site in turn another kind of error, each kind as often."""
    kinds, precision, residual = state.kinds, state.precision, state.residual
    sites, others, outliers = kinds.size, VARIANCES.size - 1, 0
    for i in range(sites):
        outliers += kinds[i] > 0
    for i in range(sites):
        old, accepted = kinds[i], math.log(np.random.random())
        odds = log_odds_of_further(outliers - (old > 0), sites, prior)
        # The most that any variance gains: most sites are done with here.
        if old == 0 and accepted >= 0.5 * beta * residual[i] ** 2 / precision[i, i] + odds:
            continue
        new = np.random.randint(others)
        if new >= old:
            new += 1
        further = VARIANCES[new] - VARIANCES[old]
        over = 1.0 + further * precision[i, i]
        log_ratio = 0.5 * beta * (further * residual[i] ** 2 / over - math.log(over))
        log_ratio += odds * ((new > 0) - (old > 0))
        if accepted < log_ratio:
            row, by = precision[i].copy(), further / over * residual[i]
            state.log_det[0] += _add_variance(precision, i, further)
            for j in range(sites):
                residual[j] -= by * row[j]
            outliers += (new > 0) - (old > 0)
            kinds[i] = new
