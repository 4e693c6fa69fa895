"""Hysteresis as a stack of elements that are elastic until each slips at a displacement of its own.

Element i is a spring in series with a slider: its displacement z_i follows the tip, and stays at
D_i while the tip drives it further. Its force is that of its slider times z_i / D_i. The slip
displacements are D, D / q, D / q^2 and so on, and the shares of the force go in proportion to
D_i^a: where a is large the last to slip bears most, and where it is 0 all bear the same. A stack is
also a spring less a stack of plays, which is what Prandtl and Ishlinskii are known for.

The state is z_i D / D_i, so that each reaches D. An element slips as smoothly as a form of
``bouc_wen_hysteresis`` of exponent 3: each stands for all that slips within a factor q.
"""

from itertools import product

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Parameter, State
from tissue_probe.physics.extent import Extent

SLIDING = sp.Symbol("stack_force", real=True)
LARGEST_SLIP, RATIO = sp.symbols("largest_slip slip_ratio", positive=True)
SLOPE = sp.Symbol("slip_slope", real=True)
#: So many elements follow a stack of twelve over a decade and a half to some per cent of its force.
COUNT, EXPONENT = 6, 3
DISPLACEMENTS = sp.symbols(f"stack_displacement_1:{COUNT + 1}", real=True)
_FINER = [RATIO**i for i in range(COUNT)]
_SHARES = [RATIO ** (-SLOPE * i) for i in range(COUNT)]


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose largest slips up to the indentation, of elements that slip near or far apart."""
    return [
        {str(LARGEST_SLIP): extent.indentation * f, str(RATIO): apart}
        for f, apart in product((0.1, 0.3, 0.9), (1.5, 2.0))
    ]


def _slipping(displacement: sp.Expr, finer: sp.Expr) -> sp.Expr:
    """Return how fast an element's state moves: with the tip until it slips."""
    driven = (1 + sp.sign(TIP_VELOCITY) * sp.sign(displacement)) / 2
    return TIP_VELOCITY * finer * (1 - sp.Abs(displacement / LARGEST_SLIP) ** EXPONENT * driven)


PRANDTL_ISHLINSKII = Effect(
    name="prandtl_ishlinskii",
    family="friction",
    physics="Many springs that yield, each at a displacement of its own: loops at every amplitude",
    says="friction of {stack_force:N} whose parts yield one after the other, the last over "
    "{largest_slip:m}",
    parameters=(
        Parameter(SLIDING, "N", default=0.05, lower=0.0, upper=1e3),
        Parameter(LARGEST_SLIP, "m", default=3e-4, lower=1e-4, upper=1e-2),
        # The first of six slips within a hundredth of the last at the most: what yields sooner is
        # dry friction, and asks for very short steps.
        Parameter(RATIO, "1", default=2.0, lower=1.3, upper=2.5),
        # Where the first to slip bear most, the last ones show as a spring: D may be any.
        Parameter(SLOPE, "1", default=0.5, lower=-0.5, upper=3.0),
    ),
    drag=SLIDING
    * sum(share * z for share, z in zip(_SHARES, DISPLACEMENTS, strict=True))
    / sum(_SHARES)
    / LARGEST_SLIP,
    states=tuple(
        State(z, _slipping(z, finer), spread=str(LARGEST_SLIP))
        for z, finer in zip(DISPLACEMENTS, _FINER, strict=True)
    ),
    starts=starts,
    simpler=("coulomb_friction", "bouc_wen_hysteresis"),
    excludes=("coulomb_friction", "stribeck_friction", "bouc_wen_hysteresis"),
    assumptions="Rate-independent; loops close, and are the same at each mean displacement",
    reference="Prandtl, Z. angewandte Mathematik und Mechanik 8 (1928), 85; Iwan, J. Applied "
    "Mechanics 33 (1966), 893; Kuhnen, European J. Control 9 (2003), 407, on stacks; Segalman, J. "
    "Applied Mechanics 72 (2005), 752, on shares by a power of the slip",
)
