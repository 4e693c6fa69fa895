"""The coil's course between two samples: compiled into each integrator of a model along it."""

from __future__ import annotations

from tissue_probe.physics.pointers import Pointer, compile_inner


@compile_inner
def coil_course(
    pieces: Pointer[float],
    changes: Pointer[float],
    columns: Pointer[int],
    r: int,
    order: int,
    w: int,
    count: int,
    q: int,
    sample: int,
    s: float,
    u: Pointer[float],
    dU: Pointer[float],
) -> None:
    """Fill u, u', u'' and the second input at ``s`` after the sample; derivatives of u by values.

    ``pieces``, ``changes`` and ``columns`` are those of a ``Course`` of ``count`` pieces, each of
    ``order`` coefficients, and ``r`` columns; ``dU`` has three rows of ``q``. ``w`` more rows of
    pieces are the second input's, 0 or 2: it goes on straight between its samples.
    """
    if w != 0:
        at = order * count + sample
        u[3] = pieces[at] * s + pieces[at + count]
    for row in range(-1, r):
        c, at = (pieces if row < 0 else changes), max(row, 0) * order * count + sample
        if order == 4:  # the usual one, in half the time
            c3, c2, c1, c0 = c[at], c[at + count], c[at + 2 * count], c[at + 3 * count]
            value = ((c3 * s + c2) * s + c1) * s + c0
            rate = (3.0 * c3 * s + 2.0 * c2) * s + c1
            curvature = 6.0 * c3 * s + 2.0 * c2
        else:
            value, rate, curvature = 0.0, 0.0, 0.0
            for k in range(order):
                curvature = curvature * s + 2.0 * rate
                rate = rate * s + value
                value = value * s + c[at + k * count]
        if row < 0:
            u[0], u[1], u[2] = value, rate, curvature
        else:
            j = columns[row]
            dU[j], dU[q + j], dU[2 * q + j] = value, rate, curvature
