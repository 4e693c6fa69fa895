"""An effect of one's own: drag of a fluid around the tip, which grows with the square of its speed.

Use it with ``--effects my_effect.py``; copy and change it for another.
"""

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Parameter

DRAG = sp.Symbol("drag_coefficient", real=True)

QUADRATIC_DRAG = Effect(
    name="quadratic_drag",
    family="friction",
    physics="A fluid resists the tip with the square of its speed, c |x'| x'",
    parameters=(Parameter(DRAG, "N s^2/m^2", default=5.0, lower=0.0, upper=1e4),),
    drag=DRAG * sp.Abs(TIP_VELOCITY) * TIP_VELOCITY,
    assumptions="Steady turbulent flow; no added mass",
    reference="Batchelor, An Introduction to Fluid Dynamics (1967), section 5.11",
)
