"""A steady linear model integrated over a recording exactly, step by step, with its tangents.

Contents: the transition over one sample and its use, in Numba's Python.

Imported only where machine code of a model has to be made: that takes seconds.
"""

from __future__ import annotations

import math

from numba import cfunc

from tissue_probe.physics.coil_course import coil_course
from tissue_probe.physics.model_functions import LINKED, output, rate  # noqa: F401
from tissue_probe.physics.pointers import RUN_TYPE, Pointer, compile_fused, compile_inner, further

# Terms of the Taylor series; a step is halved until their argument is below LARGEST_ARGUMENT.
TAYLOR_TERMS, LARGEST_ARGUMENT, STEP_HALVINGS = 11, 0.5, 24
# A start of which less is left is forgotten: processors take a hundred times as long to compute
# with numbers as small as decay ends in (subnormal ones).
FORGOTTEN = 1e-100


@compile_inner
def _add_product(size: int, a: Pointer[float], b: Pointer[float], into: Pointer[float]) -> None:
    """Add a product of two square matrices to another."""
    for i in range(size):
        for k in range(size):
            factor = a[i * size + k]
            if factor != 0.0:
                for j in range(size):
                    into[i * size + j] += factor * b[k * size + j]


@compile_inner
def _fill(count: int, numbers: Pointer[float], value: float) -> None:
    for i in range(count):
        numbers[i] = value


@compile_inner
def _copy(count: int, numbers: Pointer[float], factor: float, into: Pointer[float]) -> None:
    for i in range(count):
        into[i] = factor * numbers[i]


@compile_inner
def _add(count: int, numbers: Pointer[float], into: Pointer[float]) -> None:
    for i in range(count):
        into[i] += numbers[i]


@compile_fused
def _add_rows(
    count: int, width: int, factors: Pointer[float], rows: Pointer[float], into: Pointer[float]
) -> None:
    """Add rows, one after the other, times their factors: by fours, which takes half the time."""
    last = count - count % 4
    for k in range(0, last, 4):
        a, b, c, d = factors[k], factors[k + 1], factors[k + 2], factors[k + 3]
        first, second, third, fourth = k * width, (k + 1) * width, (k + 2) * width, (k + 3) * width
        for j in range(width):
            into[j] += (
                a * rows[first + j]
                + b * rows[second + j]
                + c * rows[third + j]
                + d * rows[fourth + j]
            )
    for k in range(last, count):
        for j in range(width):
            into[j] += factors[k] * rows[k * width + j]


@compile_fused
def _add_by_fours(
    n: int, stride: int, width: int, a: Pointer[float], rows: Pointer[float], into: Pointer[float]
) -> None:
    """Add a matrix product to a matrix of rows whose length is a multiple of four.

    The rows of ``a`` begin ``stride`` elements after one another.
    """
    for i in range(n):
        for j in range(0, width, 4):
            at = i * width + j
            first, second, third, fourth = into[at], into[at + 1], into[at + 2], into[at + 3]
            for k in range(n):
                factor, other = a[i * stride + k], k * width + j
                first += factor * rows[other]
                second += factor * rows[other + 1]
                third += factor * rows[other + 2]
                fourth += factor * rows[other + 3]
            into[at], into[at + 1], into[at + 2], into[at + 3] = first, second, third, fourth


@compile_inner
def _coefficients(
    n: int,
    order: int,
    q: int,
    p: Pointer[float],
    z: Pointer[float],
    mode: Pointer[float],
    u: Pointer[float],
    dU: Pointer[float],
    T: Pointer[float],
    f: Pointer[float],
    slope: Pointer[float],
    M: Pointer[float],
    D: Pointer[float],
) -> None:
    """Fill M of (z, w)' = M (z, w) and its derivatives D by the values (see ``_transitions``)."""
    size = n + order + 1
    last = size - 1
    _fill(n * q, T, 0.0)
    for k in range(-1, n + 2):
        if k >= 0:
            if k < n:
                z[k] = 1.0
            else:
                u[k - n] = 1.0
        rate(0.0, z, p, u, mode, T, dU, f, slope)
        column = last if k < 0 else k
        for i in range(n):
            M[i * size + column] = f[i] - (M[i * size + last] if k >= 0 else 0.0)
            for j in range(q - n):
                row = (j * size + i) * size
                constant = D[row + last] if k >= 0 else 0.0
                D[row + column] = slope[i * q + n + j] - constant
        if k >= 0:
            if k < n:
                z[k] = 0.0
            else:
                u[k - n] = 0.0
    for k in range(order - 1):
        M[(n + k) * size + n + k + 1] = k + 1.0


