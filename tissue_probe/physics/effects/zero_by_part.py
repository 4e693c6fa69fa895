"""The force channel's zero differs between parts of a run: it was set anew between them."""

import sympy as sp

from tissue_probe.physics.effects.effect import FORCE, Effect, Parameter

PART_ZERO = sp.Symbol("zero_by_part", real=True)

ZERO_BY_PART = Effect(
    name="zero_by_part",
    family="offset",
    physics="A constant is added to the force, in each part of a run after the first another",
    says="the force's zero differs from part to part",
    parameters=(Parameter(PART_ZERO, "N", default=0.02, lower=-1e3, upper=1e3),),
    output=FORCE + PART_ZERO,
    of_part=("zero_by_part",),
    assumptions="Constant over each part; a gap in the times ends a part",
    reference="Doebelin, Measurement Systems (2004), section 3.2, on zero errors",
)
