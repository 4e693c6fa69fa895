"""Code of a composed model for ``response``: its motion, output and switches, with tangents.

What belongs here: from a ``Model``'s symbols to the source of one generated module.
What does not: running it.

What depends on the values alone, such as the weights of a ladder of branches, is computed once a
simulation by ``prepare``, and follows the values in ``p``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import sympy as sp

from tissue_probe.physics.effects.effect import FORCE, POSITION, TIME, State
from tissue_probe.physics.model import Model
from tissue_probe.physics.program import Program

HEADER = '''"""Generated from the symbols of a model; do not edit."""
import math

from numba import cfunc

from tissue_probe.physics.model_functions import BEGIN, OUTPUT, POSITION, PREPARE, RATE, SWITCH

states = {states}
values = {values}
first = {first}
spreads = {spreads}
linear = {linear}
course_columns = {columns}
moves_position = {moves}
delays = {delays}
shifts = {shifts}
delay = {delay}
late = {late}
rounded = {rounded}
prepared = {prepared}
width = {width}
'''
# Contracted: a product and a sum are rounded once, as processors do it in one instruction.
COMPILE = '\n\n@cfunc({signature}, error_model="numpy", fastmath={{"contract"}})\n{source}\n'
ARGUMENTS = "t, z, p, u, mode, T, dU"
PREPARED = "prepared"


def source(model: Model) -> str:
    """Return the source text of the module that ``response`` runs for a model."""
    values = list(model.values)
    moves = [s for s in values if model.position.has(s)]
    late, delay = model.delay.as_coeff_Mul()
    delays = delay != 0 and late != 0
    # What switches is not smooth: it answers to a late input instead of being read later itself.
    shifts = delays and bool(model.switches)
    moved = [*moves, delay] if shifts else moves
    columns = [len(model.states) + values.index(s) for s in moved]
    constants = _Constants(values)
    functions = {
        "RATE": _Function(model, bool(columns), constants).rate(),
        "OUTPUT": _Function(model, bool(columns), constants).output(),
        "SWITCH": _Function(model, bool(columns), constants).switch(),
        "BEGIN": _begin(model),
        "PREPARE": constants.source(),
    }
    if model.position != POSITION:
        functions["POSITION"] = _position(model, moves)
    text = HEADER.format(
        states=[str(state) for state in model.states],
        values=[str(value) for value in values],
        first=[float(switch.first) for switch in model.switches],
        spreads=[state.spread for state in model.begin],
        linear=_is_steady(model),
        columns=columns,
        moves=model.position != POSITION,
        delays=delays and not shifts,
        shifts=shifts,
        delay=values.index(delay) if delays else -1,
        late=float(late),
        rounded=values.index(model.rounded) if model.rounded != 0 else -1,
        prepared=len(constants.known),
        width=_width(model),
    )
    for signature, function in functions.items():
        text += COMPILE.format(signature=signature, source=function)
    return text


def _width(model: Model) -> int:
    """Return how many columns the tangents have: start and values, up to a multiple of four.

    Those beyond stay zero; a processor takes four at once, and what is left one at a time.
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
    changing = {*signals, TIME, model.course[2]}
    return coefficients.isdisjoint(changing) and not model.motion.has(TIME, model.course[2])


class _Constants:
    """Expressions of a model's values alone, and the symbols that stand for them."""

    def __init__(self, values: Sequence[sp.Symbol]) -> None:
        self.values = list(values)
        self.known: dict[sp.Expr, sp.Symbol] = {}

    def taken_out(self, expression: sp.Basic) -> sp.Basic:
        """Return an expression with a symbol for each of its parts that no state or input is in."""
        if expression.is_Atom:
            return expression
        if self._is_constant(expression):
            name = sp.Symbol(f"{PREPARED}_{len(self.known)}", real=True)
            return self.known.setdefault(expression, name)
        if not (expression.is_Add or expression.is_Mul):
            return expression.func(*map(self.taken_out, expression.args))
        own = [each for each in expression.args if self._is_constant(each)]
        others = [self.taken_out(each) for each in expression.args if not self._is_constant(each)]
        return expression.func(self.taken_out(expression.func(*own)), *others)

    def _is_constant(self, expression: sp.Basic) -> bool:
        """Whether it is a number that the values give; a condition is none."""
        return isinstance(expression, sp.Expr) and expression.free_symbols.issubset(self.values)

    def load(self, program: Program) -> None:
        """Read them, and the values, from ``p``."""
        program.load("p", 0, list(map(str, [*self.values, *self.known.values()])))

    def source(self) -> str:
        """Write the function that fills what is prepared."""
        program = Program()
        program.load("p", 0, list(map(str, self.values)))
        prepared = program.let_matrix("c", sp.Matrix(len(self.known), 1, list(self.known)))
        program.store("p", len(self.values), list(prepared))
        return program.source("prepare(p)")


@dataclass(frozen=True)
class _Tangents:
    """Derivatives of rows: by the states, by the input's course where values move it, by values."""

    by_state: sp.Matrix
    by_input: sp.Matrix
    by_value: sp.Matrix


