"""What could still hide: the largest inclusion at each place that the sites do not exclude.

What belongs here: the answer to "how large a nodule may be here without my having felt it?". What
does not: the inclusions that were felt (``found``).

An inclusion of given contrast and radius would add d to log k at the sites. Its strength in the
data, as a share of d, is estimated as d'Qr / d'Qd with variance 1 / d'Qd; where the upper bound of
95 % of that share is below 1, the sites exclude it. Where a found inclusion covers the place, it is
that one which may be there.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.felt_surface import sums_at
from tissue_probe.mapping.posterior.prior import LOG_RADIUS, X, Y
from tissue_probe.mapping.posterior.sampling import States
from tissue_probe.mapping.posterior.shape import metric
from tissue_probe.signals import FloatArray

LARGEST = 10.0  # mm
_STEP = 0.5  # mm, of radii
_STATES = 200
#: One-sided bound of 95 %.
_BOUND = 1.645
#: A plateau with an edge as blunt as a tip makes it: steeper than that nothing is felt.
_EXPONENT = 4.0
#: Of the radius: farther than that less than 0.3 % of it is felt.
_FADED = 1.7


@njit(cache=True, nogil=True, error_model="numpy")
def _excluded(px, py, radius, excess, x, y, precision, residual, change, where):
    """Whether the sites exclude a round inclusion."""
    count = 0
    for i in range(x.size):
        relative = math.hypot(x[i] - px, y[i] - py) / radius
        if relative < _FADED:
            change[count] = math.log(1.0 + excess * 2.0 ** -(relative**_EXPONENT))
            where[count] = i
            count += 1
    information, projection = 0.0, 0.0
    for a in range(count):
        inner = 0.0
        for b in range(count):
            inner += precision[where[a], where[b]] * change[b]
        information += change[a] * inner
        projection += change[a] * residual[where[a]]
    return projection + _BOUND * math.sqrt(information) < information


@njit(cache=True, nogil=True, error_model="numpy")
def _radii(places_x, places_y, excess, x, y, precision, residual, out):
    change, where = np.empty(x.size), np.empty(x.size, np.int64)
    for i in range(places_y.size):
        for j in range(places_x.size):
            radius = LARGEST
            while radius > 0.0 and _excluded(
                places_x[j], places_y[i], radius, excess, x, y, precision, residual, change, where
            ):
                radius -= _STEP
            out[i, j] = radius


@njit(cache=True, nogil=True, error_model="numpy")
def _covering(rows, states, x, y, out):
    """Write the radius that inclusions of 5 % of the states that cover a place exceed."""
    bins = np.zeros((y.size, x.size, int(LARGEST / _STEP) + 1), np.int64)
    for m in range(rows.shape[0]):
        a, b, c = metric(rows[m])
        radius = math.exp(rows[m, LOG_RADIUS])
        at = min(int(radius / _STEP) + 1, bins.shape[2] - 1)
        for i in range(y.size):
            up = y[i] - rows[m, Y]
            if abs(up) < 2.0 * radius:
                for j in range(x.size):
                    across = x[j] - rows[m, X]
                    if a * across**2 + 2.0 * b * across * up + c * up**2 < 1.0:
                        bins[i, j, at] += 1
    for i in range(y.size):
        for j in range(x.size):
            left, at = 0.05 * states, bins.shape[2] - 1
            while at > 0 and left >= bins[i, j, at]:
                left -= bins[i, j, at]
                at -= 1
            out[i, j] = at * _STEP


def could_hide(
    states: States,
    background: Background,
    log_k: FloatArray,
    contrast: float,
    x: FloatArray,
    y: FloatArray,
) -> FloatArray:
    """Return the largest radius [mm] at each place of the raster; NaN from ``LARGEST`` on.

    Parameters
    ----------
    log_k : array, shape (n,)
        log of the stiffness at the sites, less a level.
    contrast : float
        How many times stiffer than the background the middle of the inclusion feels.
    x, y : array
        The raster [mm].
    """
    rows, count, level = states.some(_STATES)
    explained = np.log(sums_at(rows, count, background.x, background.y)).mean(axis=0)
    used, times = np.unique(level, return_counts=True)
    precision = np.tensordot(times / level.size, background.precision[used], axes=1)
    residual = precision @ (log_k - explained)
    radii, covered = np.empty((y.size, x.size)), np.empty((y.size, x.size))
    _radii(x, y, contrast - 1.0, background.x, background.y, precision, residual, radii)
    _covering(rows[np.arange(rows.shape[1]) < count[:, None]], count.size, x, y, covered)
    largest = np.maximum(radii, covered)
    return np.where(largest >= LARGEST, np.nan, largest)
