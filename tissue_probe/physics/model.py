"""A symbolic model: motion, output and unknown parameters of an instrument on tissue.

What belongs here: what a model consists of, whatever the instrument.
What does not: particular equations (``rigs``, ``effects``) or numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp


@dataclass(frozen=True)
class Model:
    """Equations x' = f(x, u, u', p), y = h(x, u, p) of an instrument on tissue.

    Attributes
    ----------
    states : Matrix of symbols, shape (n, 1)
        What moves, x: for the compliant probe, tip position [m] and velocity [m/s].
    parameters : Matrix of symbols, shape (q, 1)
        What is to be estimated, p: stiffness k [N/m] and damping beta [N s/m] first.
    constants : tuple of symbols
        What is known: masses, the load cell's stiffness and damping.
    input, input_rate : Symbol
        u [m] and u' [m/s].
    motion : Matrix, shape (n, 1)
        f, the time derivative of the states.
    output : Expr
        h, the measured force [N], positive in compression.
    """

    states: sp.Matrix
    parameters: sp.Matrix
    constants: tuple[sp.Symbol, ...]
    input: sp.Symbol
    input_rate: sp.Symbol
    motion: sp.Matrix
    output: sp.Expr

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
        return self.motion.jacobian(signals).free_symbols.isdisjoint(signals)
