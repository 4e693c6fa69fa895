"""Stiffness everywhere: mean and standard deviation of what would be felt at each place.

Contents: the posterior surface, of background and inclusions together.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.prior import (
    LEAST_LEFT,
    LOG_ASPECT,
    LOG_CONTRAST,
    LOG_EXPONENT,
    LOG_RADIUS,
    X,
    Y,
)
from tissue_probe.mapping.posterior.sampling import States
from tissue_probe.mapping.posterior.shape import FADED, metric, write_shape
from tissue_probe.signals import FloatArray, IntArray

#: Enough for a standard deviation that is right to 9 %.
_SURFACE_STATES = 64
#: The background is smooth: it is computed on a coarser raster, of so many places a side.
_COARSE = 22


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_felt(
    rows: FloatArray, count: int, x: FloatArray, y: FloatArray, total: FloatArray
) -> None:
    """Write 1 + sum e g at places to ``total``."""
    one = np.empty(x.size)
    total[:] = 1.0
    for j in range(count):
        write_shape(rows[j], x, y, one)
        excess = math.exp(rows[j, LOG_CONTRAST]) - 1.0
        for i in range(x.size):
            total[i] += excess * one[i]
    # The chains see to it at the sites; between them soft ones may add up to more.
    for i in range(x.size):
        total[i] = max(total[i], LEAST_LEFT)


@njit(cache=True, nogil=True, error_model="numpy")
def _add_one(
    row: FloatArray, x: FloatArray, y: FloatArray, profile: FloatArray, total: FloatArray
) -> None:
    """Add e g of one inclusion over a raster, by a table of its profile: a power takes long."""
    a, b, c = metric(row)
    excess, exponent = math.exp(row[LOG_CONTRAST]) - 1.0, math.exp(row[LOG_EXPONENT])
    fades = (FADED / math.log(2.0)) ** (1.0 / exponent)
    cells = profile.size - 1
    for i in range(cells + 1):
        profile[i] = excess * 2.0 ** -((i * fades / cells) ** exponent)
    far = fades * math.exp(row[LOG_RADIUS] + 0.5 * row[LOG_ASPECT])
    for i in range(y.size):
        up = y[i] - row[Y]
        if abs(up) < far:
            for j in range(x.size):
                across = x[j] - row[X]
                if abs(across) < far:
                    squared = a * across**2 + 2.0 * b * across * up + c * up**2
                    at = math.sqrt(squared) / fades * cells
                    if at < cells:
                        k = int(at)
                        total[i, j] += profile[k] + (at - k) * (profile[k + 1] - profile[k])


@njit(cache=True, nogil=True, error_model="numpy")
def _add(
    rows: FloatArray,
    count: int,
    x: FloatArray,
    y: FloatArray,
    first: FloatArray,
    second: FloatArray,
    mean: FloatArray,
    square: FloatArray,
) -> None:
    """Add one state to the sums: the background's moments lie on a coarse raster, linear between.

    ``first`` and ``second`` are the background's mean and mean square, over the same rectangle.
    """
    total, profile = np.ones((y.size, x.size)), np.empty(400)
    for j in range(count):
        _add_one(rows[j], x, y, profile, total)
    rows_coarse, columns_coarse = first.shape
    for i in range(y.size):
        v = i * (rows_coarse - 1) / (y.size - 1)
        a = min(int(v), rows_coarse - 2)
        v -= a
        for k in range(x.size):
            u = k * (columns_coarse - 1) / (x.size - 1)
            b = min(int(u), columns_coarse - 2)
            u -= b
            w00, w01, w10, w11 = (1 - v) * (1 - u), (1 - v) * u, v * (1 - u), v * u
            one = (
                w00 * first[a, b]
                + w01 * first[a, b + 1]
                + w10 * first[a + 1, b]
                + w11 * first[a + 1, b + 1]
            )
            two = (
                w00 * second[a, b]
                + w01 * second[a, b + 1]
                + w10 * second[a + 1, b]
                + w11 * second[a + 1, b + 1]
            )
            left = max(total[i, k], LEAST_LEFT)
            mean[i, k] += one * left
            square[i, k] += two * left**2


def sums_at(rows: FloatArray, count: IntArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return 1 + sum e g at places [mm] in each state, ``LEAST_LEFT`` at least.

    The shape is (states, places).
    """
    found = np.empty((count.size, x.size))
    for out, state, number in zip(found, rows, count, strict=True):
        _sum_felt(state, number, x, y, out)
    return found


def surface_of(
    states: States, background: Background, log_k: FloatArray, x: FloatArray, y: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return mean and standard deviation over the raster of x and y [mm], shapes (len y, len x).

    Parameters
    ----------
    log_k : array, shape (n,)
        log of the stiffness at the sites, less a level; the surface is over exp of that level.
    """
    coarse = [np.linspace(axis[0], axis[-1], _COARSE) for axis in (x, y)]
    places = [each.ravel() for each in np.meshgrid(*coarse)]
    rows, count, level, kinds = states.some(_SURFACE_STATES)
    of_sites = log_k - np.log(sums_at(rows, count, background.x, background.y))
    middle, variance = background.predict_background(level, kinds, of_sites, *places)
    first = np.exp(middle + 0.5 * variance).reshape(-1, _COARSE, _COARSE)
    second = np.exp(2.0 * middle + 2.0 * variance).reshape(-1, _COARSE, _COARSE)
    mean, square = np.zeros((y.size, x.size)), np.zeros((y.size, x.size))
    for one in range(count.size):
        _add(rows[one], count[one], x, y, first[one], second[one], mean, square)
    mean /= count.size
    return mean, np.sqrt(np.maximum(square / count.size - mean**2, 0.0))
