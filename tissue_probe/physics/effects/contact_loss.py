"""Loss of contact: the tissue can push, but not pull."""

import sympy as sp

from tissue_probe.physics.effects.effect import INDENTATION, TISSUE_FORCE, Effect, Switch

TOUCHING = sp.Symbol("touching", nonnegative=True)
PUSHING = sp.Symbol("pushing", nonnegative=True)
_SAYS = "the tip leaves the tissue"

_NEVER_PULLS = Effect(
    name="contact_loss",
    family="contact",
    physics="The tip leaves the tissue as soon as it would be pulled back",
    says=_SAYS,
    contact=TISSUE_FORCE * TOUCHING * PUSHING,
    switches=(
        Switch(TOUCHING, INDENTATION, -INDENTATION),
        Switch(PUSHING, TISSUE_FORCE, -TISSUE_FORCE),
    ),
)
CONTACT_LOSS = Effect(
    name="contact_loss",
    family="contact",
    physics="The tip leaves the tissue where it comes back to the free surface",
    says=_SAYS,
    contact=TISSUE_FORCE * TOUCHING,
    switches=(Switch(TOUCHING, INDENTATION, -INDENTATION),),
    forms=(_NEVER_PULLS,),
    assumptions="The surface is back at once; only visible where the tip reaches it",
    reference="Johnson, Contact Mechanics (1985), section 4.1; Brogliato, Nonsmooth Mechanics "
    "(2016), chapter 2",
)
