"""The force channel's scale is off."""

import sympy as sp

from tissue_probe.physics.effects.effect import FORCE, Effect, Parameter

GAIN_ERROR = sp.Symbol("gain_error", real=True)

FORCE_GAIN = Effect(
    name="force_gain",
    family="scale",
    physics="The force reads too high by a share, (1 + e) F",
    says="the force reads wrong by {gain_error:+.1%}",
    parameters=(Parameter(GAIN_ERROR, "1", default=0.05, lower=-0.6, upper=1.5),),
    output=(1 + GAIN_ERROR) * FORCE,
    assumptions="The stiffness that moves the tip is the load cell's nominal one",
    reference="Doebelin, Measurement Systems (2004), section 3.2, on sensitivity errors",
)
