"""Functions in LLVM's language from symbols: expressions in, instructions out.

Contents: turning expressions into instructions, reading and writing arrays, loops.

Numba would take ten times as long for the same functions, most of it to find the types of variables
that here all are double precision.
"""

# ruff: noqa: N802, N815 (SymPy's printer finds its methods by the names of classes)
from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import count

import sympy as sp
from llvmlite import ir
from sympy.printing.printer import Printer

from tissue_probe.errors import TissueProbeError
from tissue_probe.physics.above import Above

NUMBER, COUNT_TYPE = ir.DoubleType(), ir.IntType(64)
ARRAY = ir.PointerType(NUMBER)
#: Bytes of a number, to which rows are aligned at least.
NUMBER_SIZE = 8
#: So many columns are computed at once; a processor that has less room takes them in parts.
TOGETHER = 4
_COLUMNS = ir.VectorType(NUMBER, TOGETHER)
# A product and a sum are rounded once, as processors do it in one instruction.
_CONTRACTED = ("contract",)
# LLVM's own functions, and those of C's library, by SymPy's names.
_FUNCTIONS = {
    **{name: f"llvm.{name}.f64" for name in ("exp", "log", "sin", "cos", "floor")},
    **{"Abs": "llvm.fabs.f64", "ceiling": "llvm.ceil.f64"},
    **{name: name for name in ("tan", "asin", "acos", "atan", "atan2", "erf", "erfc")},
    **{name: name for name in ("sinh", "cosh", "tanh", "asinh", "acosh", "atanh")},
}
# Functions that SymPy writes by one of these.
_REWRITTEN = {
    **{"sec": sp.cos, "csc": sp.sin, "cot": sp.tan, "sinc": sp.sin},
    **{"sech": sp.cosh, "csch": sp.sinh, "coth": sp.tanh},
}
_RELATIONS = {
    sp.Gt: ">", sp.Ge: ">=", sp.Lt: "<", sp.Le: "<=", sp.Eq: "==", sp.Ne: "!=",
}  # fmt: skip


class NotComputableError(TissueProbeError):
    """An expression holds a function without machine code."""


