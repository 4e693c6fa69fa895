"""Splines of a higher degree through equally spaced samples, as pieces of polynomials.

Contents: pieces of degree 7 and 9.

Of a sine at the share x of half the sampling rate a spline of degree d errs by about
(x / (2 - x))^(d + 1) (M. Unser, A. Aldroubi, M. Eden, IEEE Trans. Signal Process. 41 (1993), 821):
at a fifth of that rate a cubic one by 2e-4, one of degree 7 by 2e-8.
"""

from __future__ import annotations

from math import factorial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissue_probe.call_cache import for_a_call

if TYPE_CHECKING:
    from scipy.sparse import csr_array

FloatArray = NDArray[np.float64]

#: Degree of the splines by which a simulation is read off: it may have bends.
SPLINE_DEGREE = 3


class _Spline(NamedTuple):
    """The matrices from samples to a spline's coefficients, and from these to its pieces.

    ``factor`` and ``pivots`` are those of a band with ``degree`` diagonals on either side.
    """

    degree: int
    factor: FloatArray
    pivots: NDArray[np.int32]
    pieces: csr_array


def splines(values: FloatArray, period: float, degree: int) -> FloatArray:
    """Return the pieces of the spline through samples, shape (n,).

    Its derivatives go on through the first and last few samples ("not a knot", C. de Boor, A
    Practical Guide to Splines (1978), chapter IV).

    Parameters
    ----------
    values : array, shape (n,)
        The samples; n is twice the degree at least.
    period : float
        Time between two of them [s].
    degree : int
        Of the polynomials, odd.

    Returns
    -------
    array, shape (degree + 1, n - 1)
        Coefficients of powers of the time since a sample, the highest first.

    Raises
    ------
    ValueError
        If there are fewer samples.
    """
    from scipy.linalg.lapack import dgbtrs  # with SciPy's sparse matrices, seldom needed

    if len(values) < 2 * degree:
        raise ValueError(f"{len(values)} samples: a spline of degree {degree} needs {2 * degree}")
    spline = _spline(len(values), degree)
    found, _ = dgbtrs(spline.factor, degree, degree, values, spline.pivots)
    powers = period ** np.arange(degree, -1, -1.0)
    result: FloatArray = (spline.pieces @ found).reshape(degree + 1, -1) / powers[:, np.newaxis]
    return result


def at_times(columns: FloatArray, period: float, times: FloatArray) -> FloatArray:
    """Return columns at other times, by cubic splines through their samples.

    Parameters
    ----------
    columns : array, shape (n,) or (n, m)
        Samples a period apart, the first at time 0; n is 6 at least.
    period : float
        [s].
    times : array, shape (k,)
        Within the samples' [s].

    Returns
    -------
    array, shape (k,) or (k, m)
    """
    from scipy.linalg.lapack import dgbtrs

    spline = _spline(len(columns), SPLINE_DEGREE)
    found, _ = dgbtrs(spline.factor, SPLINE_DEGREE, SPLINE_DEGREE, columns, spline.pivots)
    read = _values(len(columns), (times / period).tobytes())
    result: FloatArray = (read @ found).reshape(len(times), *columns.shape[1:])
    return result


@for_a_call(16)
def _values(count: int, places: bytes) -> csr_array:
    """Return the matrix from a cubic spline's coefficients to its values at places."""
    from scipy.interpolate import BSpline

    at = np.minimum(np.frombuffer(places), count - 1.0)
    return BSpline.design_matrix(at, _knots(count, SPLINE_DEGREE), SPLINE_DEGREE)


@for_a_call(16)
def _spline(count: int, degree: int) -> _Spline:
    """Prepare the splines through so many samples, a time of 1 apart."""
    from scipy.interpolate import BSpline
    from scipy.linalg.lapack import dgbtrf
    from scipy.sparse import vstack

    at, knots = np.arange(count, dtype=np.float64), _knots(count, degree)
    matrix = BSpline.design_matrix(at, knots, degree).tocoo()
    band = np.zeros((3 * degree + 1, count))
    band[2 * degree + matrix.row - matrix.col, matrix.col] = matrix.data
    factor, pivots, _ = dgbtrf(band, degree, degree)
    rows = [
        _derivative(at[:-1], knots, degree, order) / factorial(order)
        for order in range(degree, -1, -1)
    ]
    return _Spline(degree, factor, pivots, vstack(rows).tocsr())


def _knots(count: int, degree: int) -> FloatArray:
    """Return the knots of a spline that is not a knot at the first and last few samples."""
    at, half = np.arange(count, dtype=np.float64), (degree + 1) // 2
    ends = np.repeat(at[0], degree + 1), np.repeat(at[-1], degree + 1)
    return np.concatenate([ends[0], at[half:-half], ends[1]])


def _derivative(at: FloatArray, knots: FloatArray, degree: int, order: int) -> csr_array:
    """Return the matrix from a spline's coefficients to a derivative of it (de Boor, chapter X)."""
    from scipy.interpolate import BSpline
    from scipy.sparse import diags_array

    own = knots[order : knots.size - order]
    matrix = BSpline.design_matrix(at, own, degree - order)
    for lower in range(order - 1, -1, -1):
        inner, power = knots[lower : knots.size - lower], degree - lower
        count = inner.size - power - 1
        factors = power / (inner[power + 1 : -1] - inner[1 : -power - 1])
        matrix = matrix @ diags_array([-factors, factors], offsets=[0, 1], shape=(count - 1, count))
    return matrix
