"""Stiffening with the cube of the indentation."""

import sympy as sp

from tissue_probe.physics.effects.effect import INDENTATION, Effect, Parameter

CUBIC = sp.Symbol("cubic_stiffness", real=True)

CUBIC_STIFFENING = Effect(
    name="cubic_stiffening",
    family="stiffening",
    physics="A force that grows with the cube of the indentation, k3 x^3",
    says="the force grows with the cube of the depth, by {cubic_stiffness:N/m^3}",
    parameters=(Parameter(CUBIC, "N/m^3", default=1e8, lower=0.0, upper=1e12),),
    force=CUBIC * INDENTATION**3,
    excludes=("exponential_stiffening", "hertz_contact", "hunt_crossley", "saturating_spring"),
    assumptions="The same in compression and tension",
    reference="Duffing's oscillator; Fung (1993), section 7.5, expanded to third order",
)
