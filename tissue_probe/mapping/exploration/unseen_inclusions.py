"""Inclusions that no site has felt: where a further site would most probably find one.

Contents: inclusions drawn from the prior, weighed by how little the sites would have felt of them,
and how probably a site feels one.

The states have such inclusions, too, but of some hundred states a few at each place: too few to
compare places by.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from tissue_probe.mapping.posterior.felt_surface import sums_at
from tissue_probe.mapping.posterior.moves import log_apart
from tissue_probe.mapping.posterior.posterior_sample import Sampled
from tissue_probe.mapping.posterior.prior import (
    FURTHER,
    LOG_CONTRAST,
    MOST_INCLUSIONS,
    PARAMETERS,
    X,
    Y,
    draw_contrast,
    draw_shape,
)
from tissue_probe.mapping.posterior.shape import write_shape
from tissue_probe.signals import FloatArray

#: A place is within some twenty of so many; each is weighed by so many states.
_DRAWN, _STATES = 500, 4
#: Steps of a sequence of places that is more even than chance (M. Roberts, 2018): inverse powers of
#: the root of t^3 = t + 1.
_EVEN_STEPS = (0.7548776662466927, 0.5698402909980532)


class Unseen:
    """How probably each of some sites feels an inclusion that none has felt.

    Parameters
    ----------
    sampled : Sampled
        The posterior of the sites so far.
    x, y : array, shape (sites,)
        The sites to choose from [mm].
    noise : array, shape (sites,)
        Variance of log k there, without that inclusion.
    """

    def __init__(self, sampled: Sampled, x: FloatArray, y: FloatArray, noise: FloatArray) -> None:
        rows, self._weights = _draw_inclusions(sampled)
        added = np.log(sums_at(rows[:, None], np.ones(len(rows), int), x, y))
        #: Of each drawn one and site, the share of an answer that a value there is.
        self._felt = added**2 / (added**2 + noise)

    def probabilities(self) -> FloatArray:
        """Return how probably each site feels one."""
        return self._weights @ self._felt

    def answer(self, site: int) -> None:
        """Count what a site will have felt."""
        self._weights = self._weights * (1.0 - self._felt[:, site])


def _draw_inclusions(sampled: Sampled) -> tuple[FloatArray, FloatArray]:
    """Return inclusions drawn from the prior, and how probably each is there, unseen."""
    domain, background = sampled.domain, sampled.background
    rows = np.zeros((_DRAWN, PARAMETERS))
    _draw(rows, domain.box)
    x, y = rows[:, X], rows[:, Y]
    region = domain.region(background.x, background.y)
    inside = (region.hull[:, :2] @ np.array([x, y]) + region.hull[:, 2:] <= 0.0).all(axis=0)
    rows = rows[inside]
    states, count, level, kinds = sampled.states.some(_STATES)
    sums = sums_at(states, count, background.x, background.y)
    likely = np.zeros(len(rows))
    for state, number, used, erring, total in zip(states, count, level, kinds, sums, strict=True):
        precision = background.precision_of(int(used), erring)
        residual = precision @ (sampled.felt.log_k - np.log(total))
        _add_likely(
            rows, state, number, background.x, background.y, precision, residual, total, likely
        )
    return rows, FURTHER * likely / (count.size * len(rows))


@njit(cache=True, nogil=True, error_model="numpy")
def _draw(rows: FloatArray, box: FloatArray) -> None:
    np.random.seed(0)  # the same sites have the same next ones
    for number in range(len(rows)):
        row = rows[number]
        draw_shape(row)
        row[LOG_CONTRAST] = draw_contrast()
        row[X] = box[0] + (box[1] - box[0]) * ((number * _EVEN_STEPS[0]) % 1.0)
        row[Y] = box[2] + (box[3] - box[2]) * ((number * _EVEN_STEPS[1]) % 1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _add_likely(
    rows: FloatArray,
    state: FloatArray,
    count: int,
    x: FloatArray,
    y: FloatArray,
    precision: FloatArray,
    residual: FloatArray,
    total: FloatArray,
    likely: FloatArray,
) -> None:
    """Add how likely each inclusion is beside those of a state, over none: 1 at most.

    What speaks for one, the states have already.
    """
    shape, change = np.empty(x.size), np.empty(x.size)
    where = np.empty(x.size, np.int64)
    for one in range(len(rows)):
        apart = log_apart(state, count, rows[one], -1) if count < MOST_INCLUSIONS else -np.inf
        if apart == -np.inf:
            continue
        write_shape(rows[one], x, y, shape)
        excess, changed = math.exp(rows[one, LOG_CONTRAST]) - 1.0, 0
        for i in range(x.size):
            if shape[i] > 0.0:
                left = max(1.0 + excess * shape[i] / total[i], 1e-3)
                change[changed], where[changed] = -math.log(left), i
                changed += 1
        gain = 0.0
        for a in range(changed):
            inner = 0.0
            for b in range(changed):
                inner += precision[where[a], where[b]] * change[b]
            gain -= change[a] * (residual[where[a]] + 0.5 * inner)
        likely[one] += math.exp(apart + min(gain, 0.0))
