"""Code of a composed model for ``response``: its motion, output and switches, with tangents.

Contents: from a ``Model``'s symbols to LLVM's text of its functions.

Numbers that depend on the values alone, such as the weights of a ladder of branches, are computed
once a simulation by ``prepare``, and follow the values in ``p``.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import sympy as sp
from llvmlite import ir

from tissue_probe.physics.effects.effect import FORCE, INPUT2, POSITION, TIME, State
from tissue_probe.physics.llvm_code import ARRAY, COUNT_TYPE, NUMBER, Function
from tissue_probe.physics.machine_code import Text
from tissue_probe.physics.model import Model

PREPARED = "prepared"
#: Arguments of all functions along the motion: time, states, values and numbers prepared from them,
#: (u, u', u'', the second input), switches, tangents of states and of u.
ALONG = {"t": NUMBER, **dict.fromkeys(("z", "p", "u", "mode", "T", "dU"), ARRAY)}


def text(model: Model) -> Text:
    """Return the functions that ``response`` runs for a model, and the facts that it needs."""
    values = list(model.values)
    moves = [s for s in values if model.position.has(s)]
    late, delay = model.delay.as_coeff_Mul()
    delays = delay != 0 and late != 0
    # A model with switches is not smooth: it answers to a late input instead of being read later
    # itself.
    shifts = delays and bool(model.switches)
    moved = [*moves, delay] if shifts else moves
    columns = [len(model.states) + values.index(s) for s in moved]
    constants = _Constants(values)
    module = ir.Module()
    for write in (_rate, _output, _switch):
        write(_Along(module, model, bool(columns), constants))
    constants.prepare(module)
    _begin(module, model)
    if model.position != POSITION:
        _position(module, model, moves)
    facts = {
        "states": [str(state) for state in model.states],
        "values": [str(value) for value in values],
        "first": [float(switch.first) for switch in model.switches],
        "spreads": [state.spread for state in model.begin],
        "linear": _is_steady(model),
        "course_columns": columns,
        "moves_position": model.position != POSITION,
        "delays": delays and not shifts,
        "shifts": shifts,
        "delay": values.index(delay) if delays else -1,
        "late": float(late),
        "rounded": values.index(model.rounded) if model.rounded != 0 else -1,
        "prepared": len(constants.known),
        "width": _width(model),
        "hears_input2": model.motion.has(INPUT2) or model.output.has(INPUT2),
    }
    return Text(str(module), tuple(each.name for each in module.functions if each.blocks), facts)


def _width(model: Model) -> int:
    """Return how many columns the tangents have: start and values, up to a multiple of four.

    Those beyond stay zero; a processor takes four at once, and the others one at a time.
    """
    return -(-(len(model.states) + len(model.values)) // 4) * 4


def _is_steady(model: Model) -> bool:
    """Whether motion and output are affine in states and input, with constant coefficients.

    Of the output those of the states only: it may move with time and input as it likes.
    """
    if model.switches or not len(model.states):
        return False
    signals = [*model.states, *model.course[:2]]
    output = sp.Matrix([model.output]).jacobian(model.states).free_symbols
    coefficients = model.motion.jacobian(signals).free_symbols | output
    changing = {*signals, TIME, model.course[2], INPUT2}
    later = TIME, model.course[2], INPUT2
    return coefficients.isdisjoint(changing) and not model.motion.has(*later)


class _Constants:
    """Expressions of a model's values alone, and the symbols that stand for them."""

    def __init__(self, values: Sequence[sp.Symbol]) -> None:
        self.values = list(values)
        self.known: dict[sp.Expr, sp.Symbol] = {}

    def take_out(self, expression: sp.Basic) -> sp.Basic:
        """Return an expression with a symbol for each of its parts that no state or input is in."""
        if expression.is_Atom:
            return expression
        if self._is_constant(expression):
            name = sp.Symbol(f"{PREPARED}_{len(self.known)}", real=True)
            return self.known.setdefault(expression, name)
        if not (expression.is_Add or expression.is_Mul):
            return expression.func(*map(self.take_out, expression.args))
        own = [each for each in expression.args if self._is_constant(each)]
        others = [self.take_out(each) for each in expression.args if not self._is_constant(each)]
        return expression.func(self.take_out(expression.func(*own)), *others)

    def _is_constant(self, expression: sp.Basic) -> bool:
        """Whether it is a number that the values give; a condition is none."""
        return isinstance(expression, sp.Expr) and expression.free_symbols.issubset(self.values)

    def load(self, function: Function) -> None:
        """Read them, and the values, from ``p``."""
        function.load("p", [*self.values, *self.known.values()])

    def prepare(self, module: ir.Module) -> None:
        """Add the function that fills the prepared numbers."""
        function = Function(module, "prepare", {"p": ARRAY})
        function.load("p", self.values)
        function.store("p", function.name_values(list(self.known)), len(self.values))
        function.end()


