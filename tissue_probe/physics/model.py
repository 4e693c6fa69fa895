"""A symbolic model: motion, output and unknown parameters of an instrument on tissue.

Contents: the parts of a model, of any instrument.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import sympy as sp

from tissue_probe.physics.effects.effect import POSITION, POSITION_ACCELERATION, State, Switch


@dataclass(frozen=True)
class Model:
    """Equations x' = f(x, u, u', p, t), y = h(x, u, p, t) of an instrument on tissue.

    Attributes
    ----------
    states : Matrix of symbols, shape (n, 1)
        The state x: for the compliant probe, tip position [m] and velocity [m/s].
    parameters : Matrix of symbols, shape (q, 1)
        The parameters p: stiffness k [N/m] and damping beta [N s/m] first.
    constants : tuple of symbols
        The known values: masses, the load cell's stiffness and damping.
    input, input_rate, input_curvature : Symbol
        u, u' and u'': of the coil [m], or, where a force drives, of the measured force [N].
    motion : Matrix, shape (n, 1)
        f, the time derivative of the states.
    output : Expr
        h, the output: the force [N], positive in compression, or, where a force drives, the
        position [m].
    begin : tuple of State
        Every state again, with where it starts.
    switches : tuple of Switch
        Parts that are on or off, and when that changes; their symbols are 0 or 1 in ``motion``.
    position : Expr
        True position of the coil [m], of the measured one, at each sample.
    delay : Expr
        Time by which the output's channel is late [s].
    rounded : Expr
        Step to which the measured position is rounded [m].
    reaction : Expr
        Force of the tip and all behind it on the coil [N], against ``position_rate``.
    """

    states: sp.Matrix
    parameters: sp.Matrix
    constants: tuple[sp.Symbol, ...]
    input: sp.Symbol
    input_rate: sp.Symbol
    motion: sp.Matrix
    output: sp.Expr
    begin: tuple[State, ...] = ()
    switches: tuple[Switch, ...] = ()
    position: sp.Expr = field(default=POSITION)
    delay: sp.Expr = field(default=sp.Integer(0))
    rounded: sp.Expr = field(default=sp.Integer(0))
    reaction: sp.Expr = field(default=sp.Integer(0))
    input_curvature: sp.Symbol = field(default=POSITION_ACCELERATION)

    @cached_property
    def course(self) -> tuple[sp.Symbol, sp.Symbol, sp.Symbol]:
        """The input and its first two derivatives by time."""
        return (self.input, self.input_rate, self.input_curvature)

    @cached_property
    def values(self) -> tuple[sp.Symbol, ...]:
        """Constants, then parameters: everything that a number is needed for."""
        return (*self.constants, *self.parameters)

    @cached_property
    def state_jacobian(self) -> sp.Matrix:
        """df/dx, shape (n, n)."""
        return self.motion.jacobian(self.states)

    @cached_property
    def parameter_jacobian(self) -> sp.Matrix:
        """df/dp, shape (n, q)."""
        return self.motion.jacobian(self.parameters)

    @cached_property
    def is_linear(self) -> bool:
        """Whether the motion is affine in states and input for given parameters."""
        signals = [*self.states, self.input, self.input_rate]
        return bool(self.motion.jacobian(signals).free_symbols.isdisjoint(signals))
