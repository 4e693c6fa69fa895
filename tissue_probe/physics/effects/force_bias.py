"""The force channel's zero is off."""

import sympy as sp

from tissue_probe.physics.effects.effect import FORCE, Effect, Parameter

FORCE_ZERO_ERROR = sp.Symbol("force_bias", real=True)

FORCE_BIAS = Effect(
    name="force_bias",
    family="offset",
    physics="A constant is added to the force",
    says="the force's zero is off by {force_bias:N}",
    parameters=(Parameter(FORCE_ZERO_ERROR, "N", default=0.02, lower=-1e3, upper=1e3),),
    output=FORCE + FORCE_ZERO_ERROR,
    zero="force_bias",
    assumptions="Constant over the record",
    reference="Doebelin, Measurement Systems (2004), section 3.2, on zero errors",
)