class _Along:
    """The common part of the functions along the motion; derivatives go along the columns."""

    def __init__(self, module: ir.Module, model: Model, moved: bool, constants: _Constants) -> None:
        self.module = module
        self.model = model
        self.moved = moved
        self.constants = constants

    def function(self, name: str, more: Sequence[str], returns: ir.Type | None = None) -> Function:
        """Begin a function that is given ``more`` arrays; code that uses symbols loads them."""
        return Function(self.module, name, ALONG | dict.fromkeys(more, ARRAY), returns)

    def fill(
        self, function: Function, values: sp.Matrix, rows: sp.Matrix, array: str
    ) -> list[sp.Expr]:
        """Fill an array with d rows / d (start, values); return symbols of values.

        That is d rows / d states T + d rows / d input dU + direct. All are computed together: they
        share most of their terms.
        """
        model = self.model
        by_state = rows.jacobian(model.states) if len(model.states) else sp.zeros(rows.rows, 0)
        by_input = rows.jacobian(model.course) if self.moved else sp.zeros(rows.rows, 0)
        parts = (by_state, by_input, rows.jacobian(model.values))
        wanted = [self.constants.take_out(each) for m in (values, *parts) for each in m]
        self._load(function)
        named = iter(function.name_values(wanted))
        first = [next(named) for _ in values]
        by_state, by_input, by_value = (
            sp.Matrix(*m.shape, [next(named) for _ in m]) for m in parts
        )
        terms = [
            {
                (other, j): entry
                for other, matrix in (("T", by_state), ("dU", by_input))
                for j, entry in enumerate(matrix[i, :])
                if entry != 0
            }
            for i in range(rows.rows)
        ]
        columns = _width(model)
        function.fill_rows(array, terms, columns)
        for i, j in np.ndindex(by_value.shape):
            if by_value[i, j] != 0:
                function.add(array, i * columns + len(model.states) + j, by_value[i, j])
        return first

    def _load(self, function: Function) -> None:
        function.name(TIME, "t")
        function.load("z", self.model.states)
        self.constants.load(function)
        function.load("u", [*self.model.course, INPUT2])
        function.load("mode", [switch.symbol for switch in self.model.switches])


def _rate(along: _Along) -> None:
    """Fill the states' rates and their derivatives."""
    function = along.function("rate", ("f", "dT"))
    function.store("f", along.fill(function, along.model.motion, along.model.motion, "dT"))
    function.end()


def _output(along: _Along) -> None:
    """Return the output; fill its derivatives."""
    function = along.function("output", ("dF",), NUMBER)
    output = sp.Matrix([along.model.output])
    function.end(along.fill(function, output, output, "dF")[0])


def _switch(along: _Along) -> None:
    """Fill the value that stays positive while a switch stays as it is, its rate, derivatives."""
    model = along.model
    function = along.function("switch", ("f", "g", "rate", "dg"))
    if model.switches:
        conditions = sp.Matrix(
            [
                sp.Piecewise((switch.on, switch.symbol > 0), (switch.off, True))
                for switch in model.switches
            ]
        )
        count = len(model.switches)
        rates = [sp.Symbol(f"rate_of_{state}", real=True) for state in model.states]
        states = conditions.jacobian(model.states) * sp.Matrix(len(rates), 1, rates)
        coil = sum((conditions.diff(a) * b for a, b in pairwise(model.course)), sp.zeros(count, 1))
        speed = states + coil + conditions.diff(TIME)
        function.load("f", rates)
        values = along.fill(function, sp.Matrix([*conditions, *speed]), conditions, "dg")
        function.store("g", values[:count])
        function.store("rate", values[count:])
    function.end()


def _begin(module: ir.Module, model: Model) -> None:
    """Fill where the states start, by what is measured there, then how fast they relax."""
    measured = dict.fromkeys(("measured", "load", "second"), NUMBER)
    arguments = {"p": ARRAY, **measured, "z": ARRAY}
    function = Function(module, "begin", arguments)
    function.load("p", model.values)
    function.name(POSITION, "measured")
    function.name(FORCE, "load")
    function.name(INPUT2, "second")
    rates = [_relaxation_rate(model, state) for state in model.begin]
    function.store("z", [*(state.start for state in model.begin), *rates])
    function.end()


def _relaxation_rate(model: Model, state: State) -> sp.Expr:
    """Return the rate at which a branch forgets, of the values alone; 0 for other states."""
    rate = -sp.diff(state.motion, state.symbol)
    known = state.spread == "branch" and rate.free_symbols.issubset(model.values)
    return rate if known else sp.S.Zero


def _position(module: ir.Module, model: Model, moves: Sequence[sp.Symbol]) -> None:
    """Fill the true positions of all samples, then, a row for each value, their derivatives."""
    arrays = dict.fromkeys(("times", "measured", "p", "true", "changed"), ARRAY)
    function = Function(module, "position", {"count": COUNT_TYPE, **arrays})
    function.load("p", model.values)
    with function.loop("count") as sample:
        function.load("times", [TIME], sample)
        function.load("measured", [POSITION], sample)
        wanted = [model.position, *(model.position.diff(symbol) for symbol in moves)]
        true, *changes = function.name_values(wanted)
        function.store("true", [true], sample)
        for row, change in enumerate(changes):
            function.store("changed", [change], function.in_row(row, sample, "count"))
    function.end()
