"""Found places held against true ones, one to one.

Contents: pairing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

#: Two tip radii: what is farther off is another place [m].
PLACE_TOLERANCE = 0.006
_Place = tuple[float, float]


@dataclass(frozen=True)
class Match:
    """Found places held against true ones, all by their index in what was given.

    Attributes
    ----------
    pairs : tuple of (int, int, float)
        Index of the found place, index of the true one, and their distance [m].
    missed : tuple of int
        True places without a found one.
    false : tuple of int
        Found places without a true one.
    """

    pairs: tuple[tuple[int, int, float], ...]
    missed: tuple[int, ...]
    false: tuple[int, ...]


def match(
    found: Sequence[_Place], true: Sequence[_Place], tolerance: float = PLACE_TOLERANCE
) -> Match:
    """Pair found places with true ones, one to one.

    Of all pairings within the tolerance, one with the most pairs is taken, and among these the one
    with the smallest sum of distances.

    Parameters
    ----------
    found, true : sequence of (float, float)
        x and y of each [m].
    tolerance : float
        Largest distance of a pair [m].
    """
    distance = cdist(*(np.array(places, dtype=float).reshape(-1, 2) for places in (found, true)))
    # One pair too far apart costs more than all pairs within the tolerance together.
    too_far = tolerance * (min(distance.shape) + 1) + 1.0
    rows, columns = linear_sum_assignment(np.where(distance <= tolerance, distance, too_far))
    pairs = tuple(
        (int(row), int(column), float(distance[row, column]))
        for row, column in zip(rows, columns, strict=True)
        if distance[row, column] <= tolerance
    )
    return Match(
        pairs=pairs,
        missed=tuple(sorted(set(range(len(true))) - {pair[1] for pair in pairs})),
        false=tuple(sorted(set(range(len(found))) - {pair[0] for pair in pairs})),
    )
