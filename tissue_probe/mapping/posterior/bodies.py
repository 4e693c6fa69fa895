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
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tissue_probe.mapping.posterior.found import Found
from tissue_probe.mapping.posterior.prior import (
    CONTRAST_SCALE,
    HARD,
    LOG_CONTRAST,
    LOG_EXPONENT,
    SOFT,
    X,
    Y,
    log_prior_of_exponent,
    log_prior_of_hard,
)
from tissue_probe.mapping.posterior.shape import radius_towards
from tissue_probe.signals import FloatArray

#: Prior odds that two inclusions are one body: most inclusions are round.
_ONE = 0.1
#: Fewer states that have both tell no deviations; more tell nothing new.
_LEAST, _MOST = 20, 200
#: Density of no difference between the log contrasts of two inclusions of the prior.
_ALIKE = ((1.0 - SOFT) ** 2 + SOFT**2) / (4.0 * CONTRAST_SCALE)


def bodies_of(found: list[Found], area: float) -> list[Found]:
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
    bodies = [Found.joined([found[i] for i in np.flatnonzero(of == n)]) for n in range(count)]
    return sorted(bodies, key=lambda one: -one.probability)


def _odds(one: Found, other: Found, area: float) -> float:
    """Return the odds that two inclusions are parts of one body."""
    both, a, b = np.intersect1d(one.states, other.states, return_indices=True)
    if both.size < _LEAST:
        return 0.0
    some = np.unique(np.linspace(0, both.size - 1, _MOST).astype(int))
    rows, others = one.members[a[some]], other.members[b[some]]
    apart = others[:, [X, Y]] - rows[:, [X, Y]]
    distance = np.hypot(*apart.T)
    towards = apart / distance[:, None]
    gap = distance - radius_towards(rows, towards) - radius_towards(others, towards)
    unlike = rows[:, LOG_CONTRAST] - others[:, LOG_CONTRAST]
    touch = _density_of_none(gap) * area / (2.0 * math.pi * float(distance.mean()))
    hard = float((_hard(rows) * _hard(others)).mean()) / HARD**2
    return _ONE * touch * hard * _density_of_none(unlike) / _ALIKE


def _density_of_none(values: FloatArray) -> float:
    """Return the density of a normal variable at zero, by draws of it."""
    spread = float(values.std())
    if spread == 0.0:
        return 0.0
    return math.exp(-0.5 * (float(values.mean()) / spread) ** 2) / (
        spread * math.sqrt(2.0 * math.pi)
    )


def _hard(rows: FloatArray) -> FloatArray:
    """Return how probably the edge of each inclusion is of the hard kind."""
    exponents = rows[:, LOG_EXPONENT]
    return np.array([math.exp(log_prior_of_hard(e) - log_prior_of_exponent(e)) for e in exponents])
