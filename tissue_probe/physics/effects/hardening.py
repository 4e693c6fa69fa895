"""Hardening: the tissue stiffens the farther it is indented."""

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_POSITION, Effect, Parameter

CUBIC = sp.Symbol("cubic_stiffness", real=True)

HARDENING = Effect(
    name="hardening",
    physics="A force that grows with the cube of the indentation, k3 x^3",
    parameters=(Parameter(CUBIC, "N/m^3", default=0.0, lower=-1e12, upper=1e12),),
    force=CUBIC * TIP_POSITION**3,
    assumptions="The same in compression and tension",
    reference="Duffing's oscillator; Fung (1993), section 7.5, expanded to third order",
)
