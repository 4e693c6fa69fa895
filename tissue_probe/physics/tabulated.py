"""A function that is given by a table, as an expression that an effect may have.

Contents: a natural cubic spline through the table's points, in symbols.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy as sp
from scipy.interpolate import CubicSpline

from tissue_probe.physics.above import Above


def tabulated(signal: sp.Expr, at: Sequence[float], values: Sequence[float]) -> sp.Expr:
    """Return the smoothest function through a table's points, straight beyond them.

    Parameters
    ----------
    signal : Expr
        The argument of the function, such as ``INDENTATION``.
    at, values : sequence of float
        The table, ``at`` rising; the function has the unit of ``values``.
    """
    knots = np.asarray(at, dtype=np.float64)
    size = float(np.max(np.abs(knots)))
    through = CubicSpline(knots / size, values, bc_type="natural")
    share = signal / size
    bends = np.diff(np.concatenate([[0.0], through.c[0], [0.0]]))
    first, slope = float(through.c[3, 0]), float(through.c[2, 0])
    straight = first + slope * (share - float(knots[0] / size))
    return straight + sum(
        float(bend) * Above(share - float(knot), 3)
        for bend, knot in zip(bends, knots / size, strict=True)
    )
