"""A tip on which a known force acts, its position measured: a voice coil, a shaker.

    m x'' = F - k x - beta x' - effects,    position = x + contact_position

F is the measured force, positive into the tissue as a load cell's in compression; effects on its
channel are undone first.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from tissue_probe import quantities
from tissue_probe.physics.rigs.constants import DRIVEN_MASS, TOUCH, Constant
from tissue_probe.physics.rigs.rig import Rig

if TYPE_CHECKING:
    import sympy as sp

    from tissue_probe.physics.effects.effect import Effect
    from tissue_probe.physics.model import Model
    from tissue_probe.physics.tissues import Tissue


def _equations(effects: Sequence[Effect], tissue: Tissue, zero: sp.Expr) -> Model:
    from tissue_probe.physics.effects.effect import POSITION, TIP_VELOCITY
    from tissue_probe.physics.rigs.composing import (
        MASS,
        TIP_POSITION,
        Pressed,
        composed,
        driven_by_force,
        pushed,
    )

    x, v = TIP_POSITION, TIP_VELOCITY
    pressed = Pressed(effects, tissue, x, v)
    push = pushed(effects)
    net = push - pressed.force - pressed.drag
    states = pressed.tip(net, MASS, start=POSITION - zero)
    model = composed(pressed, constants=(MASS,), states=states, load=push, net=net)
    return driven_by_force(model, position=x + zero)


FORCE_DRIVEN = Rig(
    name="force_driven",
    summary="Tip on which a known force acts, its position measured",
    whose="where a known force drives the tip, as of a voice coil or shaker",
    equations=_equations,
    input=quantities.FORCE,
    # A force moves an armature of its own, whose mass is not known.
    constants=(Constant(DRIVEN_MASS, 0.04, math.inf), TOUCH),
    drawing="""\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 220 60" width="220" height="60" \
fill="none" stroke="currentColor" font-family="sans-serif" font-size="11">
<path stroke-width="3" d="M72 30h36m-9-6 9 6-9 6"/>
<text x="84" y="20" fill="currentColor" stroke="none">F</text>
<rect x="112" y="20" width="20" height="20"/><path d="M122 44v6h14m-4-3 4 3-4 3"/>
<text x="140" y="54" fill="currentColor" stroke="none">u</text>
<path d="M132 30h6l4-6 6 12 6-12 6 12 4-6h20M184 8v44m0-40 8-8m-8 20 8-8m-8 20 8-8m-8 20 8-8"/>
</svg>""",
)
