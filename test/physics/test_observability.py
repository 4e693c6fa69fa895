"""The paper's rank test (II-C), corrected."""

import pytest
import sympy as sp

from tissue_probe.physics.effects.standard_linear_solid import STANDARD_LINEAR_SOLID
from tissue_probe.physics.observability import is_observable, observability_matrix
from tissue_probe.physics.rigs import OWN

MODEL = OWN.compose()
X, V = MODEL.states
K, B = MODEL.parameters
M, K0, B0 = MODEL.constants
INPUTS = [MODEL.input, MODEL.input_rate, *sp.symbols("position_rate_2:5", real=True)]


def motion(x, v, u, *rates):
    values = {X: x, V: v, K: 450, B: 5, M: sp.Rational(1, 25), K0: 9700, B0: sp.Rational(4, 5)}
    return values | dict(zip(INPUTS, (u, *rates, 0, 0, 0), strict=False))


def test_the_determinant_is_that_of_equation_16_with_its_errors_mended():
    determinant = observability_matrix(MODEL).det()
    acceleration = MODEL.motion[1]
    assert sp.simplify(determinant - K0**4 / M**2 * (X * acceleration - V**2)) == 0


def test_a_moving_tip_tells_stiffness_and_damping():
    matrix = observability_matrix(MODEL)
    assert is_observable(matrix, motion(x=0.001, v=0.01, u=0.0012))


@pytest.mark.parametrize("state", ["no motion", "constant indentation", "exponential"])
def test_some_motions_tell_nothing_though_the_paper_says_so_only_of_rest(state):
    matrix = observability_matrix(MODEL)
    x = sp.Rational(1, 1000)
    values = {
        "no motion": motion(0, 0, 0, 0),
        # k0 (u - x) = k x
        "constant indentation": motion(x, 0, x * sp.Rational(10150, 9700), 0),
        "exponential": _exponential(x, sp.Integer(20)),
    }[state]
    assert not is_observable(matrix, values)


def _exponential(x, a):
    """x = e^(a t) solves eq. 1 under u = c e^(a t)."""
    c = (a**2 / 25 + 10150 + a * sp.Rational(29, 5)) / (9700 + a * sp.Rational(4, 5))
    return motion(x, a * x, *(c * x * a**i for i in range(5)))


def test_a_constant_force_can_be_told_apart_too():
    matrix = observability_matrix(OWN.compose(force_offset=True))
    values = motion(sp.Rational(1, 1000), sp.Rational(1, 100), sp.Rational(3, 2000), 1, 7, 3)
    names = {symbol.name: symbol for symbol in matrix.free_symbols}
    values |= {names[n]: 0 for n in names if names[n] not in values}
    assert is_observable(matrix, values)


def test_a_relaxing_branch_can_be_told_apart_too():
    model = OWN.compose([STANDARD_LINEAR_SOLID])
    matrix = observability_matrix(model)
    values = motion(sp.Rational(1, 1000), sp.Rational(1, 100), sp.Rational(3, 2000), 1, 7, 3)
    numbers = iter([300, 40, sp.Rational(1, 5000), 2, 5, 1, 3])
    for symbol in sorted(matrix.free_symbols - set(values), key=str):
        values[symbol] = next(numbers)
    assert is_observable(matrix, values)


def test_a_forgotten_value_is_named():
    with pytest.raises(ValueError, match="tip_velocity"):
        is_observable(observability_matrix(MODEL), {X: 1})
