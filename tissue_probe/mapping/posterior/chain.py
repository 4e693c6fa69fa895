"""One reversible-jump Markov chain over the inclusions of a map.

What belongs here: which moves are made, how often, and what is kept. What does not: the moves
(``moves``), and how many chains run how long (``sampling``).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tissue_probe.mapping.posterior.moves import (
    another_level,
    begun,
    born,
    changed_one,
    died,
    redrawn,
)
from tissue_probe.mapping.posterior.prior import MOST

#: Of all moves: birth or death, an inclusion drawn anew, the level; the rest changes an inclusion.
_JUMP, _REDRAWN, _LEVEL_MOVE = 0.25, 0.1, 0.05


@njit(cache=True, nogil=True, error_model="numpy")
def run(seed, y, region, precision, log_weight, end, steps, thin, rows, kept, levels):
    """Run a chain on, and keep every ``thin``-th state.

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
    end : array, shape (MOST + 1, PARAMETERS)
        The inclusions, and in the last row their number and the level; left as the chain ends.
    steps, thin : int
        Moves of the stretch.
    rows, kept, levels : array, shapes (s, MOST, PARAMETERS), (s,) and (s,)
        Written: inclusions, their number, and the level of each kept state.
    """
    np.random.seed(seed)
    count, level, written = int(end[MOST, 0]), int(end[MOST, 1]), 0
    state, scratch = begun(end[:MOST], count, precision[level], y, region)
    for step in range(steps):
        Q, choice = precision[level], np.random.random()
        if choice < 0.5 * _JUMP:
            count = born(state, count, Q, region, scratch)
        elif choice < _JUMP:
            count = died(state, count, Q, region, scratch)
        elif choice < _JUMP + _REDRAWN:
            redrawn(state, count, Q, region, scratch)
        elif choice < _JUMP + _REDRAWN + _LEVEL_MOVE:
            level = another_level(state, level, precision, log_weight, scratch)
        else:
            changed_one(state, count, Q, region, scratch)
        if (step + 1) % thin == 0:
            rows[written, :count] = state.inclusions[:count]
            kept[written], levels[written] = count, level
            written += 1
    end[MOST, 0], end[MOST, 1] = count, level
