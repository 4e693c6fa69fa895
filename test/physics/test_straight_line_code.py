"""Generated code does what its symbols say."""

import numpy as np
import pytest
import sympy as sp
from numba import njit

from tissue_probe.physics.program import MANY_VARIABLES, Program


@pytest.mark.parametrize("count", [3, MANY_VARIABLES + 1])
def test_variables_change_all_at_once_however_many_they_are(count):
    program = Program()
    turned = program.variables("turned", sp.Matrix(range(count)))
    program.begin("for _ in range(2):")
    now = program.now(turned)
    program.assign(turned, sp.Matrix([*now[1:], now[0]]))
    program.end()
    scope = {"np": np}
    exec(program.source("turn()", ", ".join(map(str, turned))), scope)
    assert list(scope["turn"]()) == [*range(2, count), 0, 1]


def test_many_variables_are_one_to_the_compiler():
    """Numba takes minutes for a loop over 120 variables in a function of 1700 lines."""
    program = Program()
    program.variables("t", sp.eye(10, 12))
    text = program.source("start()")
    assert text.count("np.empty(120)") == 1
    assert "t_1[119]" in text


@pytest.mark.parametrize("power", [-1, -2, -3])
def test_zero_to_a_negative_power_is_infinite_and_raises_nothing(power):
    """A process without Numba has no way to raise."""
    program = Program()
    (a,) = program.load("p", 0, ["a"])
    scope = {}
    exec(program.source("power(p)", str(program.let("value", a**power))), scope)
    compiled = njit(scope["power"], error_model="numpy")
    assert compiled(np.zeros(1)) == np.inf
    assert compiled(np.full(1, 2.0)) == 2.0**power
