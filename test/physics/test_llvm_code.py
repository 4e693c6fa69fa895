"""Machine code of expressions gives what SymPy says that they are."""

import ctypes
import hashlib
import warnings

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given, reject, settings
from hypothesis import strategies as st
from llvmlite import ir
from sympy.core.relational import Relational

from tissue_probe.physics import machine_code
from tissue_probe.physics.llvm_code import (
    ARRAY,
    COUNT_TYPE,
    NUMBER,
    TOGETHER,
    Function,
    NotComputableError,
)
from tissue_probe.physics.machine_code import Text

SYMBOLS = sp.symbols("x y", real=True)
X, Y = SYMBOLS
#: A change of the arguments that leaves a well conditioned expression as it is, to ROUGHLY.
SLIGHTLY, ROUGHLY = 1e-10, 1e-6
#: Numbers in the arguments of functions are smaller.
LARGE = 1e3


@pytest.fixture(autouse=True)
def folder(tmp_path_factory, monkeypatch):
    monkeypatch.setenv("TISSUE_PROBE_CACHE", str(tmp_path_factory.mktemp("cache")))


def compiled(module, name, *types):
    text = Text(str(module), (name,), {})
    digest = hashlib.sha256(text.code.encode()).hexdigest()
    code = machine_code.load(f"test_{digest}", lambda: text)
    entry = ctypes.CFUNCTYPE(None, *types)(code.addresses[name])

    def call(*arguments):
        return entry(*(a.ctypes.data if isinstance(a, np.ndarray) else a for a in arguments))

    return call


def value_of(expressions, numbers):
    """What machine code makes of expressions of x and y."""
    module = ir.Module()
    function = Function(module, "values", {"numbers": ARRAY, "filled": ARRAY})
    function.load("numbers", SYMBOLS)
    function.store("filled", function.name_values([sp.sympify(each) for each in expressions]))
    function.end()
    filled = np.zeros(len(expressions))
    compiled(module, "values", *2 * [ctypes.c_void_p])(np.array(numbers, dtype=float), filled)
    return filled


UNARY = [
    *(sp.exp, sp.log, sp.sin, sp.cos, sp.tan, sp.asin, sp.acos, sp.atan, sp.erf, sp.erfc),
    *(sp.sinh, sp.cosh, sp.tanh, sp.asinh, sp.acosh, sp.atanh, sp.floor, sp.ceiling),
    *(sp.sec, sp.csc, sp.cot, sp.sinc, sp.sech, sp.csch, sp.coth),
    *(sp.sign, sp.Abs, sp.Heaviside, sp.sqrt, sp.cbrt),
]
EXPONENTS = [-3, -2, -1, 2, 3, 7, sp.Rational(3, 2), sp.Rational(-1, 2), sp.Rational(2, 3), 0.7]
BINARY = [
    *(sp.Add, sp.Mul, sp.Min, sp.Max, sp.atan2, lambda a, b: a / b),
    lambda a, b: sp.Pow(sp.Abs(a), b),
    lambda a, b: sp.Piecewise((a, a < b), (b**2, b >= 0.5), (a - b, True)),
    lambda a, b: sp.Piecewise((a, sp.And(a > 0, b < 1)), (b, sp.Or(a <= b, b > 2)), (3 * a, True)),
    lambda a, b: sp.Piecewise((a, sp.Not(sp.And(a < b, b > 0))), (2 * b, True)),
    lambda a, b: sp.Piecewise((a * b, sp.Xor(a < 1, b > 1)), (sp.pi * b, True)),
]


def plain(argument):
    """Return a number that is made of others as one: of a tower of them SymPy may never end.

    Large ones are rejected: it may take all memory to tell the floor of their exponential.
    """
    argument = sp.sympify(argument)
    if not argument.is_number or isinstance(argument, sp.NumberSymbol):
        return argument
    value = complex(sp.N(argument))
    if value.imag or not abs(value.real) < LARGE:
        reject()
    return argument if isinstance(argument, sp.Number) else sp.Float(value.real)


def of_reals(function, *arguments):
    """Return a function of expressions; of what is not real SymPy compares nothing."""
    try:
        return function(*map(plain, arguments))
    except (TypeError, ValueError, AttributeError):  # the last of a set that SymPy has not written
        reject()


LEAVES = st.sampled_from([*SYMBOLS, sp.pi, sp.Integer(-2), sp.Rational(3, 4), sp.Float(0.3)])
EXPRESSIONS = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.builds(of_reals, st.sampled_from(UNARY), inner),
        st.builds(lambda e, a: of_reals(sp.Pow, a, e), st.sampled_from(EXPONENTS), inner),
        st.builds(of_reals, st.sampled_from(BINARY), inner, inner),
    ),
    max_leaves=6,
)
NUMBERS = st.tuples(*2 * [st.one_of(st.floats(-3, -1e-3), st.floats(1e-3, 3))])


def by_sympy(expression, numbers):
    """What SymPy's own printer for NumPy and SciPy makes of it."""
    try:
        function = sp.lambdify(SYMBOLS, expression, ["scipy", "numpy"])
    except Exception:  # of pieces within pieces SymPy may fail to simplify the conditions
        reject()
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        value = function(*numbers)
    if np.iscomplexobj(value):
        raise TypeError("complex")
    return float(value)


