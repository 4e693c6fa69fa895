"""Code of a composed model for ``response``: its motion, output and switches, with tangents.

What belongs here: from a ``Model``'s symbols to the source of one generated module.
What does not: running it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import sympy as sp

from tissue_probe.physics.effects.effect import FORCE, POSITION, TIME
from tissue_probe.physics.model import Model
from tissue_probe.physics.program import Program

HEADER = '''"""Generated from the symbols of a model; do not edit."""
import math

from numba import njit

from tissue_probe.physics.response import BEGIN, OUTPUT, RATE, SWITCH, TRUE_POSITION

STATES = {states}
VALUES = {values}
FIRST = {first}
SPREADS = {spreads}
LINEAR = {linear}
COURSE_COLUMNS = {columns}
MOVES_POSITION = {moves}
DELAYS = {delays}
DELAY = {delay}
LATE = {late}
ROUNDED = {rounded}
'''
COMPILE = '\n\n@njit({signature}, cache=True, nogil=True, error_model="numpy")\n{source}\n'
ARGUMENTS = "t, z, p, u, mode, T, dU"


def source(model: Model) -> str:
    """Return the source text of the module that ``response`` runs for a model."""
    values = list(model.values)
    moves = [s for s in values if model.position.has(s)]
    late, delay = model.delay.as_coeff_Mul()
    delays = delay != 0 and late != 0
    columns = [len(model.states) + values.index(s) for s in moves]
    text = HEADER.format(
        states=[str(state) for state in model.states],
        values=[str(value) for value in values],
        first=[float(switch.first) for switch in model.switches],
        spreads=[state.spread for state in model.begin],
        linear=_is_steady(model),
        columns=columns,
        moves=model.position != POSITION,
        delays=delays,
        delay=values.index(delay) if delays else -1,
        late=float(late),
        rounded=values.index(model.rounded) if model.rounded != 0 else -1,
    )
    functions = {
        "RATE": _Function(model, bool(columns)).rate(),
        "OUTPUT": _Function(model, bool(columns)).output(),
        "SWITCH": _Function(model, bool(columns)).switch(),
    }
    for signature, function in functions.items():
        text += COMPILE.format(signature=signature, source=function)
    text += COMPILE.format(signature="BEGIN", source=_begin(model))
    if model.position != POSITION:
        text += COMPILE.format(signature="TRUE_POSITION", source=_position(model, moves))
    return text


def _is_steady(model: Model) -> bool:
    """Whether the motion is affine in states and input, with constant coefficients."""
    if model.switches or not len(model.states):
        return False
    signals = [*model.states, *model.course[:2]]
    coefficients = model.motion.jacobian(signals).free_symbols
    return coefficients.isdisjoint({*signals, TIME}) and not model.motion.has(TIME, model.course[2])


class _Function:
    """One generated function of a model; derivatives go along the tangents' columns."""

    def __init__(self, model: Model, moved: bool) -> None:
        self.model = model
        self.moved = moved
        self.program = Program()

    def rate(self) -> str:
        """Fill the states' rates and their derivatives."""
        motion = self.model.motion
        self._load([*motion])
        named = self._values(motion)
        self.program.store("f", 0, named)
        self._tangents("dT", motion)
        return self.program.source(f"rate({ARGUMENTS}, f, dT)")

    def output(self) -> str:
        """Return what is measured; fill its derivatives."""
        output = sp.Matrix([self.model.output])
        self._load([*output])
        (answer,) = self._values(output)
        self._tangents("dF", output, flat=True)
        return self.program.source(f"output({ARGUMENTS}, dF)", returns=str(answer))

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
        self._load([*conditions, *speed])
        self.program.load("f", 0, list(map(str, rates)))
        self.program.store("g", 0, self._values(conditions))
        self.program.store("rate", 0, self._values(speed))
        self._tangents("dg", conditions)
        return self.program.source(f"switch({ARGUMENTS}, f, g, rate, dg)")

    def _load(self, expressions: Sequence[sp.Expr]) -> None:
        model, program = self.model, self.program
        program.line(f"{TIME} = t")
        program.load("z", 0, list(map(str, model.states)))
        program.load("p", 0, list(map(str, model.values)))
        program.load("u", 0, list(map(str, model.course)))
        program.load("mode", 0, [str(switch.symbol) for switch in model.switches])

    def _values(self, expressions: sp.Matrix) -> list[sp.Expr]:
        return list(self.program.let_matrix("value", expressions))

    def _tangents(self, array: str, rows: sp.Matrix, flat: bool = False) -> None:
        """Fill d rows / d (start, values) = d rows / d states T + d rows / d input dU + direct."""
        model, program = self.model, self.program
        if rows.rows == 0:
            return
        parts = [(rows.jacobian(model.states), "T")] if len(model.states) else []
        if self.moved:
            parts.append((rows.jacobian(model.course), "dU"))
        named = [(program.let_matrix("a", matrix), name) for matrix, name in parts]
        direct = program.let_matrix("b", rows.jacobian(model.values))
        place = (lambda i, j: f"{array}[{j}]") if flat else (lambda i, j: f"{array}[{i}, {j}]")
        program.begin(f"for column in range({len(model.states) + len(model.values)}):")
        for i in range(rows.rows):
            terms = [
                f"{entry} * {name}[{j}, column]"
                for matrix, name in named
                for j, entry in enumerate(matrix[i, :])
                if entry != 0
            ]
            program.line(f"{place(i, 'column')} = {' + '.join(terms) or '0.0'}")
        program.end()
        for i in range(rows.rows):
            for j, entry in enumerate(direct[i, :]):
                if entry != 0:
                    program.line(f"{place(i, len(model.states) + j)} += {entry}")


def _begin(model: Model) -> str:
    """Fill where the states start, for a measured position and force at the first sample."""
    program = Program()
    program.load("p", 0, list(map(str, model.values)))
    program.line(f"{POSITION} = measured")
    program.line(f"{FORCE} = load")
    program.store("z", 0, [state.start for state in model.begin])
    return program.source("begin(p, measured, load, z)")


def _position(model: Model, moves: Sequence[sp.Symbol]) -> str:
    """Fill the true positions of all samples, and their derivatives."""
    program = Program()
    program.load("p", 0, list(map(str, model.values)))
    program.begin("for i in range(measured.size):")
    program.line(f"{TIME} = times[i]")
    program.line(f"{POSITION} = measured[i]")
    wanted = sp.Matrix([model.position, *(model.position.diff(symbol) for symbol in moves)])
    true, *changes = program.let_matrix("a", wanted)
    program.set("true[i]", true)
    for row, change in enumerate(changes):
        program.set(f"changed[{row}, i]", change)
    program.end()
    return program.source("position(times, measured, p, true, changed)")
