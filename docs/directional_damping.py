"""An effect of one's own: damping that differs with the direction, as a worn screw has it.

Its result on a measured drive: ``docs/measured_data.md``.
"""

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Parameter

DIFFERENCE = sp.Symbol("damping_difference", real=True)

DIRECTIONAL_DAMPING = Effect(
    name="directional_damping",
    family="friction",
    physics="Viscous friction is larger in one direction, c |x'|",
    parameters=(Parameter(DIFFERENCE, "N s/m", default=10.0, lower=-1e4, upper=1e4),),
    drag=DIFFERENCE * sp.Abs(TIP_VELOCITY),
    assumptions="beta + c forwards, beta - c backwards",
    reference="Janot, Gautier, Brunot, EMPS benchmark (2019), model with asymmetric friction",
)