@compile_inner
def _transitions(
    size: int,
    n: int,
    values: int,
    period: float,
    M: Pointer[float],
    D: Pointer[float],
    place: Pointer[float],
    E: Pointer[float],
    G: Pointer[float],
    term: Pointer[float],
    terms: Pointer[float],
    new: Pointer[float],
) -> None:
    """Discretise a linear model: states and coil a sample later (E), and derivatives by values (G).

    Only by values that have a place; of others they are zero.

    With w = (c0, c1, c2, c3, ..., 1) of the piece c0 + c1 s + c2 s^2 + c3 s^3 + ..., which moves on
    by c0' = c1, c1' = 2 c2, c2' = 3 c3 and so on, the system z' = A z + B w is homogeneous,
    (z, w)' = M (z, w), and so are its derivatives by a value, whose source is dM (z, w). Both are
    solved by their Taylor series, over a part of the step and then doubled. The rates are affine in
    (z, u, u'), so their coefficients are their values at zero and at the unit vectors.
    """
    whole = size * size
    square = 0.0
    for i in range(n):
        for k in range(n):
            square += M[i * size + k] * M[k * size + i]
    halvings = 0
    while (
        math.sqrt(square) * period > LARGEST_ARGUMENT * 2.0**halvings and halvings < STEP_HALVINGS
    ):
        halvings += 1
    h = period / 2.0**halvings
    for i in range(size):
        E[i * size + i], term[i * size + i] = 1.0, 1.0
    for order in range(1, TAYLOR_TERMS + 1):
        for j in range(values):
            if place[j] < 0:
                continue
            own = further(terms, j * whole)
            _fill(whole, new, 0.0)
            _add_product(size, M, own, new)
            _add_product(size, further(D, j * whole), term, new)
            _copy(whole, new, h / order, own)
            _add(whole, own, further(G, j * whole))
        _fill(whole, new, 0.0)
        _add_product(size, M, term, new)
        _copy(whole, new, h / order, term)
        _add(whole, term, E)
    for _ in range(halvings):
        for j in range(values):
            if place[j] < 0:
                continue
            own = further(G, j * whole)
            _fill(whole, new, 0.0)
            _add_product(size, own, E, new)
            _add_product(size, E, own, new)
            _copy(whole, new, 1.0, own)
        _fill(whole, new, 0.0)
        _add_product(size, E, E, new)
        _copy(whole, new, 1.0, E)


@compile_inner
def _by_start(
    n: int,
    q: int,
    p: Pointer[float],
    z: Pointer[float],
    mode: Pointer[float],
    u: Pointer[float],
    dU: Pointer[float],
    T: Pointer[float],
    first: Pointer[float],
    row: Pointer[float],
) -> None:
    """Fill the output's derivatives by the states: from sample to sample they are times E."""
    _fill(n * q, T, 0.0)
    for i in range(n):
        T[i * q + i] = 1.0
    output(0.0, z, p, u, mode, T, dU, first)
    for i in range(n):
        row[i] = first[i]
        T[i * q + i] = 0.0


@compile_inner
def _places(
    size: int,
    n: int,
    values: int,
    D: Pointer[float],
    columns: Pointer[int],
    r: int,
    place: Pointer[float],
) -> int:
    """Give a place to each value that the motion depends on, -1 to others; return how many do."""
    count = 0
    for j in range(values):
        moves = False
        for i in range(n * size):
            moves |= D[j * size * size + i] != 0.0
        for k in range(r):
            moves |= columns[k] == n + j
        place[j] = count if moves else -1
        count += moves
    return count


