"""What could still hide: the largest inclusion at each place that the sites do not exclude.

Contents: the answer to "how large a nodule may be here without my having felt it?".

An inclusion of given contrast and radius would add d to log k at the sites. Its strength in the
data, as a share of d, is estimated as d'Qr / d'Qd with variance 1 / d'Qd, in each state of the
chains by its own residuals r. That it may be there has a probability: in states that have one over
the place it is 1, up to the largest of all these states; else how probably the strength is 1 or
more. Below 5 % on average the sites exclude it.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.felt_surface import sums_at
from tissue_probe.mapping.posterior.prior import LOG_ASPECT, LOG_RADIUS
from tissue_probe.mapping.posterior.sampling import States
from tissue_probe.mapping.posterior.shape import measure_distance
from tissue_probe.signals import BoolArray, FloatArray, IntArray

LARGEST_HIDDEN = 10.0  # mm
_STEP, _COARSE = 0.5, 2.0  # mm, of radii
_HIDDEN_STATES = 50
#: Less probable than this is excluded.
_EXCLUDED = 0.05
#: A plateau with an edge as blunt as a tip makes it: steeper than that nothing is felt.
_EXPONENT = 4.0
#: Of the radius: farther than that less than 0.3 % of it is felt.
_FADED = 1.7


@njit(cache=True, nogil=True, error_model="numpy")
def _weigh_places(
    px: float,
    py: float,
    radius: float,
    excess: float,
    x: FloatArray,
    y: FloatArray,
    precision: FloatArray,
    weighted: FloatArray,
    covered: BoolArray,
    change: FloatArray,
    where: IntArray,
) -> float:
    """Return how probably a round inclusion may be at a place, of all states.

    ``weighted`` are the states' Qr, shape (states, n), ``covered`` says which have one over it.
    """
    count = 0
    for i in range(x.size):
        relative = math.hypot(x[i] - px, y[i] - py) / radius
        if relative < _FADED:
            change[count] = math.log(1.0 + excess * 2.0 ** -(relative**_EXPONENT))
            where[count] = i
            count += 1
    information = 0.0
    for a in range(count):
        inner = 0.0
        for b in range(count):
            inner += precision[where[a], where[b]] * change[b]
        information += change[a] * inner
    total = 0.0
    for s in range(covered.size):
        if covered[s] or information <= 0.0:
            total += 1.0
            continue
        projection = 0.0
        for a in range(count):
            projection += change[a] * weighted[s, where[a]]
        total += 0.5 * math.erfc((information - projection) / math.sqrt(2.0 * information))
    return total / covered.size


@njit(cache=True, nogil=True, error_model="numpy")
def _radii(
    places_x: FloatArray,
    places_y: FloatArray,
    excess: float,
    x: FloatArray,
    y: FloatArray,
    precision: FloatArray,
    weighted: FloatArray,
    rows: FloatArray,
    count: IntArray,
    out: FloatArray,
) -> None:
    change, where = np.empty(x.size), np.empty(x.size, np.int64)
    covered = np.empty(count.size, np.bool_)
    uncovered = np.zeros(count.size, np.bool_)
    for i in range(places_y.size):
        for j in range(places_x.size):
            px, py = places_x[j], places_y[i]
            largest = 0.0
            for s in range(count.size):
                covered[s] = False
                for m in range(count[s]):
                    if measure_distance(rows[s, m], px, py) < 1.0:
                        covered[s] = True
                        longest = math.exp(rows[s, m, LOG_RADIUS] + 0.5 * rows[s, m, LOG_ASPECT])
                        largest = max(largest, longest)
            radius, step = LARGEST_HIDDEN, _COARSE
            while True:
                if (
                    radius > 0.0
                    and _weigh_places(
                        px,
                        py,
                        radius,
                        excess,
                        x,
                        y,
                        precision,
                        weighted,
                        covered if radius <= largest else uncovered,
                        change,
                        where,
                    )
                    < _EXCLUDED
                ):
                    radius -= step
                elif step == _STEP or radius == LARGEST_HIDDEN:
                    break
                else:
                    radius, step = radius + step - _STEP, _STEP
            # The bound lies between this radius and the next.
            radius += _STEP
            out[i, j] = radius


def could_hide(
    states: States,
    background: Background,
    log_k: FloatArray,
    contrast: float,
    x: FloatArray,
    y: FloatArray,
) -> FloatArray:
    """Return the largest radius [mm] at each place of the raster; NaN from ``LARGEST_HIDDEN`` on.

    Parameters
    ----------
    log_k : array, shape (n,)
        log of the stiffness at the sites, less a level.
    contrast : float
        How many times stiffer than the background the middle of the inclusion feels.
    x, y : array
        The raster [mm].
    """
    rows, count, level, kinds = states.some(_HIDDEN_STATES)
    residuals = log_k - np.log(sums_at(rows, count, background.x, background.y))
    precision, weighted = np.zeros_like(background.precision[0]), np.empty_like(residuals)
    for out, used, erring, r in zip(weighted, level, kinds, residuals, strict=True):
        of_state = background.precision_of(int(used), erring)
        precision += of_state / level.size
        out[:] = of_state @ r
    radii = np.empty((y.size, x.size))
    _radii(
        x, y, contrast - 1.0, background.x, background.y, precision, weighted, rows, count, radii
    )  # fmt: skip
    return np.where(radii >= LARGEST_HIDDEN, np.nan, radii)
