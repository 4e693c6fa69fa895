"""Which inclusions the states of the chains have in common.

Contents: gathering, from all states, what is one inclusion; its probability, centre and contrast.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from tissue_probe.mapping.posterior.prior import LOG_CONTRAST, X, Y
from tissue_probe.mapping.posterior.sampling import States
from tissue_probe.signals import FloatArray, IntArray

#: Inclusions of two states are one if their middles are nearer than a tip's diameter [mm].
LINK = 6.0
#: Less probable than this, it is not told.
LEAST_PROBABILITY = 0.05
#: Cells and blur of the raster on which middles are counted [mm].
_CELL, _BLUR = 1.0, 1.5


@dataclass(frozen=True)
class Found:
    """One inclusion as the states have it.

    Attributes
    ----------
    probability : float
        Share of the states that have it.
    by_chain : array, shape (chains,)
        That share in each chain.
    members : array, shape (m, PARAMETERS)
        The inclusion in each state that has it.
    states : array, shape (m,)
        The numbers of these states.
    """

    probability: float
    by_chain: FloatArray
    members: FloatArray
    states: IntArray

    @property
    def centre(self) -> FloatArray:
        """Mean of the middles [mm], shape (2,)."""
        return self.members[:, [X, Y]].mean(axis=0)

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the middle [mm^2], shape (2, 2)."""
        return np.cov(self.members[:, [X, Y]].T, bias=True)

    @property
    def contrast(self) -> float:
        """Median of how many times stiffer than the background its middle feels."""
        return float(np.exp(np.median(self.members[:, LOG_CONTRAST])))


def found_in(states: States) -> list[Found]:
    """Return the inclusions of all states, the most probable first."""
    rows, count, _, _ = states.flat()
    chains, each = states.count.shape
    present = np.arange(rows.shape[1]) < count[:, None]
    state, place = np.nonzero(present)
    inclusions = rows[state, place]
    free = np.ones(state.size, dtype=bool)
    found: list[Found] = []
    while free.sum() >= LEAST_PROBABILITY * count.size:
        near = _around_densest(inclusions[:, [X, Y]], free)
        members = _one_a_state(state, near)
        free[near < LINK] &= ~np.isin(np.flatnonzero(near < LINK), members)
        probability = members.size / count.size
        if probability < LEAST_PROBABILITY:
            free[near < _BLUR] = False
            continue
        by_chain = np.bincount(state[members] // each, minlength=chains) / each
        found.append(Found(probability, by_chain, inclusions[members], state[members]))
    return sorted(found, key=lambda one: -one.probability)


def _around_densest(centres: FloatArray, free: np.ndarray) -> FloatArray:
    """Return each middle's distance from where most free ones are; infinite where not free."""
    origin = centres[free].min(axis=0) - 2 * _CELL
    cells = ((centres[free] - origin) / _CELL).astype(int)
    counts = np.zeros(cells.max(axis=0) + 3)
    np.add.at(counts, tuple(cells.T), 1.0)
    smooth = gaussian_filter(counts, _BLUR / _CELL, mode="constant")
    densest = origin + _CELL * (np.array(np.unravel_index(smooth.argmax(), smooth.shape)) + 0.5)
    distance = np.hypot(*(centres - densest).T)
    distance[~free] = np.inf
    return distance


def _one_a_state(state: IntArray, near: FloatArray) -> IntArray:
    """Return which inclusions are taken: of each state the nearest within ``LINK``."""
    order = np.argsort(near, kind="stable")
    order = order[near[order] < LINK]
    _, first = np.unique(state[order], return_index=True)
    return order[first]
