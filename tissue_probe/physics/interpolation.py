"""Cubic splines through equally spaced samples.

Contents: calling the machine code.
"""

from __future__ import annotations

import ctypes
from functools import cache
from importlib import import_module
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

from tissue_probe.physics import machine_code, numba_code
from tissue_probe.signals import IntArray

FloatArray = NDArray[np.float64]

#: Fewer samples have no cubic spline.
FEWEST_KNOTS = 4
_PIECES = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_double, *4 * [ctypes.c_void_p])
_LATER = ctypes.CFUNCTYPE(
    None, *2 * [ctypes.c_int64], *2 * [ctypes.c_double], *5 * [ctypes.c_void_p]
)


@cache
def _code() -> machine_code.MachineCode:
    name = "even_spline"
    return machine_code.load(
        name,
        lambda: numba_code.text(import_module(f"tissue_probe.physics.{name}")),
        (f"physics/{name}.py", "physics/pointers.py"),
    )


def cubics(values: FloatArray, period: float) -> FloatArray:
    """Return the pieces of the spline through samples, shape (n,).

    Parameters
    ----------
    values : array, shape (n,)
        The samples.
    period : float
        Time between two of them [s].

    Returns
    -------
    array, shape (4, n - 1)
        Coefficients of powers of the time since a sample, the highest first.

    Raises
    ------
    ValueError
        If there are fewer than four samples.
    """
    values = _checked(values)
    n, coefficients = values.size, np.empty((4, values.size - 1))
    arrays = (values, np.empty(n), np.empty(n), coefficients)
    _PIECES(_code().addresses["pieces"])(n, period, *(each.ctypes.data for each in arrays))
    return coefficients


def lines(values: FloatArray, period: float) -> FloatArray:
    """Return the pieces, shape (4, n - 1), of straight lines from sample to sample."""
    pieces = steps(values)
    pieces[2] = np.diff(values) / period
    return pieces


def steps(values: FloatArray) -> FloatArray:
    """Return the pieces, shape (4, n - 1), of a curve that keeps each sample until the next."""
    values = _checked(values)
    pieces = np.zeros((4, values.size - 1))
    pieces[3] = values[:-1]
    return pieces


def between_jumps(values: FloatArray, period: float, after: IntArray) -> FloatArray:
    """Return the pieces, shape (4, n - 1), of splines that go on until the sample after a jump.

    Parameters
    ----------
    values : array, shape (n,)
        The samples.
    period : float
        Time between two of them [s].
    after : array of int
        The first samples after the jumps.
    """
    pieces = steps(values)
    for first, last in pairwise([0, *after, values.size]):
        own = _spline(values[first:last], period)
        pieces[:, first : last - 1] = own
        if last < values.size and own.size:
            pieces[:, last - 1] = _from_its_end(own[:, -1], period)
    return pieces


def _spline(values: FloatArray, period: float) -> FloatArray:
    """Return the pieces of the spline, or of straight lines where there are too few samples."""
    if values.size >= FEWEST_KNOTS:
        return cubics(values, period)
    flat = np.zeros((2, values.size - 1))
    return np.vstack([flat, np.diff(values) / period, values[:-1]])


def _from_its_end(piece: FloatArray, period: float) -> FloatArray:
    """Return the same polynomial, by powers of the time since the piece's end."""
    a, b, c, d = piece
    return np.array(
        [
            a,
            b + 3.0 * a * period,
            c + 2.0 * b * period + 3.0 * a * period**2,
            d + c * period + b * period**2 + a * period**3,
        ]
    )


def with_acceleration(pieces: FloatArray, period: float) -> FloatArray:
    """Return pieces that begin with the acceleration there, at the price of kinks in the velocity.

    That of a cubic spline is too small by T^2 / 12 times its second derivative. Both are told from
    the second difference d, by a[i-1] + b a[i] + a[i+1] = (b + 2) d[i]; the spline has b = 4, which
    is of second order, and b = 10 is of fourth (S. Lele, J. Comput. Phys. 103 (1992), 16, eq.
    2.2.7), and has half of the spline's noise.

    Parameters
    ----------
    pieces : array, shape (4, m)
        Of ``cubics``.
    period : float
        Time between two samples [s].
    """
    spline = 2.0 * pieces[1]
    if spline.size < FEWEST_KNOTS:
        return pieces
    right = 2.0 * (spline[:-2] + 4.0 * spline[1:-1] + spline[2:])
    right[0] -= spline[0]
    right[-1] -= spline[-1]
    band = np.ones((3, right.size))
    band[1] = 10.0
    change = (solve_banded((1, 1), band, right) - spline[1:-1]) / 2.0
    pieces = pieces.copy()
    pieces[1, 1:-1] += change
    pieces[0, 1:-1] -= change / period  # so that the position goes on where it was
    return pieces


def later(values: FloatArray, period: float, delay: float) -> tuple[FloatArray, FloatArray]:
    """Return the earlier values of signals, by the spline through their samples.

    Parameters
    ----------
    values : array, shape (n, m)
        Samples of m signals; beyond either end they stand still.
    period : float
        Time between two samples [s].
    delay : float
        How much earlier [s]; negative: later.

    Returns
    -------
    read, rate : array, shapes (n, m) and (n,)
        The signals, and the derivative of the first by time.

    Raises
    ------
    ValueError
        If there are fewer than four samples.
    """
    values = _checked(values)
    n, m = values.shape
    read, rate = np.empty((n, m)), np.empty(n)
    arrays = (values, np.empty((n, m)), np.empty(n), read, rate)
    _LATER(_code().addresses["later"])(n, m, period, delay, *(each.ctypes.data for each in arrays))
    return read, rate


def _checked(values: FloatArray) -> FloatArray:
    if len(values) < FEWEST_KNOTS:
        raise ValueError(f"{len(values)} samples: a cubic spline needs {FEWEST_KNOTS} at least")
    return np.ascontiguousarray(values, dtype=np.float64)
