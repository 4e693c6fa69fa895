"""From one sample to the next: discrete steps of a model, with their exact derivatives.

What belongs here: how a model's motion is advanced by one sample period, in symbols.
What does not: estimation; a model's equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from tissue_probe.physics.model import Model
from tissue_probe.physics.program import Program

TERMS = 12


@dataclass(frozen=True)
class Step:
    """The states one sample later, and what they depend on.

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
    program: Program, model: Model, period: sp.Symbol, inputs: list[sp.Symbol], derivatives: bool
) -> Step:
    """Advance a model that is linear in its states by the Taylor series of its solution.

    For given parameters x' = A x + B u + C u' + d has the solution e^(A dt) x[t-1] + ..., whose
    Taylor coefficients in time follow from one another,

        x_(j+1) = dt (A x_j + B u_j + C (j+1) u_(j+1) / dt + d [j = 0]) / (j + 1),

    and so do those of its derivatives. Twelve terms give e^(A dt) to 1e-12 while the eigenvalues
    of A dt stay below 0.75; for faster models or slower sampling the step is divided into parts.
    The input is the cubic through u[t-3..t], whose error is of the order (w dt)^4 / 20; a straight
    line would bias k by -k0 (w dt)^2 / 12.

    Parameters
    ----------
    program : Program
        Receives the assignments.
    model : Model
        Linear in its states.
    period : Symbol
        Time between two samples dt [s].
    inputs : list of Symbol
        u[t], u[t-1], u[t-2], u[t-3] [m].
    derivatives : bool
        Whether the Jacobian is wanted too (a filter on sigma points does without).
    """
    if not model.is_linear:
        raise ValueError("the exact step needs a model that is linear in its states")
    parts = program.let("parts", sp.ceiling(sp.Max(1, period * _fastest_rate(model) / 0.75)))
    dt = program.let("dt", period / parts)
    system = _system(program, model, model.motion, dt)
    by_parameter = {
        index: _system(program, model, model.motion.diff(parameter), dt)
        for index, parameter in enumerate(model.parameters)
        if derivatives and model.motion.has(parameter)
    }
    count = len(model.states)
    z = program.variables("z", model.states)
    w = program.variables("w", _from_previous_sample(_cubic(program, inputs), parts))
    t = program.variables("t", sp.eye(count, count + len(by_parameter)) if derivatives else [])
    program.begin(f"for part in range(int({parts})):")
    z_j, t_j, z_sum, t_sum = z, t, z, t
    for j in range(TERMS):
        u_j = [w[j] if j < 4 else 0, (j + 1) * w[j + 1] / dt if j < 3 else 0, int(j == 0)]
        if derivatives:
            forcing = [entry.apply(z_j, u_j) for entry in by_parameter.values()]
            rates = system.state * t_j + sp.Matrix.hstack(sp.zeros(count, count), *forcing)
            t_j = program.let_matrix("t", rates / (j + 1))
            t_sum = t_sum + t_j
        z_j = program.let_matrix("z", system.apply(z_j, u_j) / (j + 1))
        z_sum = z_sum + z_j
    program.assign(z, z_sum)
    program.assign(t, t_sum)
    program.assign(
        w, sp.Matrix([sum(sp.binomial(j, i) * w[j] for j in range(i, 4)) for i in range(4)])
    )
    program.end()
    if not derivatives:
        return Step(z, sp.zeros(count, 0))
    place = {index: count + column for column, index in enumerate(by_parameter)}
    columns = [
        t[:, place[index]] if index in place else sp.zeros(count, 1)
        for index in range(len(model.parameters))
    ]
    return Step(z, sp.Matrix.hstack(t[:, :count], *columns))


@dataclass(frozen=True)
class _System:
    """dt times an affine function of states, input, input rate and 1, as matrices of symbols."""

    state: sp.Matrix
    input: sp.Matrix

    def apply(self, states: sp.Matrix, inputs: list[sp.Expr]) -> sp.Matrix:
        return self.state * states + self.input * sp.Matrix(inputs)


def _system(program: Program, model: Model, motion: sp.Matrix, dt: sp.Symbol) -> _System:
    signals = [*model.states, model.input, model.input_rate]
    constant = motion.subs(dict.fromkeys(signals, 0))
    inputs = motion.jacobian(signals[-2:]).row_join(constant)
    return _System(
        program.let_matrix("a", dt * motion.jacobian(model.states)),
        program.let_matrix("b", dt * inputs),
    )


def euler_step(
    program: Program, model: Model, period: sp.Symbol, inputs: list[sp.Symbol], derivatives: bool
) -> Step:
    """Advance any model by forward Euler, as the paper does (eqs. 6 and 7, Jacobian eq. 17).

    x[t] = x[t-1] + dt f(x[t-1], u[t-1], (u[t-1] - u[t-2]) / dt). Kept to reproduce the paper: it is
    unstable unless beta0 + beta > dt (k0 + k), and biases k by w^2 (beta0 + beta) dt / 2 and beta
    by m w^2 dt. Parameters as for ``exact_step``.
    """
    now = {model.input: inputs[1], model.input_rate: (inputs[1] - inputs[2]) / period}
    states = program.let_matrix("next", model.states + period * model.motion.subs(now))
    if not derivatives:
        return Step(states, sp.zeros(len(states), 0))
    jacobian = (sp.eye(len(states)) + period * model.state_jacobian).row_join(
        period * model.parameter_jacobian
    )
    return Step(states, program.let_matrix("jacobian", jacobian.subs(now)))


DISCRETISATIONS = {"exact": exact_step, "euler": euler_step}


def _fastest_rate(model: Model) -> sp.Expr:
    """Fujiwara's bound on the eigenvalues of df/dx, from its characteristic polynomial [1/s]."""
    coefficients = model.state_jacobian.charpoly().all_coeffs()[1:]
    roots = [sp.Abs(c) ** sp.Rational(1, i) for i, c in enumerate(coefficients, 1)]
    return 2 * sp.Max(*roots)


def _cubic(program: Program, inputs: list[sp.Symbol]) -> sp.Matrix:
    """Coefficients of the cubic through u[t-3..t] in powers of (time - (t-1)) / dt."""
    s = sp.Symbol("s")
    polynomial = sp.interpolate([(1 - i, value) for i, value in enumerate(inputs)], s)
    return program.let_matrix("cubic", sp.Matrix(sp.Poly(polynomial, s).all_coeffs()[::-1]))


def _from_previous_sample(cubic: sp.Matrix, parts: sp.Symbol) -> sp.Matrix:
    """The cubic's coefficients in the time of one part of the step."""
    return sp.Matrix([c / parts**i for i, c in enumerate(cubic)])
