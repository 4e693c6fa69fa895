"""The force that a model predicts for a measured motion of the coil, and its sensitivities.

Contents: simulating a whole recording with a composed model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from tissue_probe.physics import code_cache
from tissue_probe.physics.discretise import TANGENT_TERMS, accurate_step
from tissue_probe.physics.model import Model
from tissue_probe.physics.program import Program

FloatArray = NDArray[np.float64]

TEMPLATE = '''"""Generated from the symbols of a model; do not edit."""
import math

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy")
{step}


@njit(
    "void(float64[::1], float64[::1], float64[::1], float64[:, ::1], float64[::1], "
    "float64[:, ::1], float64)",
    cache=True, nogil=True, error_model="numpy",
)
def run(values, z, coil, tangent, force, sensitivity, period):
    for sample in range(coil.size):
        u0 = coil[sample]
        if sample > 0:
            u1 = coil[sample - 1]
            u2 = coil[sample - 2] if sample > 1 else 2.0 * u1 - u0
            u3 = coil[sample - 3] if sample > 2 else 3.0 * u2 - 3.0 * u1 + u0
            step(values, z, tangent, u0, u1, u2, u3, period)
        {output}
'''


@dataclass(frozen=True)
class Simulation:
    """Force [N], shape (n,), and its derivatives by start and parameters, shape (n, states + q)."""

    force: FloatArray
    sensitivity: FloatArray


def simulate(
    name: str,
    model: Model,
    constants: Sequence[float],
    parameters: Sequence[float],
    position: FloatArray,
    sample_period: float,
    start: Sequence[float] | None = None,
) -> Simulation:
    """Simulate a model under a measured motion of the coil.

    Parameters
    ----------
    name : str
        Names the model: its compiled kernel is kept on disk under this name.
    model : Model
        Rig, tissue and effects.
    constants, parameters : sequence of float
        Values of ``model.constants`` and ``model.parameters`` (SI units).
    position : array, shape (n,)
        Displacement u of the coil [m] at each sample, finite.
    sample_period : float
        Time between two samples [s].
    start : sequence of float, optional
        Values of ``model.states`` at the first sample; at rest at 0 by default.
    """
    count, total = len(model.states), len(model.states) + len(model.parameters)
    kernel = code_cache.module(f"simulate_{name}", lambda: _source(model))
    values = np.array([*constants, *parameters], dtype=np.float64)
    z = np.zeros(count) if start is None else np.array(start, dtype=np.float64)
    tangent = np.eye(count, total)
    force = np.empty(position.size)
    sensitivity = np.empty((position.size, total))
    kernel.run(
        values, z, position.astype(np.float64), tangent, force, sensitivity, float(sample_period)
    )
    return Simulation(force, sensitivity)


def _source(model: Model) -> str:
    return TEMPLATE.format(step=_step(model), output=_output(model))


def _step(model: Model) -> str:
    """Advance state and tangent in place: T becomes dz/dz T + [0 | dz/dp]."""
    program = Program()
    count, total = len(model.states), len(model.states) + len(model.parameters)
    _load_values(program, model)
    program.load("z", 0, list(map(str, model.states)))
    inputs = list(sp.symbols("u0 u1 u2 u3", real=True))
    step = accurate_step(program, model, sp.Symbol("period", real=True), inputs, TANGENT_TERMS)
    T = sp.Matrix(count, total, lambda i, j: sp.Symbol(f"T{i}_{j}", real=True))
    for i, j in np.ndindex(count, total):
        program.line(f"{T[i, j]} = tangent[{i}, {j}]")
    by_parameter = sp.zeros(count, count).row_join(step.jacobian[:, count:])
    moved = program.let_matrix("moved", step.jacobian[:, :count] * T + by_parameter)
    program.store("z", 0, list(step.states))
    for i, j in np.ndindex(count, total):
        program.set(f"tangent[{i}, {j}]", moved[i, j])
    return program.source("step(values, z, tangent, u0, u1, u2, u3, period)")


def _output(model: Model) -> str:
    program = Program()
    count, total = len(model.states), len(model.states) + len(model.parameters)
    _load_values(program, model)
    program.load("z", 0, list(map(str, model.states)))
    program.line(f"{model.input} = u0")
    program.set("force[sample]", model.output)
    gradient = sp.Matrix([model.output]).jacobian([*model.states, *model.parameters])
    for j in range(total):
        tangent = [sp.Symbol(f"tangent[{i}, {j}]", real=True) for i in range(count)]
        direct = gradient[j] if j >= count else 0
        value = sum(gradient[i] * tangent[i] for i in range(count)) + direct
        program.set(f"sensitivity[sample, {j}]", value)
    return "\n        ".join(program.lines)


def _load_values(program: Program, model: Model) -> None:
    program.load("values", 0, list(map(str, [*model.constants, *model.parameters])))
