"""A tip that follows a known displacement exactly: a stiff load cell, an AFM, a robot's arm.

F = m u'' + k u + beta u' + effects
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from typing import TYPE_CHECKING

from tissue_probe import quantities
from tissue_probe.physics.rigs.constants import CONTACT_POSITION, TIP_MASS, Constant
from tissue_probe.physics.rigs.rig import Live, Rig

if TYPE_CHECKING:
    import sympy as sp

    from tissue_probe.physics.effects.effect import Effect
    from tissue_probe.physics.model import Model
    from tissue_probe.physics.tissues import Tissue


def _equations(effects: Sequence[Effect], tissue: Tissue, zero: sp.Expr) -> Model:
    from tissue_probe.physics.effects.effect import (
        POSITION,
        POSITION_ACCELERATION,
        POSITION_RATE,
    )
    from tissue_probe.physics.rigs.composing import MASS, Pressed, composed, through

    u, du = reduce(through, effects, (POSITION, POSITION_RATE))
    pressed = Pressed(effects, tissue, u - zero, du)
    load = (MASS + pressed.inertia) * POSITION_ACCELERATION + pressed.force + pressed.drag
    # The coil leads the tip against any force: friction never holds it, and turns as it turns.
    return composed(pressed, constants=(MASS,), states=(), load=load)


RIGID_PROBE = Rig(
    name="rigid_probe",
    summary="Tip that follows a known displacement exactly, its force measured",
    whose="for a robot, a stage or a testing machine that moves the tip",
    equations=_equations,
    input=quantities.POSITION,
    # The mass between load cell and tissue is not known.
    constants=(Constant(TIP_MASS, 0.0, math.inf), Constant(CONTACT_POSITION, 0.0, 0.0)),
    tip_is_position=True,
    live=Live.windows,
    drawing="""\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 220 60" width="220" height="60" \
fill="none" stroke="currentColor" font-family="sans-serif" font-size="11">
<path d="M4 30h24m-5-4 5 4-5 4"/><text x="8" y="20" fill="currentColor" stroke="none">u</text>
<rect x="32" y="16" width="36" height="28"/><path d="M68 27h44m0 6h-44"/>
<text x="84" y="52" fill="currentColor" stroke="none">F</text>
<rect x="112" y="20" width="20" height="20"/>
<path d="M132 30h6l4-6 6 12 6-12 6 12 4-6h20M184 8v44m0-40 8-8m-8 20 8-8m-8 20 8-8m-8 20 8-8"/>
</svg>""",
)
