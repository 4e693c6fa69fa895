"""From one sample to the next: discrete steps of a model, with their exact derivatives.

Contents: how a model's motion is advanced by one sample period, in symbols.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp
from sympy.polys.matrices import DomainMatrix

from tissue_probe.physics.effects.effect import TIME
from tissue_probe.physics.model import Model
from tissue_probe.physics.program import Program

# The time at which a step begins [s]: code that steps a model that moves with time assigns it.
BEGUN = sp.Symbol("begun", real=True)

# Of the Taylor series of the motion (exact to 1e-10) and of its derivatives (to 1e-7), while
# Fujiwara's bound on the eigenvalues of A dt stays below LONGEST_STEP.
TERMS = 8
TANGENT_TERMS = 6
# Of the derivatives to 1e-3: enough where more than noise is unknown.
ROUGH_TANGENT_TERMS = 4
LONGEST_EXACT_STEP = 0.6
LONGEST_RUNGE_KUTTA = 0.12
# Into more parts no step is divided, so that none takes seconds: a model so fast, or sampled so
# rarely, is out of reach, and its states end as they may.
MOST_PARTS = 1e4


@dataclass(frozen=True)
class DiscreteStep:
    """The states one sample later, and the symbols that they depend on.

    Attributes
    ----------
    states : Matrix, shape (n, 1)
        x[t] from x[t-1], the parameters and the inputs u[t-3..t].
    jacobian : Matrix, shape (n, n + q)
        d x[t] / d (x[t-1], p).
    """

    states: sp.Matrix
    jacobian: sp.Matrix


def exact_step(
    program: Program, model: Model, period: sp.Symbol, inputs: list[sp.Symbol], tangent_terms: int
) -> DiscreteStep:
    """Advance a model that is linear in its states by the Taylor series of its solution.

    For given parameters x' = A x + B u + C u' + d has the solution e^(A dt) x[t-1] + ..., whose
    Taylor coefficients in time follow from one another,

        x_(j+1) = dt (A x_j + B u_j + C (j+1) u_(j+1) / dt + d [j = 0]) / (j + 1),

    and so do those of its derivatives. For a fast model or slow sampling the step is divided into
    parts, in each of which the series is exact to 1e-10.
    The input is the cubic through u[t-3..t], whose error is of the order (w dt)^4 / 20; a straight
    line would bias k by -k0 (w dt)^2 / 12.

    Parameters
    ----------
    program : Program
        Receives the assignments.
    model : Model
        Linear in its states, and the same at any time.
    period : Symbol
        Time between two samples dt [s].
    inputs : list of Symbol
        u[t], u[t-1], u[t-2], u[t-3] [m].
    tangent_terms : int
        Terms of the Jacobian's series, where there is one; with 0 no Jacobian is returned (a filter
        on sigma points does without).
    """
    if not _is_steady(model):
        raise ValueError("the exact step needs a steady model that is linear in its states")
    share = _share(program, model, period, LONGEST_EXACT_STEP)
    dt = program.let("dt", period * share)
    system = _system(program, model, model.motion, dt)
    by_parameter = {
        index: _system(program, model, model.motion.diff(parameter), dt)
        for index, parameter in enumerate(model.parameters)
        if tangent_terms and model.motion.has(parameter)
    }
    count = len(model.states)
    z = program.variables("z", model.states)
    w = program.variables("w", _cubic(program, inputs, share))
    t = program.variables("t", sp.eye(count, count + len(by_parameter)) if tangent_terms else [])
    elapsed = program.variables("elapsed", [0.0])
    program.begin("while True:")
    z_j, t_j = program.now(z), program.now(t)
    z_sum, t_sum = z_j, t_j
    for j in range(TERMS):
        u_j = [w[j] if j < 4 else 0, (j + 1) * w[j + 1] if j < 3 else 0, int(j == 0)]
        if j < tangent_terms:
            forcing = [entry.apply(z_j, u_j) for entry in by_parameter.values()]
            rates = system.state * t_j + sp.Matrix.hstack(sp.zeros(count, count), *forcing)
            t_j = program.let_matrix("t", rates / (j + 1))
            t_sum = t_sum + t_j
        z_j = program.let_matrix("z", system.apply(z_j, u_j) / (j + 1))
        z_sum = z_sum + z_j
    program.assign(z, z_sum)
    program.assign(t, t_sum)
    _next_part(program, share, elapsed, w)
    if not tangent_terms:
        return DiscreteStep(z, sp.zeros(count, 0))
    t = program.now(t)
    place = {index: count + column for column, index in enumerate(by_parameter)}
    columns = [
        t[:, place[index]] if index in place else sp.zeros(count, 1)
        for index in range(len(model.parameters))
    ]
    return DiscreteStep(z, sp.Matrix.hstack(t[:, :count], *columns))


@dataclass(frozen=True)
class _System:
    """dt times an affine function of the states, and of (u, u', 1) in units of dt."""

    state: sp.Matrix
    input: sp.Matrix

    def apply(self, states: sp.Matrix, inputs: list[sp.Expr]) -> sp.Matrix:
        return self.state * states + self.input * sp.Matrix(inputs)


def _system(program: Program, model: Model, motion: sp.Matrix, dt: sp.Symbol) -> _System:
    signals = [*model.states, model.input, model.input_rate]
    constant = motion.subs(dict.fromkeys(signals, 0))
    by_input, by_rate = motion.diff(model.input), motion.diff(model.input_rate)
    return _System(
        program.let_matrix("a", dt * motion.jacobian(model.states)),
        program.let_matrix("b", sp.Matrix.hstack(dt * by_input, by_rate, dt * constant)),
    )


def runge_kutta_step(
    program: Program, model: Model, period: sp.Symbol, inputs: list[sp.Symbol], tangent_terms: int
) -> DiscreteStep:
    """Advance any model by Runge and Kutta's fourth-order rule, in parts short enough.

    For models that are not linear in their states. Derivatives are those of the rule itself. The
    parts are so short that the force is exact to 1e-6 of itself. Parameters as for ``exact_step``.
    """
    share = _share(program, model, period, LONGEST_RUNGE_KUTTA)
    dt = program.let("dt", period * share)
    count, columns = len(model.states), len(model.states) + len(model.parameters)
    z = program.variables("z", model.states)
    t = program.variables("t", sp.eye(count, columns) if tangent_terms else [])
    w = program.variables("w", _cubic(program, inputs, share))
    elapsed = program.variables("elapsed", [0.0])
    program.begin("while True:")

    def slope(at: sp.Rational, z_at: sp.Matrix, t_at: sp.Matrix) -> tuple[sp.Matrix, sp.Matrix]:
        u = program.let("u", sum(w[i] * at**i for i in range(4)))
        du = program.let("du", sum(i * w[i] * at ** (i - 1) for i in range(1, 4)) / dt)
        signals = [*model.states, model.input, model.input_rate]
        now = dict(zip(signals, [*z_at, u, du], strict=True))
        if model.motion.has(TIME):
            now[TIME] = program.let("time", BEGUN + period * (elapsed[0] + at * share))
        k = program.let_matrix("k", dt * model.motion.subs(now, simultaneous=True))
        if not tangent_terms:
            return k, t
        forcing = sp.zeros(count, count).row_join(model.parameter_jacobian)
        rate = model.state_jacobian.subs(now, simultaneous=True) * t_at
        rate += forcing.subs(now, simultaneous=True)
        return k, program.let_matrix("l", dt * rate)

    half = sp.Rational(1, 2)
    k1, l1 = slope(sp.Integer(0), z, t)
    k2, l2 = slope(half, program.let_matrix("z", z + k1 / 2), t + l1 / 2)
    k3, l3 = slope(half, program.let_matrix("z", z + k2 / 2), t + l2 / 2)
    k4, l4 = slope(sp.Integer(1), program.let_matrix("z", z + k3), t + l3)
    program.assign(z, z + (k1 + 2 * k2 + 2 * k3 + k4) / 6)
    program.assign(t, t + (l1 + 2 * l2 + 2 * l3 + l4) / 6)
    _next_part(program, share, elapsed, w)
    return DiscreteStep(z, t if tangent_terms else sp.zeros(count, 0))


def accurate_step(
    program: Program, model: Model, period: sp.Symbol, inputs: list[sp.Symbol], tangent_terms: int
) -> DiscreteStep:
    """Advance a model exactly where it is linear and steady, else by Runge and Kutta's rule."""
    step = exact_step if _is_steady(model) else runge_kutta_step
    return step(program, model, period, inputs, tangent_terms)


def _is_steady(model: Model) -> bool:
    return model.is_linear and not model.motion.has(TIME)


def euler_step(
    program: Program, model: Model, period: sp.Symbol, inputs: list[sp.Symbol], tangent_terms: int
) -> DiscreteStep:
    """Advance any model by forward Euler, as the paper does (eqs. 6 and 7, Jacobian eq. 17).

    x[t] = x[t-1] + dt f(x[t-1], u[t-1], (u[t-1] - u[t-2]) / dt). Kept to reproduce the paper: it is
    unstable unless beta0 + beta > dt (k0 + k), and biases k by w^2 (beta0 + beta) dt / 2 and beta
    by m w^2 dt. Parameters as for ``exact_step``.
    """
    rate = (inputs[1] - inputs[2]) / period
    now = {model.input: inputs[1], model.input_rate: rate, TIME: BEGUN}
    states = program.let_matrix("next", model.states + period * model.motion.subs(now))
    if not tangent_terms:
        return DiscreteStep(states, sp.zeros(len(states), 0))
    jacobian = (sp.eye(len(states)) + period * model.state_jacobian).row_join(
        period * model.parameter_jacobian
    )
    return DiscreteStep(states, program.let_matrix("jacobian", jacobian.subs(now)))


DISCRETISATIONS = {"exact": accurate_step, "euler": euler_step}


def _share(program: Program, model: Model, period: sp.Symbol, longest: float) -> sp.Symbol:
    """Return which share of the step one part is: 1 unless the model is too fast for that.

    Fujiwara bounds the eigenvalues of A by twice the largest |c_i|^(1/i), the c_i being the
    coefficients of the characteristic polynomial. It is compared squared, to save the root.
    """
    # Entries by name, in polynomials: ten states would take sums of products minutes. In fractions:
    # terms that cancel would else leave their rounding, by the thousands.
    named = program.let_matrix("a", model.state_jacobian).applyfunc(_exact)
    coefficients = [sp.N(c, 17) for c in _characteristic(named)]
    coefficients = program.let_matrix("c", sp.Matrix(coefficients))
    squares = [sp.Abs(c) ** sp.Rational(2, i) for i, c in enumerate(coefficients, 1)]
    square = program.let("speed", (2 * period / longest) ** 2 * sp.Max(*squares))
    share = program.variables("share", [1.0])[0]
    parts = f"min(math.ceil(math.sqrt({square})), {MOST_PARTS})"
    program.line(f"if {square} > 1.0: {share} = 1.0 / {parts}")
    return share


def _characteristic(matrix: sp.Matrix) -> list[sp.Expr]:
    """Return the coefficients of det(s I - A), but the leading one; that of s^(n - 1) first."""
    s = sp.Symbol("s")
    entries = DomainMatrix.from_Matrix(s * sp.eye(matrix.rows) - matrix)
    found = _determinant(entries.to_sdm(), tuple(range(matrix.rows)), entries.domain)
    result: list[sp.Expr] = sp.Poly(entries.domain.to_sympy(found), s).all_coeffs()[1:]
    return result


def _determinant(
    rows: Mapping[int, Mapping[int, Any]], columns: tuple[int, ...], domain: Any
) -> Any:
    """Return the determinant of some columns of a matrix, of whose rows the zeros are left out.

    By Laplace's expansion along the shortest row: in a ladder of branches, each of which feels
    itself and one other state, nearly all are of one term then. Berkowitz's way and Gauss's take
    minutes for it.
    """
    if not columns:
        return domain.one
    if len(rows) < len(columns):
        return domain.zero  # a row without entries is none of them
    first = min(rows, key=lambda row: len(rows[row]))
    above = sorted(rows).index(first)
    total = domain.zero
    for column, entry in rows[first].items():
        place = columns.index(column)
        others = {row: _without(own, column) for row, own in rows.items() if row != first}
        minor = _determinant(others, columns[:place] + columns[place + 1 :], domain)
        total += (-1) ** (above + place) * entry * minor
    return total


def _without(row: Mapping[int, Any], column: int) -> dict[int, Any]:
    return {place: entry for place, entry in row.items() if place != column}


def _exact(entry: sp.Expr) -> sp.Expr:
    """Return the fraction that a floating-point number is."""
    return sp.Rational(float(entry)) if entry.is_Float else entry


def _next_part(program: Program, share: sp.Symbol, elapsed: sp.Matrix, w: sp.Matrix) -> None:
    """Close the loop over the parts of a step: leave it, or move the cubic on by one part."""
    program.assign(elapsed, elapsed + sp.Matrix([share]))
    program.line(f"if {elapsed[0]} > 1.0 - 0.5 * {share}: break")
    later = [sum(sp.binomial(j, i) * w[j] for j in range(i, 4)) for i in range(4)]
    program.assign(w, sp.Matrix(later))
    program.end()


def _cubic(program: Program, inputs: list[sp.Symbol], share: sp.Symbol) -> sp.Matrix:
    """Coefficients of the cubic through u[t-3..t] in powers of (time - (t-1)) / (share dt)."""
    s = sp.Symbol("s")
    polynomial = sp.interpolate([(1 - i, value) for i, value in enumerate(inputs)], s)
    coefficients = sp.Poly(polynomial, s).all_coeffs()[::-1]
    return program.let_matrix("w", sp.Matrix([c * share**i for i, c in enumerate(coefficients)]))