class Function:
    """One function under construction.

    Its arrays share no memory with one another.

    Parameters
    ----------
    module : ir.Module
        Gets the function.
    name : str
        The function's.
    arguments : mapping
        Of each argument ``NUMBER``, ``COUNT_TYPE`` or ``ARRAY`` (of numbers).
    returns : ir.Type
        The returned type.
    """

    def __init__(
        self,
        module: ir.Module,
        name: str,
        arguments: Mapping[str, ir.Type],
        returns: ir.Type | None = None,
    ) -> None:
        signature = ir.FunctionType(returns or ir.VoidType(), list(arguments.values()))
        self._function = ir.Function(module, signature, name)
        self._function.attributes.add("nounwind")
        self._arguments = dict(zip(arguments, self._function.args, strict=True))
        for argument in self._function.args:
            if argument.type == ARRAY:
                argument.add_attribute("noalias")
        self._builder = ir.IRBuilder(self._function.append_basic_block())
        self._known: dict[str, ir.Value] = {}
        self._printer = _InstructionPrinter(self._builder, self._known)
        self._names = (sp.Symbol(f"_{number}", real=True) for number in count())

    def name(self, symbol: sp.Symbol, argument: str) -> None:
        """Let a symbol stand for an argument that is a number."""
        self._known[symbol.name] = self._arguments[argument]

    def load(self, array: str, symbols: Iterable[sp.Symbol], first: ir.Value | int = 0) -> None:
        """Let symbols stand for consecutive elements of an array, beginning at ``first``."""
        for index, symbol in enumerate(symbols):
            place = self._at(array, self._plus(first, index))
            self._known[symbol.name] = self._builder.load(place)

    def name_values(self, values: Sequence[sp.Expr]) -> list[sp.Expr]:
        """Compute values together, for they may share terms; return symbols, or atoms.

        Raises
        ------
        NotComputableError
            If there is no machine code of something.
        """
        for derivative in set().union(*(value.atoms(sp.Derivative) for value in values)):
            raise _refused(f"the derivative of {derivative.expr.func.__name__}")
        shared, results = sp.cse(values, symbols=self._names)
        for symbol, expression in shared:
            self._known[symbol.name] = self._printer.doprint(expression)
        return [self._named(result) for result in results]

    def _named(self, value: sp.Expr) -> sp.Expr:
        if value.is_Atom:
            return value
        symbol = next(self._names)
        self._known[symbol.name] = self._printer.doprint(value)
        return symbol

    def store(self, array: str, values: Iterable[sp.Expr], first: ir.Value | int = 0) -> None:
        """Write values into consecutive elements of an array, beginning at ``first``."""
        for index, value in enumerate(values):
            place = self._at(array, self._plus(first, index))
            self._builder.store(self._printer.doprint(value), place)

    def add(self, array: str, index: int, value: sp.Expr) -> None:
        """Add a value to an element of an array."""
        place = self._at(array, index)
        before = self._builder.load(place)
        after = self._builder.fadd(before, self._printer.doprint(value), flags=_CONTRACTED)
        self._builder.store(after, place)

    def fill_rows(
        self, array: str, rows: Sequence[Mapping[tuple[str, int], sp.Expr]], columns: int
    ) -> None:
        """Fill rows with sums of rows of other arrays, times factors.

        Parameters
        ----------
        array : str
            Gets the rows, one after the other.
        rows : sequence of mapping
            Of each row the factors, by array and number of the other row.
        columns : int
            Length of every row, a multiple of ``TOGETHER``.
        """
        if not rows:
            return
        used = {factor for row in rows for factor in row.values()}
        factors = {factor: self._on_all_columns(factor) for factor in used}
        with self.loop(columns // TOGETHER) as number:
            column = self._builder.mul(number, ir.Constant(COUNT_TYPE, TOGETHER))
            for i, row in enumerate(rows):
                total = ir.Constant(_COLUMNS, TOGETHER * [0.0])
                for (other, j), factor in row.items():
                    place = self._columns_at(other, self._plus(column, j * columns))
                    term = self._builder.load(place, align=NUMBER_SIZE)
                    term = self._builder.fmul(factors[factor], term, flags=_CONTRACTED)
                    total = self._builder.fadd(total, term, flags=_CONTRACTED)
                place = self._columns_at(array, self._plus(column, i * columns))
                self._builder.store(total, place, align=NUMBER_SIZE)

    @contextmanager
    def loop(self, times: str | int) -> Iterator[ir.Value]:
        """Repeat the code made inside, as often as an argument says; yield the number, from 0."""
        builder, times = self._builder, self._times(times)
        before, test = builder.block, builder.append_basic_block()
        body, after = builder.append_basic_block(), builder.append_basic_block()
        builder.branch(test)
        builder.position_at_end(test)
        number = builder.phi(COUNT_TYPE)
        builder.cbranch(builder.icmp_signed("<", number, times), body, after)
        builder.position_at_end(body)
        yield number
        number.add_incoming(ir.Constant(COUNT_TYPE, 0), before)
        number.add_incoming(self._plus(number, 1), builder.block)
        builder.branch(test)
        builder.position_at_end(after)

    def in_row(self, row: int, index: ir.Value, length: str) -> ir.Value:
        """Return where an element is of rows that are as long as an argument says."""
        start = self._builder.mul(ir.Constant(COUNT_TYPE, row), self._times(length))
        return self._builder.add(start, index)

    def _times(self, times: str | int) -> ir.Value:
        return ir.Constant(COUNT_TYPE, times) if isinstance(times, int) else self._arguments[times]

    def end(self, value: sp.Expr | None = None) -> None:
        """Return from the function, with a value where it has one."""
        if value is None:
            self._builder.ret_void()
        else:
            self._builder.ret(self._printer.doprint(value))

    def _at(self, array: str, index: ir.Value | int) -> ir.Value:
        index = ir.Constant(COUNT_TYPE, index) if isinstance(index, int) else index
        return self._builder.gep(self._arguments[array], [index])

    def _plus(self, index: ir.Value | int, more: int) -> ir.Value:
        if isinstance(index, int):
            return ir.Constant(COUNT_TYPE, index + more)
        return self._builder.add(index, ir.Constant(COUNT_TYPE, more))

    def _columns_at(self, array: str, index: ir.Value) -> ir.Value:
        return self._builder.bitcast(self._at(array, index), ir.PointerType(_COLUMNS))

    def _on_all_columns(self, factor: sp.Expr) -> ir.Value:
        value = self._printer.doprint(factor)
        none = ir.Constant(_COLUMNS, ir.Undefined)
        one = self._builder.insert_element(none, value, ir.Constant(ir.IntType(32), 0))
        first = ir.Constant(ir.VectorType(ir.IntType(32), TOGETHER), TOGETHER * [0])
        return self._builder.shuffle_vector(one, none, first)


class _InstructionPrinter(Printer):  # type: ignore[misc]  # SymPy has no types
    """Instructions for an expression; SymPy finds the method for each kind of node."""

    def __init__(self, builder: ir.IRBuilder, known: Mapping[str, ir.Value]) -> None:
        super().__init__()
        self._builder = builder
        self._known = known

    def doprint(self, expression: sp.Basic) -> ir.Value:
        """Return the value of an expression."""
        return self._print(sp.sympify(expression))

    def emptyPrinter(self, expression: sp.Basic) -> ir.Value:
        raise _refused(expression.func.__name__)

    def _print_Symbol(self, symbol: sp.Symbol) -> ir.Value:
        if symbol.name not in self._known:
            raise NotComputableError(f"nothing tells the symbol {symbol} where it is used")
        return self._known[symbol.name]

    def _print_Number(self, number: sp.Number) -> ir.Value:
        return ir.Constant(NUMBER, float(number))

    _print_NumberSymbol = _print_Number

    def _print_Add(self, expression: sp.Add) -> ir.Value:
        first, *others = map(self._print, expression.args)
        for other in others:
            first = self._builder.fadd(first, other, flags=_CONTRACTED)
        return first

    def _print_Mul(self, expression: sp.Mul) -> ir.Value:
        """Divide once, by the product of all that is below."""
        below = [each for each in expression.args if _is_below(each)]
        above = [each for each in expression.args if not _is_below(each)]
        product = self._product(map(self._print, above))
        if not below:
            return product
        divisor = self._product(self._print(1 / each) for each in below)
        return self._builder.fdiv(product, divisor, flags=_CONTRACTED)

    def _product(self, factors: Iterable[ir.Value]) -> ir.Value:
        product = None
        for factor in factors:
            product = self._builder.fmul(product, factor, flags=_CONTRACTED) if product else factor
        return product or ir.Constant(NUMBER, 1.0)

    def _print_Pow(self, expression: sp.Pow) -> ir.Value:
        if _is_below(expression):
            one = ir.Constant(NUMBER, 1.0)
            return self._builder.fdiv(one, self._print(1 / expression), flags=_CONTRACTED)
        base, exponent = self._print(expression.base), expression.exp
        if not (2 * exponent).is_Integer:
            return self._call("llvm.pow.f64", base, self._print(exponent))
        whole = int(sp.floor(exponent))
        factors = [] if exponent.is_Integer else [self._call("llvm.sqrt.f64", base)]
        return self._product([*factors, *self._whole_power(base, whole)])

    def _whole_power(self, base: ir.Value, power: int) -> Iterator[ir.Value]:
        """Yield factors of a power: some of base, base^2, base^4 and so on."""
        while power:
            if power % 2:
                yield base
            power //= 2
            if power:
                base = self._builder.fmul(base, base, flags=_CONTRACTED)

    def _print_Function(self, expression: sp.Function) -> ir.Value:
        name = expression.func.__name__
        if name in _REWRITTEN:
            return self._print(expression.rewrite(_REWRITTEN[name], deep=False))
        if name not in _FUNCTIONS:
            raise _refused(name)
        return self._call(_FUNCTIONS[name], *map(self._print, expression.args))

    def _call(self, name: str, *arguments: ir.Value) -> ir.Value:
        module = self._builder.module
        function = module.globals.get(name)
        if function is None:
            types = [argument.type for argument in arguments]
            function = ir.Function(module, ir.FunctionType(NUMBER, types), name)
            for attribute in ("nounwind", "readnone"):
                function.attributes.add(attribute)
        return self._builder.call(function, arguments, fastmath=_CONTRACTED)

    def _print_sign(self, expression: sp.sign) -> ir.Value:
        value, zero = self._print(expression.args[0]), ir.Constant(NUMBER, 0.0)
        signed = self._call("llvm.copysign.f64", ir.Constant(NUMBER, 1.0), value)
        return self._builder.select(self._builder.fcmp_ordered("==", value, zero), zero, signed)

    def _print_Heaviside(self, expression: sp.Heaviside) -> ir.Value:
        value, zero = self._print(expression.args[0]), ir.Constant(NUMBER, 0.0)
        above = self._builder.fcmp_ordered(">", value, zero)
        return self._builder.select(above, ir.Constant(NUMBER, 1.0), zero)

    def _print_Above(self, expression: Above) -> ir.Value:
        value, zero = self._print(expression.args[0]), ir.Constant(NUMBER, 0.0)
        above = self._builder.fcmp_ordered(">", value, zero)
        part = self._builder.select(above, value, zero)
        return self._product(self._whole_power(part, int(expression.args[1])))

    def _print_DiracDelta(self, expression: sp.DiracDelta) -> ir.Value:
        return ir.Constant(NUMBER, 0.0)

    def _print_Max(self, expression: sp.Max) -> ir.Value:
        return self._most(">", expression)

    def _print_Min(self, expression: sp.Min) -> ir.Value:
        return self._most("<", expression)

    def _most(self, relation: str, expression: sp.Max | sp.Min) -> ir.Value:
        most, *others = map(self._print, expression.args)
        for other in others:
            better = self._builder.fcmp_ordered(relation, other, most)
            most = self._builder.select(better, other, most)
        return most

    def _print_Piecewise(self, expression: sp.Piecewise) -> ir.Value:
        chosen = ir.Constant(NUMBER, float("nan"))
        for value, condition in reversed(expression.args):
            chosen = self._chosen(condition, self._print(value), chosen)
        return chosen

    def _print_ITE(self, expression: sp.ITE) -> ir.Value:
        condition, *values = expression.args
        return self._chosen(condition, *map(self._print, values))

    def _chosen(self, condition: sp.Basic, value: ir.Value, other: ir.Value) -> ir.Value:
        return self._builder.select(self._print(condition), value, other)

    def _print_Relational(self, expression: sp.Basic) -> ir.Value:
        left, right = map(self._print, expression.args)
        relation = _RELATIONS[expression.func]
        if relation == "!=":
            return self._builder.fcmp_unordered(relation, left, right)
        return self._builder.fcmp_ordered(relation, left, right)

    def _print_And(self, expression: sp.And) -> ir.Value:
        return self._joined(self._builder.and_, expression)

    def _print_Or(self, expression: sp.Or) -> ir.Value:
        return self._joined(self._builder.or_, expression)

    def _print_Xor(self, expression: sp.Xor) -> ir.Value:
        return self._joined(self._builder.xor, expression)

    def _joined(
        self, join: Callable[[ir.Value, ir.Value], ir.Value], expression: sp.Basic
    ) -> ir.Value:
        first, *others = map(self._print, expression.args)
        for other in others:
            first = join(first, other)
        return first

    def _print_Not(self, expression: sp.Not) -> ir.Value:
        return self._builder.not_(self._print(expression.args[0]))

    def _print_BooleanTrue(self, expression: sp.Basic) -> ir.Value:
        return ir.Constant(ir.IntType(1), 1)

    def _print_BooleanFalse(self, expression: sp.Basic) -> ir.Value:
        return ir.Constant(ir.IntType(1), 0)


def _is_below(expression: sp.Basic) -> bool:
    """Whether it is a power of a negative exponent, to divide by."""
    return bool(expression.is_Pow and expression.exp.is_Rational and expression.exp.is_negative)


def _refused(name: str) -> NotComputableError:
    known = sorted((*_FUNCTIONS, *_REWRITTEN))
    return NotComputableError(
        f"no machine code can be made of {name}: use powers, Piecewise, Min, Max, sign, Heaviside "
        f"and {', '.join(known)}"
    )
