"""Damage by the largest depth: tissue is softer wherever it was pressed deeper before.

The spring's force F is (1 - d) times that of intact tissue. With m the largest indentation so far,
x the indentation now, s the damage of tissue that was pressed in without end, and D a depth:

- by Simo, d = s (1 - exp(-m / D)): at a first pressing the tissue softens, and afterwards it is a
  weaker spring of the same form;
- by Ogden and Roxburgh, d = s erf((m^2 - x^2) / D^2): a first pressing follows the intact law, and
  where it comes back the tissue is the softer the farther it is from the largest depth.

The state w is how far the tip is from the largest depth of the recording: it grows as the tip
withdraws, and none is left where the tip goes deeper than ever. Tissue that was pressed in before
has another largest depth from then, which belongs to the recording.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import sympy as sp

from tissue_probe.physics.effects.effect import (
    ELASTIC_DEPTH,
    INDENTATION,
    STIFFNESS,
    TIP_VELOCITY,
    Effect,
    Parameter,
    State,
    Switch,
)
from tissue_probe.physics.extent import Extent

Near = Callable[[Extent, Mapping[str, float]], list[dict[str, float]]]
DAMAGE = sp.Symbol("damage_share", real=True)
DAMAGE_DEPTH = sp.Symbol("damage_depth", positive=True)
#: How far the tip is from its largest depth, and whether it goes deeper than ever.
WITHDRAWN = sp.Symbol("withdrawn_from_largest", real=True)
DEEPER = sp.Symbol("deeper_than_ever", nonnegative=True)
BEFORE = sp.Symbol("largest_depth_before", nonnegative=True)
_LARGEST = sp.Max(INDENTATION + sp.Max(WITHDRAWN, 0), BEFORE)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose depths from a part of the travel to some times the deepest, of tissue pressed before.

    Or of tissue that was not: what is deeper than the recording does not show.
    """
    deepest = max(extent.depth, extent.indentation)
    return [
        {str(DAMAGE_DEPTH): f * deepest, str(BEFORE): before * deepest}
        for f in (0.3, 1.0, 3.0)
        for before in (0.0, 0.6, 1.0)
    ]


def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose other damages that leave the tissue as stiff as it was found where it is deepest.

    Once it was pressed in, little damage of weak tissue and much of stiff tissue are nearly alike:
    they lie along a valley too long and bent for a search.
    """
    deepest = max(extent.depth, extent.indentation)

    def left(share: float, depth: float) -> float:
        return 1.0 - share * (1.0 - math.exp(-deepest / depth))

    now = found["stiffness"] * left(found[str(DAMAGE)], found[str(DAMAGE_DEPTH)])
    return [
        {
            str(DAMAGE): share,
            str(DAMAGE_DEPTH): f * deepest,
            "stiffness": now / left(share, f * deepest),
        }
        for share in (0.3, 0.6, 0.9)
        for f in (0.4, 1.2, 4.0)
    ]


def _form(
    damage: sp.Expr,
    assumptions: str,
    others: Near | None = None,
    forms: tuple[Effect, ...] = (),
) -> Effect:
    return Effect(
        name="damage_by_depth",
        family="damage",
        physics="The tissue is softer wherever it was pressed deeper before (Mullins)",
        says="up to {damage_share:.2f} of the stiffness is lost by pressing some "
        "{damage_depth:m} deep",
        parameters=(
            Parameter(DAMAGE, "1", default=0.3, lower=0.0, upper=1.0),
            Parameter(DAMAGE_DEPTH, "m", default=1e-3, lower=1e-5, upper=0.1),
            Parameter(BEFORE, "m", default=0.0, lower=0.0, upper=0.1),
        ),
        force=-STIFFNESS * ELASTIC_DEPTH * DAMAGE * damage,
        states=(State(WITHDRAWN, -(1 - DEEPER) * TIP_VELOCITY, spread="counted"),),
        # Deeper than ever only while it goes deeper: at a turn it is at its largest depth, too.
        switches=(Switch(DEEPER, TIP_VELOCITY, sp.Max(WITHDRAWN, -TIP_VELOCITY), first=False),),
        starts=starts,
        near=others,
        of_run=(str(BEFORE),),
        forms=forms,
        assumptions=f"{assumptions}; nothing heals; the damping stays",
        reference="Mullins, Rubber Chemistry and Technology 42 (1969), 339; Simo, Computer Methods "
        "in Applied Mechanics and Engineering 60 (1987), 153, section 3; Ogden and Roxburgh, Proc. "
        "Royal Society A 455 (1999), 2861, eq. 3.17",
    )


_OGDEN = _form(
    sp.erf(sp.Max(_LARGEST**2 - INDENTATION**2, 0) / DAMAGE_DEPTH**2),
    "A first pressing follows the intact law; the damage by how far the energy of a straight "
    "spring is from its largest",
)
DAMAGE_BY_DEPTH = _form(
    1 - sp.exp(-_LARGEST / DAMAGE_DEPTH), "A weaker spring of the same form", near, (_OGDEN,)
)
