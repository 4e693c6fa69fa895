"""Code of a composed model for other integrators: rates, forces, switches.

Contents: from a ``Model``'s symbols to the source of one generated module, no derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from tissue_probe.physics.effects.effect import FORCE, POSITION, POSITION_RATE, TIME
from tissue_probe.physics.model import Model
from tissue_probe.physics.program import Program

PLANT_HEADER = '''"""Generated from the symbols of a model; do not edit."""
import math

from numba import njit

STATES = {states}
VALUES = {values}
FIRST = {first}
V = "float64[::1]"
ARGUMENTS = f"float64, {{V}}, {{V}}, float64, float64, {{V}}"
'''
COMPILE = '\n\n@njit(f"{types}", cache=True, nogil=True, error_model="numpy")\n{source}\n'
ARGUMENTS = "t, z, p, position, position_rate, mode"


def source(model: Model) -> str:
    """Return the source of a module with the functions of a model.

    With time t [s], states z, values p, the coil's position and velocity, and switches ``mode``:
    ``rate`` fills the states' rates, ``switch`` the values that stay positive while each switch
    stays as it is, ``output`` returns the measured force and ``reaction`` that on the coil [N];
    ``begin`` fills where the states of a probe at rest are, of its position and force.
    """
    conditions = [
        sp.Piecewise((switch.on, switch.symbol > 0), (switch.off, True))
        for switch in model.switches
    ]
    text = PLANT_HEADER.format(
        states=[str(state) for state in model.states],
        values=[str(value) for value in model.values],
        first=[float(switch.first) for switch in model.switches],
    )
    parts = (
        ("void({ARGUMENTS}, {V})", _filling(model, "rate", list(model.motion))),
        ("void({ARGUMENTS}, {V})", _filling(model, "switch", conditions)),
        ("float64({ARGUMENTS})", _returning(model, "output", model.output)),
        ("float64({ARGUMENTS})", _returning(model, "reaction", model.reaction)),
        ("void({V}, float64, float64, {V})", _begin(model)),
    )
    return text + "".join(COMPILE.format(types=types, source=text) for types, text in parts)


def _loaded(model: Model) -> Program:
    program = Program()
    program.line(f"{TIME} = t")
    program.load("z", 0, list(map(str, model.states)))
    program.load("p", 0, list(map(str, model.values)))
    program.load("mode", 0, [str(switch.symbol) for switch in model.switches])
    return program


def _filling(model: Model, name: str, expressions: Sequence[sp.Expr]) -> str:
    program = _loaded(model)
    if expressions:
        program.store("filled", 0, list(program.let_matrix("value", sp.Matrix(expressions))))
    program.line("return")
    return program.source(f"{name}({ARGUMENTS}, filled)")


def _returning(model: Model, name: str, expression: sp.Expr) -> str:
    program = _loaded(model)
    returned = program.let("value", expression)
    return program.source(f"{name}({ARGUMENTS})", returns=f"float({returned})")


def _begin(model: Model) -> str:
    program = Program()
    program.load("p", 0, list(map(str, model.values)))
    program.line(f"{POSITION} = measured")
    program.line(f"{POSITION_RATE} = 0.0")
    program.line(f"{FORCE} = load")
    program.store("z", 0, [state.start for state in model.begin])
    program.line("return")
    return program.source("begin(p, measured, load, z)")
