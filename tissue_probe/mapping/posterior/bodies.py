"""Inclusions that are one body of free form: the states build a triangle of two or three ellipses.

Contents: how probably two inclusions are one body, and such joined.

Parts of one body touch, are equally stiff, and have the body's hard edge: a smooth one hides a
form. Of two inclusions of their own each has a place, a contrast and an edge of its own. The odds
are those of the prior times, by J. M. Dickey (Annals of Mathematical Statistics 42 (1971) 204), the
density of "no gap, no difference, both hard" after the sites were felt over that before; the three
are taken as independent, gap and difference as normal.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tissue_probe.mapping.posterior.found_inclusions import FoundInclusion
from tissue_probe.mapping.posterior.prior import (
    CONTRAST_SCALE,
    HARD,
    LOG_CONTRAST,
    LOG_EXPONENT,
    LOG_RADIUS,
    SOFT,
    X,
    Y,
    log_prior_of_exponent,
    log_prior_of_hard,
)
from tissue_probe.mapping.posterior.shape import metric
from tissue_probe.signals import FloatArray

#: Prior odds that two inclusions are one body: most inclusions are round.
_ONE = 0.1
#: Fewer states that have both tell no deviations; more tell nothing new.
_LEAST, _MOST = 20, 200
#: Middles farther apart than so many times both radii are of no parts that touch.
_FAR = 2.0
#: Density of no difference between the log contrasts of two inclusions of the prior.
_DENSITY_ALIKE = ((1.0 - SOFT) ** 2 + SOFT**2) / (4.0 * CONTRAST_SCALE)


def bodies_of(found: list[FoundInclusion], area: float) -> list[FoundInclusion]:
    """Return inclusions with the parts of each body joined, the most probable first.

    Parameters
    ----------
    found : list of Found
        As the states have them.
    area : float
        In which a middle may lie [mm^2].
    """
    pairs = [
        (i, j)
        for i, one in enumerate(found)
        for j, other in enumerate(found[:i])
        if _odds(one, other, area) > 1.0
    ]
    if not pairs:
        return found
    first, second = np.transpose(pairs)
    graph = coo_array((np.ones(len(pairs)), (first, second)), shape=(len(found), len(found)))
    count, of = connected_components(graph, directed=False)
    bodies = [
        FoundInclusion.join_parts([found[i] for i in np.flatnonzero(of == n)]) for n in range(count)
    ]
    return sorted(bodies, key=lambda one: -one.probability)


def _odds(one: FoundInclusion, other: FoundInclusion, area: float) -> float:
    """Return the odds that two inclusions, of a part each, are parts of one body."""
    radii = [float(np.median(each.members[:, LOG_RADIUS])) for each in (one, other)]
    if np.hypot(*(one.places - other.places)[0]) > _FAR * np.exp(radii).sum():
        return 0.0
    both, a, b = np.intersect1d(one.states, other.states, True, return_indices=True)
    if both.size < _LEAST:
        return 0.0
    some = np.unique(np.linspace(0, both.size - 1, _MOST).astype(int))
    gap, unlike, distance, hard = _compare_inclusions(
        one.members[a[some]], other.members[b[some]]
    ).T
    touch = _density_of_none(gap) * area / (2.0 * math.pi * float(distance.mean()))
    hardness = float(hard.mean()) / HARD**2
    return _ONE * touch * hardness * _density_of_none(unlike) / _DENSITY_ALIKE


@njit(cache=True, nogil=True, error_model="numpy")
def _compare_inclusions(rows: FloatArray, others: FloatArray) -> FloatArray:
    """Return of each pair of inclusions gap, difference, distance, and P(both edges are hard).

    The gap [mm] is along the way between their middles, negative where they overlap; the difference
    is of the log contrasts.
    """
    out = np.empty((len(rows), 4))
    for i in range(len(rows)):
        across, up = others[i, X] - rows[i, X], others[i, Y] - rows[i, Y]
        distance = math.hypot(across, up)
        gap, hard = distance, 1.0
        for row in (rows[i], others[i]):
            a, b, c = metric(row)
            squared = a * across**2 + 2.0 * b * across * up + c * up**2
            gap -= distance / math.sqrt(squared)
            exponent = row[LOG_EXPONENT]
            hard *= math.exp(log_prior_of_hard(exponent) - log_prior_of_exponent(exponent))
        out[i] = gap, rows[i, LOG_CONTRAST] - others[i, LOG_CONTRAST], distance, hard
    return out


def _density_of_none(values: FloatArray) -> float:
    """Return the density of a normal variable at zero, by draws of it."""
    spread = float(values.std())
    if spread == 0.0:
        return 0.0
    return math.exp(-0.5 * (float(values.mean()) / spread) ** 2) / (
        spread * math.sqrt(2.0 * math.pi)
    )
