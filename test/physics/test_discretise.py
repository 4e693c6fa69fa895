"""The generated step of a model of many states, run as plain Python, against an integrator."""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from tissue_probe.physics.discretise import exact_step
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.program import Program
from tissue_probe.physics.rigs import OWN

CONSTANTS = {"tip_mass": 0.04, "load_cell_stiffness": 9700.0, "load_cell_damping": 0.8}


TISSUE = ("stiffness", "damping", "springpot_stiffness", "springpot_exponent")
MODEL = OWN.compose([EFFECTS["springpot"]])


@pytest.fixture(scope="module")
def step():
    """The generated step: of states, inputs, period and values, in this order."""
    program, period = Program(), sp.Symbol("period", real=True)
    inputs = list(sp.symbols("u0:4", real=True))
    states = exact_step(program, MODEL, period, inputs, tangent_terms=0).states
    names = [*map(str, [*MODEL.states, *inputs, period]), *CONSTANTS, *TISSUE]
    code = program.source(f"step({', '.join(names)})", ", ".join(map(str, states)))
    assert len(code) < 100_000  # rounding of what cancels once made a megabyte of it
    scope = {"math": math}
    exec(code, scope)
    return scope["step"]


@pytest.mark.parametrize(("exponent", "period"), [(0.3, 5e-4), (0.7, 5e-4), (0.3, 2e-3)])
def test_a_ladder_of_branches_is_stepped_exactly(step, exponent, period):
    values = CONSTANTS | dict(zip(TISSUE, (450.0, 5.0, 80.0, exponent), strict=True))
    rng = np.random.default_rng(1)
    start = rng.uniform(-1e-3, 1e-3, len(MODEL.states))
    coil = np.array([2e-3, 1.5e-3, 1e-3, 0.4e-3])  # now, and one, two, three samples ago
    stepped = step(*start, *coil, period, *values.values())

    course = np.polynomial.Polynomial.fit(period * np.array([1, 0, -1, -2]), coil, 3)
    signals = [*MODEL.states, MODEL.input, MODEL.input_rate]
    known = {s: values[str(s)] for s in MODEL.motion.free_symbols.difference(signals)}
    motion = sp.lambdify(signals, list(MODEL.motion.subs(known)))
    solution = solve_ivp(
        lambda t, z: motion(*z, course(t), course.deriv()(t)),
        (0.0, period), start, "DOP853", rtol=1e-12, atol=1e-18, max_step=period / 50,
    )  # fmt: skip
    assert solution.success
    np.testing.assert_allclose(stepped, solution.y[:, -1], rtol=1e-8, atol=1e-12)
