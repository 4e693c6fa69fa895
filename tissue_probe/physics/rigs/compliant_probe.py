"""The paper's probe: a tip on a load cell that yields, driven by a coil of known displacement.

    m x'' = k0 (u - x) + beta0 (u' - x') - k x - beta x' - effects   (paper, eq. 1)
    F = k0 (u - x)                                                   (paper, eq. 2)

(J. Gafford, "Real-Time Parameter Estimation of Biological Tissue Using Kalman Filtering", fig. 1.)
Eq. 1 is printed without its dots; F is positive in compression, the opposite of eq. 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import TYPE_CHECKING

from tissue_probe import quantities
from tissue_probe.physics.entry import Entry
from tissue_probe.physics.rigs.constants import TIP_MASS, TOUCH, Constant
from tissue_probe.physics.rigs.rig import Live, Rig

if TYPE_CHECKING:
    import sympy as sp

    from tissue_probe.physics.effects.effect import Effect
    from tissue_probe.physics.model import Model
    from tissue_probe.physics.tissues import Tissue


def _equations(effects: Sequence[Effect], tissue: Tissue, zero: sp.Expr) -> Model:
    import sympy as sp

    from tissue_probe.physics.effects.effect import (
        FORCE,
        POSITION,
        POSITION_RATE,
        TIP_VELOCITY,
    )
    from tissue_probe.physics.rigs.composing import (
        CELL_DAMPING,
        CELL_STIFFNESS,
        MASS,
        TIP_POSITION,
        Pressed,
        composed,
        stretched,
        through,
    )

    x, v = TIP_POSITION, TIP_VELOCITY
    m, k0, beta0 = MASS, CELL_STIFFNESS, CELL_DAMPING
    u, du = reduce(through, effects, (POSITION, POSITION_RATE))
    stretch = u - zero - x
    load = k0 * sp.prod(e.cell for e in effects) * stretched(effects, stretch)
    grip = beta0 * (du - v) * sp.prod(e.engaged for e in effects)
    pressed = Pressed(effects, tissue, x, v)
    net = load + grip - pressed.force - pressed.drag
    return composed(
        pressed,
        constants=(m, k0, beta0),
        states=pressed.tip(net, m, start=POSITION - zero - FORCE / k0),
        load=load,
        net=net,
        stretch=stretch,
        # The coil feels the parts that it moves: none, while play is between it and the load cell.
        reaction=(load + grip) * sp.diff(du, POSITION_RATE),
    )


COMPLIANT_PROBE = Rig(
    name="compliant_probe",
    summary="Tip on a load cell that yields, driven by a coil of known displacement",
    whose="for a coil that moves the tip through a load cell that gives way (this suite's probe)",
    equations=_equations,
    input=quantities.POSITION,
    # Mass, stiffness and damping are known to 1, 1.5 and 20 %.
    constants=(
        Constant(TIP_MASS, 0.04, 0.0004),
        Constant(
            Entry("load_cell_stiffness", "N/m", default=9700.0, lower=1.0, upper=1e8), 9700.0, 145.5
        ),
        Constant(Entry("load_cell_damping", "N s/m", default=0.8, lower=0.0, upper=1e4), 0.8, 0.16),
        TOUCH,
    ),
    flicker_noise=1e-3,
    load_cell_yields=True,
    live=Live.models,
    drawing="""\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 220 60" width="220" height="60" \
fill="none" stroke="currentColor" font-family="sans-serif" font-size="11">
<path d="M4 30h24m-5-4 5 4-5 4"/><text x="8" y="20" fill="currentColor" stroke="none">u</text>
<rect x="32" y="16" width="36" height="28"/>
<path d="M68 30h6l4-6 6 12 6-12 6 12 6-12 4 6h6"/>
<text x="84" y="52" fill="currentColor" stroke="none">F</text>
<rect x="112" y="20" width="20" height="20"/>
<path d="M132 30h6l4-6 6 12 6-12 6 12 4-6h20M184 8v44m0-40 8-8m-8 20 8-8m-8 20 8-8m-8 20 8-8"/>
</svg>""",
)
