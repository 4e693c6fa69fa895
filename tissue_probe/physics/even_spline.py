"""Cubic spline through equally spaced samples, in Numba's Python.

Contents: the spline's slopes, its pieces, and its values a little earlier or later. Imported only
where machine code has to be made.

The third derivative goes on through the second sample and the last but one ("not a knot", de Boor
1978, chapter IV). Beside SciPy's ``CubicSpline``, with which it agrees to rounding, it is asked for
thousands of times in a fit, of many columns at once, and lets other threads run meanwhile.
"""

from __future__ import annotations

from numba import cfunc

from tissue_probe.physics.pointers import Pointer, compile_inner


@compile_inner
def _slopes(
    n: int,
    m: int,
    values: Pointer[float],
    period: float,
    slopes: Pointer[float],
    factors: Pointer[float],
) -> None:
    """Fill the spline's derivatives at the samples, of m columns of n samples, four at least.

    Between are s[i-1] + 4 s[i] + s[i+1] = 3 (d[i-1] + d[i]) for the differences d over the period,
    at the ends s[0] + 2 s[1] = (5 d[0] + d[1]) / 2 and its mirror image: Thomas's algorithm.
    """
    factors[0] = 2.0
    for j in range(m):
        rise = values[2 * m + j] + 4.0 * values[m + j] - 5.0 * values[j]
        slopes[j] = rise / (2.0 * period)
    for i in range(1, n - 1):
        factors[i] = 1.0 / (4.0 - factors[i - 1])
        for at in range(i * m, (i + 1) * m):
            right = 3.0 * (values[at + m] - values[at - m]) / period
            slopes[at] = (right - slopes[at - m]) * factors[i]
    last = n - 1
    for at in range(last * m, n * m):
        right = 5.0 * values[at] - 4.0 * values[at - m] - values[at - 2 * m]
        right = right / (2.0 * period) - 2.0 * slopes[at - m]
        slopes[at] = right / (1.0 - 2.0 * factors[last - 1])
    for i in range(last - 1, -1, -1):
        for at in range(i * m, (i + 1) * m):
            slopes[at] -= factors[i] * slopes[at + m]


@cfunc(
    "void(int64, float64, CPointer(float64), CPointer(float64), CPointer(float64), "
    "CPointer(float64))",
    error_model="numpy",
)
def pieces(
    n: int,
    period: float,
    values: Pointer[float],
    slopes: Pointer[float],
    factors: Pointer[float],
    coefficients: Pointer[float],
) -> None:
    """Fill coefficients, shape (4, n - 1), highest power first, of the pieces of one signal."""
    count = n - 1
    _slopes(n, 1, values, period, slopes, factors)
    for i in range(count):
        rise = (values[i + 1] - values[i]) / period
        coefficients[i] = (slopes[i] + slopes[i + 1] - 2.0 * rise) / (period * period)
        coefficients[count + i] = (3.0 * rise - 2.0 * slopes[i] - slopes[i + 1]) / period
        coefficients[2 * count + i] = slopes[i]
        coefficients[3 * count + i] = values[i]


@cfunc(
    "void(int64, int64, float64, float64, CPointer(float64), CPointer(float64), CPointer(float64), "
    "CPointer(float64), CPointer(float64))",
    error_model="numpy",
)
def later(
    n: int,
    m: int,
    period: float,
    delay: float,
    values: Pointer[float],
    slopes: Pointer[float],
    factors: Pointer[float],
    read: Pointer[float],
    rate: Pointer[float],
) -> None:
    """Fill the values of columns, shape (n, m), ``delay`` earlier, and how fast the first changed.

    Beyond either end the values stand still.
    """
    _slopes(n, m, values, period, slopes, factors)
    for k in range(n):
        at = k - delay / period
        inside = 0.0 <= at <= n - 1.0
        at = min(max(at, 0.0), n - 1.0)
        i = min(int(at), n - 2)
        s = at - i
        own, next_own = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s)
        slope, next_slope = period * s * (1.0 - s) ** 2, period * s * s * (s - 1.0)
        for j in range(m):
            at_sample, at_next = i * m + j, (i + 1) * m + j
            read[k * m + j] = (
                own * values[at_sample]
                + next_own * values[at_next]
                + slope * slopes[at_sample]
                + next_slope * slopes[at_next]
            )
        rate[k] = 0.0
        if inside:
            first, second = i * m, (i + 1) * m
            rise = 6.0 * s * (1.0 - s) * (values[second] - values[first]) / period
            own, other = (1.0 - s) * (1.0 - 3.0 * s), s * (3.0 * s - 2.0)
            rate[k] = rise + own * slopes[first] + other * slopes[second]