@cfunc(RUN_TYPE, error_model="numpy", fastmath={"contract"})
def run(arrays: Pointer[Pointer[float]], sizes: Pointer[int], period: float, begins: float) -> None:
    """Integrate; ``sizes`` as for ``runge_kutta``.

    ``arrays`` are p, z, mode, pieces, changes, coil, those of ``response._exactly``, answer and
    sensitivity.
    """
    n, q, r, samples = sizes[0], sizes[1], sizes[4], sizes[5]
    order, more, columns, count = sizes[8], sizes[10], further(sizes, 11), samples - 1
    size, values = n + order + 1, q - n
    whole = size * size
    p, z, mode, pieces, changes = arrays[0], arrays[1], arrays[2], arrays[3], arrays[4]
    u, dU, f, w = arrays[5], further(arrays[5], 4), arrays[6], arrays[8]
    T, slope = arrays[7], further(arrays[7], n * q)
    M, E = arrays[9], further(arrays[9], whole)
    term, new = further(arrays[9], 2 * whole), further(arrays[9], 3 * whole)
    D, G = arrays[10], further(arrays[10], values * whole)
    terms = further(arrays[10], 2 * values * whole)
    by_driver, row, new_row = arrays[11], arrays[13], further(arrays[13], n)
    place, answer, sensitivity = arrays[14], arrays[15], arrays[16]
    for i in range(n):
        w[i], z[i] = z[i], 0.0
    _coefficients(n, order, q, p, z, mode, u, dU, T, f, slope, M, D)
    m = (_places(size, n, values, D, columns, r, place) + 3) // 4 * 4
    V, V1 = arrays[12], further(arrays[12], n * ((values + 3) // 4 * 4))
    _transitions(size, n, values, period, M, D, place, E, G, term, terms, new)
    for j in range(values):
        if place[j] >= 0:
            for i in range(n):
                for k in range(size):
                    by_driver[(k * n + i) * m + int(place[j])] = G[j * whole + i * size + k]
    for i in range(n):
        z[i] = w[i]
    w[n + order] = 1.0
    _by_start(n, q, p, z, mode, u, dU, T, sensitivity, row)
    for i in range(n):
        f[i] = row[i]  # the output's factor of a state, the same at all samples
    for sample in range(samples):
        last = sample == count
        piece = sample - 1 if last else sample
        since = period if last else 0.0
        coil_course(pieces, changes, columns, r, order, more, count, q, piece, since, u, dU)
        filled = further(sensitivity, sample * q)
        answer[sample] = output(begins + sample * period, z, p, u, mode, T, dU, filled)
        for i in range(n):
            filled[i] = row[i]
        if last:
            break
        for i in range(n):
            w[i], new_row[i] = z[i], 0.0
        for k in range(order):
            w[n + k] = pieces[(order - 1 - k) * count + sample]
        _fill(n * m, V1, 0.0)
        _add_rows(size, n * m, w, by_driver, V1)
        _add_by_fours(n, size, m, E, V, V1)
        for i in range(n):
            total = 0.0
            for k in range(size):
                total += E[i * size + k] * w[k]
            z[i] = total
            for k in range(n):
                new_row[k] += row[i] * E[i * size + k]
            for c in range(r):
                for k in range(order):
                    V1[i * m + int(place[columns[c] - n])] += (
                        E[i * size + n + k] * changes[((c + 1) * order - 1 - k) * count + sample]
                    )
        for i in range(n):
            row[i] = 0.0 if abs(new_row[i]) < FORGOTTEN else new_row[i]
            for j in range(values if f[i] != 0.0 else 0):
                if place[j] >= 0:
                    T[i * q + n + j] = V1[i * m + int(place[j])]
        _copy(n * m, V1, 1.0, V)