class _Function:
    """One generated function of a model; derivatives go along the tangents' columns."""

    def __init__(self, model: Model, moved: bool, constants: _Constants) -> None:
        self.model = model
        self.moved = moved
        self.constants = constants
        self.program = Program()

    def rate(self) -> str:
        """Fill the states' rates and their derivatives."""
        values, tangents = self._named(self.model.motion, self.model.motion)
        self.program.store("f", 0, values)
        self._along(tangents, "dT")
        return self.program.source(f"rate({ARGUMENTS}, f, dT)")

    def output(self) -> str:
        """Return what is measured; fill its derivatives."""
        output = sp.Matrix([self.model.output])
        values, tangents = self._named(output, output)
        self._along(tangents, "dF")
        return self.program.source(f"output({ARGUMENTS}, dF)", returns=str(values[0]))

    def switch(self) -> str:
        """Fill what must stay positive while each switch stays as it is, its rate, derivatives."""
        modes = [switch.symbol for switch in self.model.switches]
        conditions = sp.Matrix(
            [
                sp.Piecewise((switch.on, switch.symbol > 0), (switch.off, True))
                for switch in self.model.switches
            ]
        )
        if not modes:
            return f"def switch({ARGUMENTS}, f, g, rate, dg):\n    return"
        rates = [sp.Symbol(f"rate_of_{state}", real=True) for state in self.model.states]
        states = conditions.jacobian(self.model.states) * sp.Matrix(len(rates), 1, rates)
        coil = sum(
            (conditions.diff(a) * b for a, b in pairwise(self.model.course)),
            sp.zeros(len(modes), 1),
        )
        speed = states + coil + conditions.diff(TIME)
        self.program.load("f", 0, list(map(str, rates)))
        values, tangents = self._named(sp.Matrix([*conditions, *speed]), conditions)
        self.program.store("g", 0, values[: len(modes)])
        self.program.store("rate", 0, values[len(modes) :])
        self._along(tangents, "dg")
        return self.program.source(f"switch({ARGUMENTS}, f, g, rate, dg)")

    def _named(self, values: sp.Matrix, rows: sp.Matrix) -> tuple[list[sp.Expr], _Tangents]:
        """Assign values and all derivatives of rows together: they share most of their terms."""
        model = self.model
        parts = [rows.jacobian(model.states)] if len(model.states) else [sp.zeros(rows.rows, 0)]
        parts.append(rows.jacobian(model.course) if self.moved else sp.zeros(rows.rows, 0))
        parts.append(rows.jacobian(model.values))
        wanted = [self.constants.taken_out(each) for m in (values, *parts) for each in m]
        self._load()
        named = iter(self.program.let_matrix("a", sp.Matrix(len(wanted), 1, wanted)))
        first = [next(named) for _ in values]
        matrices = [sp.Matrix(*m.shape, [next(named) for _ in m]) for m in parts]
        return first, _Tangents(*matrices)

    def _load(self) -> None:
        model, program = self.model, self.program
        program.line(f"{TIME} = t")
        program.load("z", 0, list(map(str, model.states)))
        self.constants.load(program)
        program.load("u", 0, list(map(str, model.course)))
        program.load("mode", 0, [str(switch.symbol) for switch in model.switches])

    def _along(self, tangents: _Tangents, array: str) -> None:
        """Fill d rows / d (start, values) = d rows / d states T + d rows / d input dU + direct."""
        states, columns = len(self.model.states), _width(self.model)
        rows = tangents.by_value.rows
        if rows == 0:
            return
        self.program.begin(f"for column in range({columns}):")
        for i in range(rows):
            terms = [
                f"{entry} * {name}[{j * columns} + column]"
                for matrix, name in ((tangents.by_state, "T"), (tangents.by_input, "dU"))
                for j, entry in enumerate(matrix[i, :])
                if entry != 0
            ]
            self.program.line(f"{array}[{i * columns} + column] = {' + '.join(terms) or '0.0'}")
        self.program.end()
        for i in range(rows):
            for j, entry in enumerate(tangents.by_value[i, :]):
                if entry != 0:
                    self.program.line(f"{array}[{i * columns + states + j}] += {entry}")


def _begin(model: Model) -> str:
    """Fill where the states start, for a measured position and force, then how fast they relax."""
    program = Program()
    program.load("p", 0, list(map(str, model.values)))
    program.line(f"{POSITION} = measured")
    program.line(f"{FORCE} = load")
    rates = [_relaxation_rate(model, state) for state in model.begin]
    program.store("z", 0, [*(state.start for state in model.begin), *rates])
    return program.source("begin(p, measured, load, z)")


def _relaxation_rate(model: Model, state: State) -> sp.Expr:
    """Return the rate at which a branch forgets, of the values alone; 0 for other states."""
    rate = -sp.diff(state.motion, state.symbol)
    known = state.spread == "branch" and rate.free_symbols.issubset(model.values)
    return rate if known else sp.S.Zero


def _position(model: Model, moves: Sequence[sp.Symbol]) -> str:
    """Fill the true positions of all samples, and their derivatives."""
    program = Program()
    program.load("p", 0, list(map(str, model.values)))
    program.begin("for i in range(count):")
    program.line(f"{TIME} = times[i]")
    program.line(f"{POSITION} = measured[i]")
    wanted = sp.Matrix([model.position, *(model.position.diff(symbol) for symbol in moves)])
    true, *changes = program.let_matrix("a", wanted)
    program.set("true[i]", true)
    for row, change in enumerate(changes):
        program.set(f"changed[{row} * count + i]", change)
    program.end()
    return program.source("position(count, times, measured, p, true, changed)")
