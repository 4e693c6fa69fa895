"""Where an inclusion ends, and how surely: lines for the eye and margins for a resection.

Contents: places inside the inclusions of many states, counted; lines of their share.

Two meanings, one for each use. The boundary of 50 % goes around the places that are more likely
inside than outside: the best guess. Those of 90 and 95 % go around the whole inclusion with that
probability: outside of the last there is nothing of it, 95 times in 100.
"""

from __future__ import annotations

import math
from typing import cast

import numpy as np
from contourpy import LineType, contour_generator
from numba import njit
from scipy.ndimage import label

from tissue_probe.mapping.posterior.prior import LOG_ASPECT, LOG_RADIUS, X, Y
from tissue_probe.mapping.posterior.shape import metric
from tissue_probe.signals import FloatArray, IntArray

_BOUNDARY_STEP = 0.5  # mm
#: Inclusions that are counted at most: a quantile of 5 % is then known to one part in seven.
MEMBERS = 1000


@njit(cache=True, nogil=True, error_model="numpy")
def _around(row: FloatArray, x: FloatArray, y: FloatArray) -> tuple[int, int, int, int]:
    """Return first and end of the rows and of the columns that an inclusion may reach."""
    step, far = x[1] - x[0], math.exp(row[LOG_RADIUS] + 0.5 * row[LOG_ASPECT])
    return (
        max(0, int((row[Y] - far - y[0]) / step)),
        min(y.size, int((row[Y] + far - y[0]) / step) + 2),
        max(0, int((row[X] - far - x[0]) / step)),
        min(x.size, int((row[X] + far - x[0]) / step) + 2),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _count(rows: FloatArray, x: FloatArray, y: FloatArray, counts: FloatArray) -> None:
    """Count, at each place of a raster, the inclusions it is in."""
    for m in range(rows.shape[0]):
        a, b, c = metric(rows[m])
        low, high, first, last = _around(rows[m], x, y)
        for i in range(low, high):
            up = y[i] - rows[m, Y]
            for j in range(first, last):
                across = x[j] - rows[m, X]
                if a * across**2 + 2.0 * b * across * up + c * up**2 < 1.0:
                    counts[i, j] += 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _least(
    rows: FloatArray, x: FloatArray, y: FloatArray, share: FloatArray, out: FloatArray
) -> None:
    """Write, for each inclusion, the least share among the places inside it."""
    for m in range(rows.shape[0]):
        a, b, c = metric(rows[m])
        low, high, first, last = _around(rows[m], x, y)
        out[m] = 1.0
        for i in range(low, high):
            up = y[i] - rows[m, Y]
            for j in range(first, last):
                across = x[j] - rows[m, X]
                inside = a * across**2 + 2.0 * b * across * up + c * up**2 < 1.0
                if inside and share[i, j] < out[m]:
                    out[m] = share[i, j]


@njit(cache=True, nogil=True, error_model="numpy")
def _inside(
    rows: FloatArray, count: IntArray, x: FloatArray, y: FloatArray, out: FloatArray
) -> None:
    for s in range(count.size):
        for m in range(count[s]):
            a, b, c = metric(rows[s, m])
            for i in range(x.size):
                across, up = x[i] - rows[s, m, X], y[i] - rows[s, m, Y]
                if a * across**2 + 2.0 * b * across * up + c * up**2 < 1.0:
                    out[s, i] = 1.0


def inside_each(rows: FloatArray, count: IntArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return whether places [mm] are in an inclusion of each state, 0 or 1; (states, places)."""
    found = np.zeros((count.size, x.size))
    _inside(rows, count, x, y, found)
    return found


def share_inside(rows: FloatArray, states: int, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the share of the states in which each place of a raster is in an inclusion.

    Inclusions of one state do not have each other's middles in them, so that few places are in two;
    these are counted twice, up to 1.
    """
    counts = np.zeros((y.size, x.size))
    _count(rows, x, y, counts)
    return np.minimum(counts / states, 1.0)


def boundaries(rows: FloatArray, count: IntArray, places: FloatArray) -> dict[int, FloatArray]:
    """Return the boundaries of one inclusion at 50, 90 and 95 %, each of shape (points, 2) [mm].

    Parameters
    ----------
    rows : array, shape (states, parts, PARAMETERS)
        The inclusion in each state that has it, by its parts; of at most ``MEMBERS`` states.
    count : array, shape (states,)
        How many parts it has there.
    places : array, shape (parts, 2)
        Where its parts are [mm]: one line goes around all.
    """
    members = rows[np.arange(rows.shape[1]) < count[:, None]]
    far = np.exp(members[:, LOG_RADIUS] + 0.5 * members[:, LOG_ASPECT]) + 2 * _BOUNDARY_STEP
    x, y = (
        np.arange(
            (members[:, i] - far).min(),
            (members[:, i] + far).max() + _BOUNDARY_STEP,
            _BOUNDARY_STEP,
        )
        for i in (X, Y)
    )
    share = share_inside(members, count.size, x, y)
    least = np.empty(len(members))
    _least(members, x, y, share, least)
    # All of a body is where all its parts are.
    least = np.minimum.reduceat(least, np.cumsum(count) - count)
    levels = {50: 0.5, **{p: float(np.quantile(least, 1.0 - p / 100.0)) for p in (90, 95)}}
    # The contour lies between places that are inside and places that are not.
    half = 0.5 / count.size
    highest = _find_joining_level(share, x, y, places) if len(places) > 1 else 1.0
    levels = {p: max(min(level, highest) - half, half) for p, level in levels.items()}
    return contours(x, y, share, levels)


def _find_joining_level(
    share: FloatArray, x: FloatArray, y: FloatArray, places: FloatArray
) -> float:
    """Return the highest level, of twentieths, at which all parts of a body are in one line.

    Parts touch, and leave a seam that few states have inside.
    """
    columns, rows = (
        np.abs(axis[:, None] - at).argmin(axis=0) for axis, at in zip((x, y), places.T, strict=True)
    )
    for level in np.arange(10, 0, -1) / 20.0:
        of = label(share >= level)[0][rows, columns]
        if of.min() == of.max() > 0:
            return float(level)
    return 0.0


def contours(
    x: FloatArray, y: FloatArray, share: FloatArray, levels: dict[int, float]
) -> dict[int, FloatArray]:
    """Return the largest closed line of each level over a raster, shape (points, 2), by its name.

    Where the raster ends, the line goes along its edge.
    """
    step_x, step_y = x[1] - x[0], y[1] - y[0]
    wider_x = np.concatenate([[x[0] - step_x], x, [x[-1] + step_x]])
    wider_y = np.concatenate([[y[0] - step_y], y, [y[-1] + step_y]])
    lines = contour_generator(wider_x, wider_y, np.pad(share, 1), line_type=LineType.Separate)
    # The type of the lines is the one asked for: a list of arrays.
    return {
        name: _largest(cast("list[FloatArray]", lines.lines(level)))
        for name, level in levels.items()
    }


def _largest(rings: list[FloatArray]) -> FloatArray:
    return max(rings, key=_area, default=np.empty((0, 2)))


def _area(ring: FloatArray) -> float:
    x, y = ring.T
    return 0.5 * abs(float(x @ np.roll(y, 1) - y @ np.roll(x, 1)))
