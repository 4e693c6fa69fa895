"""Cubic splines through equally spaced samples.

What belongs here: calling the machine code. What does not: the splines (``even_spline``).
"""

from __future__ import annotations

import ctypes
from functools import cache
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from tissue_probe.physics import machine_code, numba_code

FloatArray = NDArray[np.float64]

#: Fewer samples have no cubic spline.
FEWEST = 4
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


def later(values: FloatArray, period: float, delay: float) -> tuple[FloatArray, FloatArray]:
    """Return what signals were earlier, by the spline through their samples.

    Parameters
    ----------
    values : array, shape (n, m)
        Samples of m signals; what lies beyond either end stands still.
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
    if len(values) < FEWEST:
        raise ValueError(f"{len(values)} samples: a cubic spline needs {FEWEST} at least")
    return np.ascontiguousarray(values, dtype=np.float64)
