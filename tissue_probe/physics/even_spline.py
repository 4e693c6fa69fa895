"""Cubic spline through equally spaced samples, in Numba's Python.

What belongs here: the spline's slopes, its pieces, and what it is a little earlier or later.
What does not: calling it (``interpolation``). Imported only where machine code has to be made.

The third derivative goes on through the second sample and the last but one ("not a knot", de Boor
1978, chapter IV). Beside SciPy's ``CubicSpline``, with which it agrees to rounding, it is asked for
thousands of times in a fit, of many columns at once, and lets other threads run meanwhile.
"""

from numba import carray, cfunc, njit


@njit(error_model="numpy")
def _slopes(values, period, slopes, factors):
    """Fill the spline's derivatives at the samples, of each column; four samples at least.

    Between are s[i-1] + 4 s[i] + s[i+1] = 3 (d[i-1] + d[i]) for the differences d over the period,
    at the ends s[0] + 2 s[1] = (5 d[0] + d[1]) / 2 and its mirror image: Thomas's algorithm.
    """
    n, m = values.shape
    factors[0] = 2.0
    for j in range(m):
        slopes[0, j] = (values[2, j] + 4.0 * values[1, j] - 5.0 * values[0, j]) / (2.0 * period)
    for i in range(1, n - 1):
        factors[i] = 1.0 / (4.0 - factors[i - 1])
        for j in range(m):
            right = 3.0 * (values[i + 1, j] - values[i - 1, j]) / period
            slopes[i, j] = (right - slopes[i - 1, j]) * factors[i]
    last = n - 1
    for j in range(m):
        right = 5.0 * values[last, j] - 4.0 * values[last - 1, j] - values[last - 2, j]
        right = right / (2.0 * period) - 2.0 * slopes[last - 1, j]
        slopes[last, j] = right / (1.0 - 2.0 * factors[last - 1])
    for i in range(last - 1, -1, -1):
        for j in range(m):
            slopes[i, j] -= factors[i] * slopes[i + 1, j]


@cfunc(
    "void(int64, float64, CPointer(float64), CPointer(float64), CPointer(float64), "
    "CPointer(float64))",
    error_model="numpy",
)
def pieces(n, period, values, slopes, factors, coefficients):
    """Fill coefficients, shape (4, n - 1), highest power first, of the pieces of one signal."""
    values, slopes = carray(values, (n, 1)), carray(slopes, (n, 1))
    c = carray(coefficients, (4, n - 1))
    _slopes(values, period, slopes, carray(factors, n))
    for i in range(n - 1):
        rise = (values[i + 1, 0] - values[i, 0]) / period
        c[0, i] = (slopes[i, 0] + slopes[i + 1, 0] - 2.0 * rise) / (period * period)
        c[1, i] = (3.0 * rise - 2.0 * slopes[i, 0] - slopes[i + 1, 0]) / period
        c[2, i] = slopes[i, 0]
        c[3, i] = values[i, 0]


@cfunc(
    "void(int64, int64, float64, float64, CPointer(float64), CPointer(float64), CPointer(float64), "
    "CPointer(float64), CPointer(float64))",
    error_model="numpy",
)
def later(n, m, period, delay, values, slopes, factors, read, rate):
    """Fill what columns, shape (n, m), were ``delay`` earlier, and how fast the first changed.

    What lies beyond either end stands still.
    """
    values, slopes = carray(values, (n, m)), carray(slopes, (n, m))
    read, rate = carray(read, (n, m)), carray(rate, n)
    _slopes(values, period, slopes, carray(factors, n))
    for k in range(n):
        at = k - delay / period
        inside = 0.0 <= at <= n - 1.0
        at = min(max(at, 0.0), n - 1.0)
        i = min(int(at), n - 2)
        s = at - i
        own, next_own = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s)
        slope, next_slope = period * s * (1.0 - s) ** 2, period * s * s * (s - 1.0)
        for j in range(m):
            read[k, j] = (
                own * values[i, j]
                + next_own * values[i + 1, j]
                + slope * slopes[i, j]
                + next_slope * slopes[i + 1, j]
            )
        rate[k] = 0.0
        if inside:
            rise = 6.0 * s * (1.0 - s) * (values[i + 1, 0] - values[i, 0]) / period
            own, other = (1.0 - s) * (1.0 - 3.0 * s), s * (3.0 * s - 2.0)
            rate[k] = rise + own * slopes[i, 0] + other * slopes[i + 1, 0]