def parts(expression):
    """The arguments of the jumps in an expression, and both sides of its comparisons."""
    jumps = [each.args[:1] for each in expression.atoms(sp.Heaviside, sp.sign)]
    compared = [each.args for each in expression.atoms(Relational)]
    return [part for each in (*jumps, *compared) for part in each if part.free_symbols]


@pytest.mark.parametrize(
    "count", [25, pytest.param(200, marks=[pytest.mark.battery, pytest.mark.timeout(900)])]
)
def test_code_of_an_expression_gives_what_sympy_gives(count):
    settings(max_examples=count)(given(expression=EXPRESSIONS, numbers=NUMBERS)(check_code))()


def check_code(expression, numbers):
    assume(expression.is_extended_real is not False and not expression.has(sp.nan, sp.zoo))
    try:
        due, near = (
            by_sympy(expression, np.float64(numbers) * factor) for factor in (1.0, 1.0 + SLIGHTLY)
        )
    except TypeError:  # complex for these numbers
        assume(False)
    assume(np.isfinite(due) and abs(due - near) <= ROUGHLY * abs(due))
    # A jump may hide that its argument is no real number.
    assume(all(np.isfinite(by_sympy(each, numbers)) for each in parts(expression)))
    (found,) = value_of([expression], numbers)
    assert found == pytest.approx(due, rel=100 * ROUGHLY, abs=1e-12)


@pytest.mark.parametrize("function", UNARY, ids=lambda function: function.__name__)
def test_every_function_is_exact(function):
    numbers = 0.37, 1.81
    expressions = [function(X), function(Y), function(-X)]
    found = value_of(expressions, numbers)
    for expression, value in zip(expressions, found, strict=True):
        due = sp.N(expression.subs(dict(zip(SYMBOLS, numbers, strict=True))), 30)
        if due.is_real:
            assert value == pytest.approx(float(due), rel=1e-14, abs=1e-16)
        else:
            assert np.isnan(value)


def test_what_has_no_value_is_infinite_or_no_number_and_raises_nothing():
    found = value_of([1 / X, -1 / X, X**-2, 1 / sp.sqrt(X), sp.log(X)], (0.0, -1.0))
    np.testing.assert_array_equal(found, [np.inf, -np.inf, np.inf, np.inf, -np.inf])
    undefined = value_of([sp.log(Y), sp.sqrt(Y), sp.Piecewise((X, Y > 0))], (0.0, -1.0))
    assert np.isnan(undefined).all()


def test_at_a_step_there_is_no_step_yet_and_its_derivative_is_left_out():
    expressions = [sp.sign(X), sp.Heaviside(X), sp.Heaviside(X).diff(X), sp.sign(X).diff(X)]
    np.testing.assert_array_equal(value_of(expressions, (0.0, 0.0)), np.zeros(4))


@pytest.mark.parametrize("refused", [sp.besselj(0, X), sp.floor(X).diff(X), sp.Symbol("z"), sp.I])
def test_what_has_no_machine_code_is_refused(refused):
    with pytest.raises(NotComputableError):
        value_of([sp.Mul(2, refused)], (1.0, 1.0))


def test_rows_are_sums_of_rows_times_factors():
    columns, module = 3 * TOGETHER, ir.Module()
    function = Function(module, "fill", {"factors": ARRAY, "a": ARRAY, "b": ARRAY, "c": ARRAY})
    function.load("factors", SYMBOLS)
    function.fill_rows(
        "c", [{("a", 0): X, ("b", 1): Y}, {}, {("a", 1): X, ("a", 0): sp.Integer(-1)}], columns
    )
    function.add("c", columns + 2, X + Y)
    function.end()
    a, b = np.random.default_rng(0).normal(size=(2, 2, columns))
    filled = np.full((3, columns), np.nan)
    fill = compiled(module, "fill", *4 * [ctypes.c_void_p])
    fill(np.array([2.0, 3.0]), a, b, filled)
    due = np.array([2 * a[0] + 3 * b[1], 0 * a[0], 2 * a[1] - a[0]])
    due[1, 2] += 5.0
    np.testing.assert_allclose(filled, due, rtol=1e-15, atol=1e-15)


@pytest.mark.parametrize("count", [0, 1, 5])
def test_a_loop_goes_through_all_samples(count):
    module = ir.Module()
    arguments = {"count": COUNT_TYPE, "shift": NUMBER, "read": ARRAY, "filled": ARRAY}
    function = Function(module, "shifted", arguments)
    function.name(Y, "shift")
    with function.loop("count") as sample:
        function.load("read", [X], sample)
        function.store("filled", [X + Y], sample)
        function.store("filled", [X * Y], function.in_row(1, sample, "count"))
    function.end()
    types = ctypes.c_int64, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p
    read, filled = np.arange(count, dtype=float), np.zeros((2, count))
    compiled(module, "shifted", *types)(count, 0.5, read, filled)
    np.testing.assert_array_equal(filled, [read + 0.5, read * 0.5])
