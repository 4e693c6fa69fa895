"""The coil's course between two samples: compiled into whatever integrates a model along it."""

from numba import njit


@njit(error_model="numpy")
def coil_course(pieces, changes, columns, sample, s, u, dU):
    """Fill u, u', u'' at ``s`` after the sample, and their derivatives by the values.

    ``pieces``, ``changes`` and ``columns`` are those of a ``Course``; ``dU`` has three rows.
    """
    for row in range(-1, columns.size):
        c = pieces if row < 0 else changes[row]
        c3, c2, c1, c0 = c[0, sample], c[1, sample], c[2, sample], c[3, sample]
        at = ((c3 * s + c2) * s + c1) * s + c0
        rate = (3.0 * c3 * s + 2.0 * c2) * s + c1
        if row < 0:
            u[0], u[1], u[2] = at, rate, 6.0 * c3 * s + 2.0 * c2
        else:
            j, q = columns[row], dU.size // 3
            dU[j], dU[q + j], dU[2 * q + j] = at, rate, 6.0 * c3 * s + 2.0 * c2
