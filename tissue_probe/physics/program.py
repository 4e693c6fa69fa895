"""Straight-line code from symbols: matrix equations in, scalar Python for Numba out.

Contents: turning expressions into assignments and assignments into source text.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter


class _PythonPrinter(PythonCodePrinter):  # type: ignore[misc]  # SymPy has no types
    """Python that loses no digit of a constant."""

    def _print_Float(self, expression: sp.Float) -> str:  # noqa: N802
        return repr(float(expression))

    def _print_Pow(self, expression: sp.Pow, rational: bool = False) -> str:  # noqa: N802
        # Numba raises where zero is taken to a negative power; one over zero is infinity.
        if expression.exp.is_Integer and expression.exp < -1:
            return f"(1.0 / {self._print(1 / expression)})"
        return str(super()._print_Pow(expression, rational))

    def _print_Heaviside(self, expression: sp.Expr) -> str:  # noqa: N802
        return f"(1.0 if {self._print(expression.args[0])} > 0 else 0.0)"

    def _print_Above(self, expression: sp.Expr) -> str:  # noqa: N802
        number, power = map(self._print, expression.args)
        return f"(max({number}, 0.0) ** {power})"

    def _print_DiracDelta(self, expression: sp.Expr) -> str:  # noqa: N802
        return "0.0"


_printer = _PythonPrinter()

# More variables than these are kept in an array: the time that Numba takes to compile a loop grows
# with the number of its variables times the length of the function.
MANY_VARIABLES = 30


class Program:
    """Assignments in the order they were made, each to a name of its own.

    A matrix product spelt out in scalars is some 36 times faster than the same product of small
    arrays in Numba, and zeros and ones of a Jacobian vanish from it.

    Parameters
    ----------
    workspace : tuple of str and int
        Name of an array, and the first of its elements that this code may use as it likes. Without
        one, arrays are made where they are needed.
    """

    def __init__(self, workspace: tuple[str, int] | None = None) -> None:
        self.lines: list[str] = []
        #: How many numbers of the workspace are used.
        self.used = 0
        self._workspace = workspace
        self._names = 0
        self._loaded: dict[int, str] = {}

    def load(self, array: str, first: int, names: Sequence[str]) -> list[sp.Symbol]:
        """Read consecutive elements of an array, beginning at ``first``, into symbols.

        A variable that is not used afterwards is not read: Numba takes its time for every line.
        """
        for index, name in enumerate(names, first):
            self._loaded[len(self.lines)] = name
            self.lines.append(f"{name} = {array}[{index}]")
        return [sp.Symbol(name, real=True) for name in names]

    def store(self, array: str, first: int, values: Sequence[sp.Expr]) -> None:
        """Write values into consecutive elements of an array, beginning at ``first``."""
        for index, value in enumerate(values, first):
            self.set(f"{array}[{index}]", value)

    def set(self, place: str, value: sp.Expr) -> None:
        """Write one value to a place given as source, such as ``force[sample]``."""
        self.lines.append(f"{place} = {_printer.doprint(value)}")

    def let(self, name: str, value: sp.Expr) -> sp.Expr:
        """Assign one expression, and return the symbol that now stands for it."""
        return self.let_matrix(name, sp.Matrix([value]))[0]

    def let_matrix(self, name: str, value: sp.Matrix) -> sp.Matrix:
        """Assign every element that is neither number nor symbol already; return the symbols."""
        value = sp.Matrix(value)
        atoms = [entry.is_Atom for entry in value]
        temporaries, expressions = sp.cse(
            [entry for entry, atom in zip(value, atoms, strict=True) if not atom],
            symbols=(sp.Symbol(f"_{self._next()}", real=True) for _ in iter(int, 1)),
        )
        for symbol, expression in temporaries:
            self.lines.append(f"{symbol} = {_printer.doprint(expression)}")
        remaining = iter(expressions)
        entries = []
        for entry, atom in zip(value, atoms, strict=True):
            if not atom:
                symbol = sp.Symbol(f"{name}_{self._next()}", real=True)
                self.lines.append(f"{symbol} = {_printer.doprint(next(remaining))}")
                entry = symbol
            entries.append(entry)
        return sp.Matrix(*value.shape, entries)

    def let_symmetric(self, name: str, value: sp.Matrix) -> sp.Matrix:
        """Assign the upper triangle of a symmetric matrix; return the whole of it."""
        size = value.rows
        upper = [(i, j) for i in range(size) for j in range(i, size)]
        symbols = self.let_matrix(name, sp.Matrix([value[i, j] for i, j in upper]))
        place = dict(zip(upper, symbols, strict=True))
        return sp.Matrix(size, size, lambda i, j: place[min(i, j), max(i, j)])

    def variables(self, name: str, start: sp.Matrix) -> sp.Matrix:
        """Introduce variables, which a loop may assign anew, with their values at the start."""
        start = sp.Matrix(start)
        count, own = len(start), f"{name}_{self._next()}"
        names = (
            self._elements(own, count)
            if count > MANY_VARIABLES
            else [f"{own}_{i}" for i in range(count)]
        )
        symbols = sp.Matrix(*start.shape, [sp.Symbol(each, real=True) for each in names])
        self.assign(symbols, start)
        return symbols

    def _elements(self, name: str, count: int) -> list[str]:
        """Return as many elements of the workspace, or of a new array of this name."""
        if self._workspace is None:
            self.line(f"{name} = np.empty({count})")
            return [f"{name}[{i}]" for i in range(count)]
        array, first = self._workspace
        first += self.used
        self.used += count
        return [f"{array}[{i}]" for i in range(first, first + count)]

    def now(self, variables: sp.Matrix) -> sp.Matrix:
        """Return symbols for the present values of variables; those in an array are read once."""
        if len(variables) <= MANY_VARIABLES:
            return variables
        symbols = [sp.Symbol(f"now_{self._next()}", real=True) for _ in variables]
        for symbol, variable in zip(symbols, variables, strict=True):
            self.set(str(symbol), variable)
        return sp.Matrix(*variables.shape, symbols)

    def assign(self, variables: sp.Matrix, values: sp.Matrix) -> None:
        """Give variables new values, all at once."""
        if len(variables) > MANY_VARIABLES:
            for variable, value in zip(variables, self.let_matrix("new", values), strict=True):
                self.set(str(variable), value)
        elif len(variables):
            values = ", ".join(_printer.doprint(value) for value in values)
            self.line(f"{', '.join(map(str, variables))}, = {values},")

    def line(self, text: str) -> None:
        """Add a line of source as it is."""
        self.lines.append(text)

    def begin(self, text: str) -> None:
        """Open an indented block (a loop, a branch)."""
        self.line(text)
        self.line("<indent>")

    def end(self) -> None:
        """Close the block opened last."""
        self.line("<dedent>")

    def source(self, signature: str, returns: str = "") -> str:
        """Return the source of a function with these assignments as its body."""
        text, depth = [f"def {signature}:"], 1
        for line in [*self._used_lines(returns), *([f"return {returns}"] if returns else [])]:
            if line == "<indent>":
                depth += 1
            elif line == "<dedent>":
                depth -= 1
            else:
                text.append("    " * depth + line)
        return "\n".join(text)

    def _used_lines(self, returns: str) -> list[str]:
        """Return all lines but those that load a variable which no other uses."""
        others = [line for i, line in enumerate(self.lines) if i not in self._loaded]
        used = set(re.findall(r"\w+", " ".join([*others, returns])))
        lines = enumerate(self.lines)
        return [line for i, line in lines if i not in self._loaded or self._loaded[i] in used]

    def _next(self) -> int:
        self._names += 1
        return self._names
