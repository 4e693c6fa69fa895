"""Which inclusions the states of the chains have in common.

Contents: gathering, from all states, what is one inclusion; its probability, centre and contrast.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import gaussian_filter

from tissue_probe.mapping.posterior.prior import LOG_CONTRAST, LOG_RADIUS, X, Y
from tissue_probe.mapping.posterior.sampling import States
from tissue_probe.signals import FloatArray, IntArray

#: Inclusions of two states are one if their middles are nearer than a tip's diameter [mm].
LINK = 6.0
#: Less probable than this, it is not told.
LEAST_PROBABILITY = 0.05
#: Cells and blur of the raster on which middles are counted [mm].
_CELL, _BLUR = 1.0, 1.5


@dataclass(frozen=True)
class FoundInclusion:
    """One inclusion as the states have it.

    Attributes
    ----------
    members : array, shape (m, PARAMETERS)
        The inclusion in each state that has it; of a body of several parts (``bodies``) each part.
    states : array, shape (m,)
        The numbers of these states, rising; that of a body's parts comes again.
    places : array, shape (parts, 2)
        Means of the parts' middles [mm].
    count : (int, int)
        How many chains there are, and states of each.
    """

    members: FloatArray
    states: IntArray
    places: FloatArray
    count: tuple[int, int]

    @staticmethod
    def join_parts(parts: list[FoundInclusion]) -> FoundInclusion:
        """Return the body of which these are the parts."""
        if len(parts) == 1:
            return parts[0]
        states = np.concatenate([one.states for one in parts])
        order = np.argsort(states, kind="stable")
        return FoundInclusion(
            np.concatenate([one.members for one in parts])[order],
            states[order],
            np.concatenate([one.places for one in parts]),
            parts[0].count,
        )

    @cached_property
    def _each(self) -> tuple[IntArray, IntArray, IntArray]:
        """The states, where each begins among the members, and how many parts it has there."""
        first = np.flatnonzero(np.diff(self.states, prepend=-1))
        return self.states[first], first, np.diff(first, append=self.states.size)

    @cached_property
    def by_chain(self) -> FloatArray:
        """Share of the states of each chain that have it."""
        chains, each = self.count
        return np.bincount(self._each[0] // each, minlength=chains) / each

    @cached_property
    def probability(self) -> float:
        """Share of the states that have it."""
        return self._each[0].size / math.prod(self.count)

    @cached_property
    def middles(self) -> FloatArray:
        """Its middle in each state that has it [mm], shape (states, 2): of parts by their areas."""
        first = self._each[1]
        area = np.exp(2.0 * self.members[:, LOG_RADIUS])[:, None]
        total = np.add.reduceat(area * self.members[:, [X, Y]], first)
        return np.asarray(total / np.add.reduceat(area, first))

    def some(self, most: int) -> tuple[FloatArray, IntArray, IntArray]:
        """Return its parts in at most so many states, their number, and the states.

        Shapes (states, parts, PARAMETERS), (states,) and (states,); rows beyond the number are
        meaningless.
        """
        states, first, count = self._each
        chosen = np.unique(np.linspace(0, states.size - 1, most).astype(int))
        last = len(self.members) - 1
        each = np.minimum(first[chosen, None] + np.arange(count.max()), last)
        return self.members[each], count[chosen], states[chosen]

    @property
    def centre(self) -> FloatArray:
        """Mean of the middles [mm], shape (2,)."""
        middle: FloatArray = self.middles.mean(axis=0)
        return middle

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the middle [mm^2], shape (2, 2)."""
        return np.cov(self.middles.T, bias=True)

    @property
    def contrast(self) -> float:
        """Median of how many times stiffer than the background its middle feels."""
        return float(np.exp(np.median(self.members[:, LOG_CONTRAST])))


def find_inclusions(states: States) -> list[FoundInclusion]:
    """Return the inclusions of all states, the most probable first."""
    rows, count, _, _ = states.flat()
    shape = states.count.shape
    present = np.arange(rows.shape[1]) < count[:, None]
    state, place = np.nonzero(present)
    inclusions = rows[state, place]
    free = np.ones(state.size, dtype=bool)
    found: list[FoundInclusion] = []
    while free.sum() >= LEAST_PROBABILITY * count.size:
        near = _around_densest(inclusions[:, [X, Y]], free)
        members = _one_a_state(state, near)
        free[members] = False
        if members.size < LEAST_PROBABILITY * count.size:
            free[near < _BLUR] = False
            continue
        rows_of_it = inclusions[members]
        place = rows_of_it[:, [X, Y]].mean(axis=0, keepdims=True)
        found.append(FoundInclusion(rows_of_it, state[members], place, shape))
    return sorted(found, key=lambda one: -one.probability)


def _around_densest(centres: FloatArray, free: np.ndarray) -> FloatArray:
    """Return each middle's distance from where most free ones are; infinite where not free."""
    origin = centres[free].min(axis=0) - 2 * _CELL
    cells = ((centres[free] - origin) / _CELL).astype(int)
    counts = np.zeros(cells.max(axis=0) + 3)
    np.add.at(counts, tuple(cells.T), 1.0)
    smooth = gaussian_filter(counts, _BLUR / _CELL, mode="constant")
    densest = origin + _CELL * (np.array(np.unravel_index(smooth.argmax(), smooth.shape)) + 0.5)
    distance: FloatArray = np.hypot(*(centres - densest).T)
    distance[~free] = np.inf
    return distance


def _one_a_state(state: IntArray, near: FloatArray) -> IntArray:
    """Return which inclusions are taken: of each state the nearest within ``LINK``."""
    order = np.argsort(near, kind="stable")
    order = order[near[order] < LINK]
    _, first = np.unique(state[order], return_index=True)
    return order[first]
