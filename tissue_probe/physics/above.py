"""Power of the part of a number above 0, as a function in symbols of which tables are made."""

from __future__ import annotations

import sympy as sp


class Above(sp.Function):  # type: ignore[misc]  # SymPy has no types
    """Power n of the part of a real number y above 0: max(y, 0)^n, n = 1, 2, ...

    Of ``sp.Max`` SymPy asks at each step which of its arguments is larger, which takes most of the
    time that a table's derivatives need.
    """

    nargs = 2
    is_extended_real = True
    is_extended_nonnegative = True

    @classmethod
    def eval(cls, y: sp.Expr, n: sp.Expr) -> sp.Expr | None:
        """Return the value of numbers, and a step for the power 0."""
        if n == 0:
            return sp.Heaviside(y)
        return max(y, sp.S.Zero) ** n if y.is_Number else None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """Return the derivative by y."""
        y, n = self.args
        return n * Above(y, n - 1)
