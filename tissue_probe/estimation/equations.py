"""The matrices of an estimator's filter as symbols: its equations are written in them.

Contents: names for the quantities of a Kalman filter, and their way into code.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, cached_property

import sympy as sp

from tissue_probe.estimation.layout import StateLayout
from tissue_probe.physics.discretise import (
    BEGUN,
    DISCRETISATIONS,
    ROUGH_TANGENT_TERMS,
    TANGENT_TERMS,
    DiscreteStep,
)
from tissue_probe.physics.effects.effect import TIME
from tissue_probe.physics.model import Model
from tissue_probe.physics.program import Program


class Filter:
    """Mean and covariance of one filter, and the model they are of, as matrices of symbols.

    Attributes
    ----------
    X, P : Matrix, shape (n, 1) and (n, n)
        Mean of the state (the model's states, then its parameters) and covariance of its error.
    Q, I : Matrix (n, n)
        Process noise per sample, identity.
    H : Matrix, shape (1, n)
        Derivative of the output (eq. 18).
    innovation, S, R : Symbol
        Measured minus predicted force [N], its variance, and that of the force's noise [N^2], as
        ``weigh`` returned them.
    considered : Matrix of symbols, shape (q, 1)
        The constants that are known roughly (``considered``), q of them.
    deviations : list of Expr
        Their standard deviations.
    W, d, L : Matrix, shape (n, q), (q, 1), (q, q)
        Of the joint covariance of mean and constants' errors, [W; L] [W; L]^T is the part that is
        due to these errors; d is their mean. Errors are in their standard deviations.

    With ``given`` the mean is not read from the filter's memory: it is the function's arguments.
    From ``workspace`` on the memory is free for intermediate results.
    """

    def __init__(
        self,
        model: Model,
        discretisation: str,
        layout: StateLayout,
        given: bool = False,
        workspace: int | None = None,
    ) -> None:
        self.model = model
        self.layout = layout
        self.program = Program(None if workspace is None else ("memory", workspace))
        self._discretise = DISCRETISATIONS[discretisation]
        self._step = 0
        names = layout.states
        count = len(names)
        upper = [(i, j) for i in range(count) for j in range(i, count)]
        self.X = sp.Matrix([*model.states, *model.parameters])
        if not given:
            self.program.load("memory", 0, names)
        covariance = self.program.load("memory", count, [f"P{i}_{j}" for i, j in upper])
        self.P = sp.Matrix(
            count, count, lambda i, j: covariance[upper.index((min(i, j), max(i, j)))]
        )
        for constant in model.constants:
            self.constant(str(constant))
        self._load_considered()
        self.I = sp.eye(count)
        self.Q = sp.diag(*self.per_state("process_variance"))
        self.S, self.R = sp.symbols("S R", real=True)
        self.H = sp.Matrix([model.output]).jacobian(self.X)
        if not given:
            self._tell_signals(self.H)
        self.innovation = sp.Symbol("innovation", real=True)

    def _load_considered(self) -> None:
        """Read W, d, L and the standard deviations."""
        layout, n = self.layout, len(self.layout.states)
        names = layout.considered
        q = len(names)
        constants = {str(constant): constant for constant in self.model.constants}
        self.considered = sp.Matrix(q, 1, [constants[name] for name in names])
        self.deviations = [self._deviation(name) for name in names]
        place, load = layout.considering, self.program.load
        W = load("memory", place, [f"W{i}_{j}" for i in range(n) for j in range(q)])
        d = load("memory", place + n * q, [f"d{j}" for j in range(q)])
        L = load("memory", place + n * q + q, [f"L{i}_{j}" for i in range(q) for j in range(q)])
        self.W, self.d = sp.Matrix(n, q, W), sp.Matrix(q, 1, d)
        for name, deviation, departure in zip(names, self.deviations, d, strict=True):
            self.program.line(f"{name} += {deviation} * {departure}")
        self.L = sp.Matrix(q, q, L)

    def _deviation(self, name: str) -> sp.Expr:
        """Return the standard deviation of a constant."""
        tolerance = self.constant(f"{name}_tol")
        return self.program.let("sd", tolerance * sp.Symbol(name, real=True))

    def constant(self, name: str) -> sp.Symbol:
        """Return a setting, or a number derived from the settings, as a symbol."""
        return self.program.load("constants", self.layout.constant(name), [name])[0]

    def per_state(self, name: str) -> sp.Matrix:
        """Return a number of each state (prior, process_variance, ...), shape (n, 1)."""
        names = [f"{name}_{state}" for state in self.layout.states]
        return sp.Matrix(self.program.load("constants", self.layout.per_state(name), names))

    def diagonal(self, matrix: sp.Matrix) -> dict[str, sp.Expr]:
        """Return a matrix's element on the diagonal for each state, by its name."""
        return dict(zip(self.layout.states, matrix.diagonal(), strict=True))

    @property
    def inputs(self) -> list[sp.Symbol]:
        """u[t], u[t-1], u[t-2], u[t-3] [m]."""
        return self.program.load("memory", self.layout.history, ["u0", "u1", "u2", "u3"])

    @property
    def force(self) -> sp.Expr:
        """h(X) [N], the predicted force (eq. 10)."""
        self._tell_signals(sp.Matrix([self.model.output]))
        return self.model.output

    @cached_property
    def seen(self) -> sp.Matrix:
        """Root of the predicted force's variance due to the constants' errors [N], shape (1, q)."""
        D = sp.Matrix([self.model.output]).jacobian(self.considered)
        self._tell_signals(D)
        by_constant = [D[j] * self.deviations[j] for j in range(D.cols)]
        return self.let("seen", self.H * self.W + sp.Matrix([by_constant]) * self.L)

    @property
    def time(self) -> sp.Expr:
        """Time of the present sample since the start [s]."""
        count = self.program.load("memory", self.layout.carried("SAMPLES"), ["samples"])[0]
        return count * self.constant("sample_period")

    def _tell_signals(self, expressions: sp.Matrix) -> None:
        """Assign the coil's position and the time, as far as expressions of the output need."""
        if expressions.has(*self.model.course):
            course = self.model.course if self.layout.windowed else self.model.course[:1]
            self.program.load("memory", self.layout.history, list(map(str, course)))
        if expressions.has(TIME):
            self.program.set(str(TIME), self.time)

    @property
    def force_variance(self) -> sp.Expr:
        """H P H^T + R [N^2], the variance of the predicted force with its noise (eqs. 25, 39).

        Where constants are considered, s s^T is a part of it.
        """
        noise = sp.Symbol("noise_variance", real=True)
        self.program.line(f"{noise} = noise(constants, memory)")
        own = (self.H * self.P * self.H.T)[0] + noise
        if not self.considered:
            return own
        return own + (self.seen * self.seen.T)[0]

    def let(self, name: str, value: sp.Matrix) -> sp.Matrix:
        """Give a matrix a name: it is computed once, here."""
        return self.program.let_matrix(name, value)

    @cache  # noqa: B019 - a filter lives as long as its equations are written
    def step(self) -> tuple[sp.Matrix, sp.Matrix]:
        """Return the state one sample later (eq. 20) and the derivative F of this step (eq. 17).

        They are computed where this is called first.
        """
        if not self.model.states:
            return self.X, self.I
        step = self.motion(derivatives=True)
        moving, count = len(self.model.states), len(self.model.parameters)
        by_state = step.jacobian[:, : moving + count]
        F = by_state.col_join(sp.zeros(count, moving).row_join(sp.eye(count)))
        by_constant = step.jacobian[:, moving + count :] * sp.diag(*self.deviations)
        self.B = by_constant.col_join(sp.zeros(count, len(self.considered)))
        return step.states.col_join(self.model.parameters), F

    def step_of(self, point: sp.Matrix) -> sp.Matrix:
        """Return another point's state one sample later (eq. 34)."""
        if not self.model.states:
            return point
        point = self.let("point", point)
        arguments = ["constants", "memory", *map(str, point)]
        self._step += 1
        advanced = sp.symbols(
            [f"advanced{self._step}_{i}" for i in range(len(self.model.states))], real=True
        )
        self.program.line(f"{', '.join(map(str, advanced))}, = step({', '.join(arguments)})")
        return sp.Matrix([*advanced, *point[len(advanced) :]])

    @property
    def linear_states(self) -> int:
        """How many of the first states the step is linear in, the others being given."""
        return len(self.model.states) if self.model.is_linear else 0

    def upper_cholesky(self, matrix: sp.Matrix) -> sp.Matrix:
        """Return the upper triangular U with U U^T = matrix.

        Where rounding left the matrix slightly indefinite, the column of the offending pivot is 0.
        """
        size = matrix.rows
        U = sp.zeros(size, size)
        for j in reversed(range(size)):
            known = sum(U[j, k] ** 2 for k in range(j + 1, size))
            pivot = self.program.let("pivot", sp.Max(matrix[j, j] - known, 0))
            U[j, j] = self.program.let("U", sp.sqrt(pivot))
            inverse = self.program.let("inverse", 1 / U[j, j])
            self.program.line(f"if {pivot} == 0.0: {inverse} = 0.0")
            for i in range(j):
                rest = matrix[i, j] - sum(U[i, k] * U[j, k] for k in range(j + 1, size))
                U[i, j] = self.program.let("U", rest * inverse)
        return U

    def assign(self, X: sp.Matrix, P: sp.Matrix) -> None:
        """Make these the filter's mean and covariance."""
        size = len(self.layout.states)
        X = self.let("mean", X)
        P = self.program.let_symmetric("covariance", P)
        self.program.store("memory", 0, list(X))
        self.program.store("memory", size, [P[i, j] for i in range(size) for j in range(i, size)])

    def store_considered(
        self, W: sp.Matrix | None = None, d: sp.Matrix | None = None, L: sp.Matrix | None = None
    ) -> None:
        """Keep those of W, d and L that have changed."""
        if not self.considered:
            return
        n, q = self.W.shape
        place = self.layout.considering
        if W is not None:
            self.program.store("memory", place, list(self.let("W", W)))
        if d is not None:
            self.program.store("memory", place + n * q, list(self.let("d", d)))
        if L is not None:
            self.program.store("memory", place + n * q + q, list(self.let("L", L)))

    def motion(self, derivatives: bool) -> DiscreteStep:
        """Advance the model's states by one sample; derivatives are by the constants, too."""
        model, terms = self.model, TANGENT_TERMS if derivatives else 0
        if self.considered and derivatives:
            by = sp.Matrix([*model.parameters, *self.considered])
            model, terms = replace(model, parameters=by), ROUGH_TANGENT_TERMS
        period = self.constant("sample_period")
        if self.model.motion.has(TIME):
            self.program.set(str(BEGUN), self.time - period)
        return self._discretise(self.program, model, period, self.inputs, terms)
