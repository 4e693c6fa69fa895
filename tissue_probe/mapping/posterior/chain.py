"""Reversible-jump Markov chains over the inclusions of a map, coupled over temperatures.

Contents: which moves are made, how often, and what is kept.

Beside the chain of the posterior others run, to which the data say less (beta < 1): they leave a
wrong place that fits well, and hand over what they find by exchange of states (C. J. Geyer, Markov
chain Monte Carlo maximum likelihood, Computing Science and Statistics 23 (1991) 156).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from tissue_probe.mapping.posterior.moves import (
    KINDS,
    ChainState,
    Scratch,
    SitesRegion,
    begin_state,
    make_scratch,
    propose_birth,
    propose_change,
    propose_death,
    propose_level,
    propose_redraw,
    weigh_told,
)
from tissue_probe.mapping.posterior.outliers import ErrorKinds, propose_errors
from tissue_probe.mapping.posterior.prior import MOST_INCLUSIONS
from tissue_probe.signals import FloatArray, IntArray

#: Of all moves: birth or death, an inclusion drawn anew, the level, how each site errs; the rest
#: changes an inclusion.
_JUMP, _REDRAWN, _LEVEL_MOVE, _ERRED = 0.25, 0.1, 0.05, 0.05
#: Moves of each rung between exchanges.
_EXCHANGE = 10


@njit(cache=True, nogil=True, error_model="numpy")
def _move(
    state: ChainState,
    count: int,
    level: int,
    beta: float,
    region: SitesRegion,
    precision: FloatArray,
    log_weight: FloatArray,
    outliers: FloatArray,
    scratch: Scratch,
) -> tuple[int, int]:
    """Make one move; return number of inclusions and level then."""
    choice = np.random.random()
    if choice < 0.5 * _JUMP:
        count = propose_birth(state, count, beta, region, scratch)
    elif choice < _JUMP:
        count = propose_death(state, count, beta, region, scratch)
    elif choice < _JUMP + _REDRAWN:
        propose_redraw(state, count, beta, region, scratch)
    elif choice < _JUMP + _REDRAWN + _LEVEL_MOVE:
        level = propose_level(state, level, beta, precision, log_weight, scratch)
    elif choice < _JUMP + _REDRAWN + _LEVEL_MOVE + _ERRED:
        propose_errors(state, beta, outliers)
    else:
        propose_change(state, count, np.random.randint(KINDS), beta, region, scratch)
    return count, level


@njit(cache=True, nogil=True, error_model="numpy")
def run(
    seed: int,
    y: FloatArray,
    region: SitesRegion,
    precision: FloatArray,
    log_weight: FloatArray,
    outliers: FloatArray,
    betas: FloatArray,
    ends: FloatArray,
    kinds: ErrorKinds,
    steps: int,
    thin: int,
    rows: FloatArray,
    kept: IntArray,
    levels: IntArray,
    errors: ErrorKinds,
) -> None:
    """Run a chain of each beta on, and keep every ``thin``-th state of the first.

    Parameters
    ----------
    seed : int
        Of this stretch of the chain.
    y : array, shape (n,)
        log k less its median.
    region : Region
        Where sites and inclusions may be.
    precision, log_weight : array
        As in ``Background``.
    outliers : array, shape (2,)
        Beta prior of the share of outliers.
    betas : array, shape (b,)
        How much of what the data say each chain is told, the first 1.
    ends : array, shape (b, MOST + 1, PARAMETERS)
        The inclusions, and in the last row their number and the level; left as the chains end.
    kinds : array, shape (b, n)
        How each site errs in each chain; left as the chains end.
    steps, thin : int
        Moves of the stretch.
    rows, kept, levels, errors : array, shapes (s, MOST, PARAMETERS), (s,), (s,) and (s, n)
        Written: inclusions, their number, the level, and how each site errs, of each kept state.
    """
    np.random.seed(seed)
    rungs, written, scratch = betas.size, 0, make_scratch(y.size)
    count, level = (
        ends[:, MOST_INCLUSIONS, 0].astype(np.int64),
        ends[:, MOST_INCLUSIONS, 1].astype(np.int64),
    )
    rows_of, Q = ends[:, :MOST_INCLUSIONS].copy(), precision
    kinds_of = kinds.copy()
    states = [
        begin_state(rows_of[k], count[k], kinds_of[k], Q[level[k]], y, region) for k in range(rungs)
    ]
    at = np.arange(rungs)  # the state of each rung
    for step in range(steps):
        for rung in range(rungs):
            k = at[rung]
            count[k], level[k] = _move(
                states[k], count[k], level[k], betas[rung], region, precision, log_weight,
                outliers, scratch,
            )  # fmt: skip
        if rungs > 1 and (step + 1) % _EXCHANGE == 0:
            rung = np.random.randint(rungs - 1)
            a, b = at[rung], at[rung + 1]
            gain = weigh_told(states[b], level[b], log_weight)
            gain -= weigh_told(states[a], level[a], log_weight)
            if math.log(np.random.random()) < (betas[rung] - betas[rung + 1]) * gain:
                at[rung], at[rung + 1] = b, a
        if (step + 1) % thin == 0:
            k = at[0]
            rows[written, : count[k]] = states[k].inclusions[: count[k]]
            kept[written], levels[written], errors[written] = count[k], level[k], states[k].kinds
            written += 1
    for rung in range(rungs):
        k = at[rung]
        ends[rung, :MOST_INCLUSIONS], kinds[rung] = states[k].inclusions, states[k].kinds
        ends[rung, MOST_INCLUSIONS, 0], ends[rung, MOST_INCLUSIONS, 1] = count[k], level[k]
