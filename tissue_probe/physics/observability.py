"""Whether states and parameters can be told from the output: Lie derivatives (paper, II-C).

Contents: the rank test on the model's symbols.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import sympy as sp

from tissue_probe.physics.model import Model


def observability_matrix(model: Model) -> sp.Matrix:
    """Gradients of the output's Lie derivatives (paper, eqs. 13-15), for any composed model.

        row j = d (L_f^j h) / dX,  X = states and parameters,  j = 0 ... n - 1

    The input moves too: L_f h is the derivative of h in time, with u, u', u'', ... as symbols. For
    the compliant probe on Kelvin-Voigt tissue the determinant is

        (k0^4 / m^2) (x x'' - x'^2)

    (eq. 16 is printed with the factor dt^2 / m^3 and with u for u'). It vanishes without motion,
    as the paper says, but also in a constant indentation and in any x = e^(a t).

    Returns
    -------
    Matrix, shape (n, n)
        Of the model's symbols, and ``input_rate`` with a number for each further derivative.
    """
    unknowns = [*model.states, *model.parameters]
    inputs = [model.input, model.input_rate]
    inputs += [sp.Symbol(f"{model.input_rate}_{i}", real=True) for i in range(2, len(unknowns) + 1)]
    derivative, rows = model.output, []
    for _ in unknowns:
        rows.append([sp.diff(derivative, unknown) for unknown in unknowns])
        flow = sum(
            sp.diff(derivative, state) * rate
            for state, rate in zip(model.states, model.motion, strict=True)
        )
        drive = sum(sp.diff(derivative, signal) * rate for signal, rate in pairwise(inputs))
        derivative = sp.expand(flow + drive)
    return sp.Matrix(rows)


def is_observable(matrix: sp.Matrix, values: Mapping[sp.Symbol, float]) -> bool:
    """Whether the observability matrix has full rank where its symbols have these values.

    Rows and columns are scaled first: their units differ by many orders of magnitude.
    """
    numbers = matrix.subs({symbol: sp.nsimplify(value) for symbol, value in values.items()})
    if numbers.free_symbols:
        raise ValueError(f"no value given for {sorted(map(str, numbers.free_symbols))}")
    return bool(numbers.rank() == matrix.cols)
