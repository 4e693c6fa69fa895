"""A steady linear model integrated over a recording exactly, step by step, with its tangents.

What belongs here: the transition over one sample and its use, in Numba's Python.
What does not: the model's own equations, which are linked in (``model_functions``); calling it
(``response``).

Imported only where machine code of a model has to be made: that takes seconds.
"""

import numpy as np
from numba import carray, cfunc, njit

from tissue_probe.physics.coil_course import coil_course
from tissue_probe.physics.model_functions import LINKED, output, rate  # noqa: F401

# Terms of the Taylor series; a step is halved until what its terms are of is below LARGEST.
ORDER, LARGEST, HALVINGS = 11, 0.5, 12
# A start of which less is left is forgotten: processors take a hundred times as long to compute
# with numbers as small as decay ends in (subnormal ones).
FORGOTTEN = 1e-100
# Of an index without sign Numba does not ask whether it counts from the end: in half the time.
ONE, TWO, THREE = np.uint64(1), np.uint64(2), np.uint64(3)


@njit(error_model="numpy")
def _add_product(a, b, into):
    """Add a matrix product to what is there."""
    for i in range(a.shape[0]):
        for k in range(a.shape[1]):
            if a[i, k] != 0.0:
                for j in range(b.shape[1]):
                    into[i, j] += a[i, k] * b[k, j]


@njit(error_model="numpy")
def _fill(matrix, value):
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            matrix[i, j] = value


@njit(error_model="numpy")
def _copy(matrix, factor, into):
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            into[i, j] = factor * matrix[i, j]


@njit(error_model="numpy", fastmath={"contract"})
def _add_rows(factors, rows, into):
    """Add rows, one after the other, times their factors: by fours, which takes half the time."""
    width, last = into.size, factors.size - factors.size % 4
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
    for k in range(last, factors.size):
        for j in range(width):
            into[j] += factors[k] * rows[k * width + j]


@njit(error_model="numpy", fastmath={"contract"})
def _add_by_fours(a, rows, into):
    """Add a matrix product to what is there, of flat rows whose length is a multiple of four."""
    n = a.shape[0]
    width = into.size // n
    for i in range(n):
        for j in range(0, width, 4):
            at = i * width + j
            first, second, third, fourth = into[at], into[at + 1], into[at + 2], into[at + 3]
            for k in range(n):
                factor, other = a[i, k], np.uint64(k * width + j)
                first += factor * rows[other]
                second += factor * rows[other + ONE]
                third += factor * rows[other + TWO]
                fourth += factor * rows[other + THREE]
            into[at], into[at + 1], into[at + 2], into[at + 3] = first, second, third, fourth


@njit(error_model="numpy")
def _coefficients(p, z, mode, coil, T, f, slope, M, D):
    """Fill M of (z, w)' = M (z, w) and its derivatives D by the values (see ``_transitions``)."""
    n, q, size = z.size, coil.size // 3 - 1, M.shape[0]
    u, dU = coil[:3], coil[3:]
    for j in range(T.size):
        T[j] = 0.0
    for k in range(-1, n + 2):
        if k >= 0:
            if k < n:
                z[k] = 1.0
            else:
                u[k - n] = 1.0
        rate(0.0, z, p, u, mode, T, dU, f, slope)
        column = size - 1 if k < 0 else k
        for i in range(n):
            M[i, column] = f[i] - (M[i, size - 1] if k >= 0 else 0.0)
            for j in range(q - n):
                constant = D[j, i, size - 1] if k >= 0 else 0.0
                D[j, i, column] = slope[i * q + n + j] - constant
        if k >= 0:
            if k < n:
                z[k] = 0.0
            else:
                u[k - n] = 0.0
    for k in range(3):
        M[n + k, n + k + 1] = k + 1.0


@njit(error_model="numpy")
def _transitions(n, period, M, D, place, E, G, term, terms, new):
    """Discretise a linear model: states and coil a sample later (E), and derivatives by values (G).

    Only by values that have a place; of others they are zero.

    With w = (c0, c1, c2, c3, 1) of the cubic piece c0 + c1 s + c2 s^2 + c3 s^3, which moves on by
    c0' = c1, c1' = 2 c2, c2' = 3 c3, the system z' = A z + B w is homogeneous, (z, w)' = M (z, w),
    and so are its derivatives by a value, whose source is dM (z, w). Both are solved by their
    Taylor series, over a part of the step and then doubled. The rates are affine in (z, u, u'), so
    their coefficients are what they are at zero and at the unit vectors.
    """
    square = 0.0
    for i in range(n):
        for k in range(n):
            square += M[i, k] * M[k, i]
    halvings = 0
    while np.sqrt(square) * period > LARGEST * 2.0**halvings and halvings < HALVINGS:
        halvings += 1
    h = period / 2.0**halvings
    for i in range(M.shape[0]):
        E[i, i], term[i, i] = 1.0, 1.0
    for order in range(1, ORDER + 1):
        for j in range(D.shape[0]):
            if place[j] < 0:
                continue
            _fill(new, 0.0)
            _add_product(M, terms[j], new)
            _add_product(D[j], term, new)
            _copy(new, h / order, terms[j])
            for i in range(M.shape[0]):
                for k in range(M.shape[0]):
                    G[j, i, k] += terms[j, i, k]
        _fill(new, 0.0)
        _add_product(M, term, new)
        _copy(new, h / order, term)
        for i in range(M.shape[0]):
            for k in range(M.shape[0]):
                E[i, k] += term[i, k]
    for _ in range(halvings):
        for j in range(D.shape[0]):
            if place[j] < 0:
                continue
            _fill(new, 0.0)
            _add_product(G[j], E, new)
            _add_product(E, G[j], new)
            _copy(new, 1.0, G[j])
        _fill(new, 0.0)
        _add_product(E, E, new)
        _copy(new, 1.0, E)


@njit(error_model="numpy")
def _by_start(p, z, mode, coil, T, first, row):
    """Fill the output's derivatives by the states: from sample to sample they are times E."""
    n, q = z.size, first.size
    for j in range(n * q):
        T[j] = 0.0
    for i in range(n):
        T[i * q + i] = 1.0
    output(0.0, z, p, coil[:3], mode, T, coil[3:], first)
    for i in range(n):
        row[i] = first[i]
        T[i * q + i] = 0.0


@njit(error_model="numpy")
def _places(D, columns, n, place):
    """Give a place to each value that the motion depends on, -1 to others; return how many do."""
    count = 0
    for j in range(D.shape[0]):
        moves = False
        for i in range(n):
            for k in range(D.shape[2]):
                moves |= D[j, i, k] != 0.0
        for r in range(columns.size):
            moves |= columns[r] == n + j
        place[j] = count if moves else -1
        count += moves
    return count


@njit(error_model="numpy", fastmath={"contract"})
def _run(
    p, z, mode, pieces, changes, columns, period, begins, coil, f, tangents, w, matrices, blocks,
    by_driver, by_value, rows, place, answer, sensitivity,
):  # fmt: skip
    n, q = z.size, sensitivity.shape[1]
    u, dU = coil[:3], coil[3:]
    T, row, new_row = tangents[0], rows[0], rows[1]
    M, E, term, new = matrices[0], matrices[1], matrices[2], matrices[3]
    D, G, terms = blocks[0], blocks[1], blocks[2]
    for i in range(n):
        w[i], z[i] = z[i], 0.0
    _coefficients(p, z, mode, coil, T, f, tangents[1], M, D)
    m = (_places(D, columns, n, place) + 3) // 4 * 4
    _transitions(n, period, M, D, place, E, G, term, terms, new)
    V, V1, by_driver = by_value[0, : n * m], by_value[1, : n * m], by_driver[: (n + 5) * n * m]
    for j in range(q - n):
        if place[j] >= 0:
            for i in range(n):
                for k in range(n + 5):
                    by_driver[(k * n + i) * m + int(place[j])] = G[j, i, k]
    for i in range(n):
        z[i] = w[i]
    w[n + 4] = 1.0
    _by_start(p, z, mode, coil, T, sensitivity[0], row)
    for i in range(n):
        f[i] = row[i]  # what the output takes of a state, the same at all samples
    for sample in range(answer.size):
        last = sample == answer.size - 1
        piece = sample - 1 if last else sample
        coil_course(pieces, changes, columns, piece, period if last else 0.0, u, dU)
        answer[sample] = output(begins + sample * period, z, p, u, mode, T, dU, sensitivity[sample])
        for i in range(n):
            sensitivity[sample, i] = row[i]
        if last:
            break
        for i in range(n):
            w[i], new_row[i] = z[i], 0.0
        for k in range(4):
            w[n + k] = pieces[3 - k, sample]
        for j in range(n * m):
            V1[j] = 0.0
        _add_rows(w, by_driver, V1)
        _add_by_fours(E[:n, :n], V, V1)
        for i in range(n):
            total = 0.0
            for k in range(n + 5):
                total += E[i, k] * w[k]
            z[i] = total
            for k in range(n):
                new_row[k] += row[i] * E[i, k]
            for r in range(columns.size):
                for k in range(4):
                    V1[i * m + int(place[columns[r] - n])] += (
                        E[i, n + k] * changes[r, 3 - k, sample]
                    )
        for i in range(n):
            row[i] = 0.0 if abs(new_row[i]) < FORGOTTEN else new_row[i]
            for j in range(q - n if f[i] != 0.0 else 0):
                if place[j] >= 0:
                    T[i * q + n + j] = V1[i * m + int(place[j])]
        for j in range(n * m):
            V[j] = V1[j]


@cfunc("void(CPointer(CPointer(float64)), CPointer(int64), float64, float64)", error_model="numpy")
def run(arrays, sizes, period, begins):
    """Integrate; ``arrays`` are those of ``_run``, and ``sizes`` as for ``runge_kutta``."""
    n, q, known, s, r, samples, _, _ = carray(sizes, 8)
    size, width = n + 5, (q - n + 3) // 4 * 4
    _run(
        carray(arrays[0], known),
        carray(arrays[1], n),
        carray(arrays[2], s),
        carray(arrays[3], (4, samples - 1)),
        carray(arrays[4], (r, 4, samples - 1)),
        carray(sizes, 8 + r)[8:],
        period,
        begins,
        carray(arrays[5], 3 + 3 * q),
        carray(arrays[6], n),
        carray(arrays[7], (2, n * q)),
        carray(arrays[8], size),
        carray(arrays[9], (4, size, size)),
        carray(arrays[10], (3, q - n, size, size)),
        carray(arrays[11], size * n * width),
        carray(arrays[12], (2, n * width)),
        carray(arrays[13], (2, n)),
        carray(arrays[14], q - n),
        carray(arrays[15], samples),
        carray(arrays[16], (samples, q)),
    )
