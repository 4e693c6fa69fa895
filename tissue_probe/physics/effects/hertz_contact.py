"""Contact of a round tip: a force that grows with a power of the indentation."""

from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.effects.effect import (
    INDENTATION,
    STIFFNESS,
    TISSUE_FORCE,
    Effect,
    Parameter,
    Switch,
)
from tissue_probe.physics.extent import Extent

CONTACT_EXPONENT = sp.Symbol("contact_exponent", positive=True)
TOUCHING, PUSHING = sp.symbols("touching pushing", nonnegative=True)
REFERENCE_DEPTH = 1e-3
EXPONENTS = (1.2, 1.5, 2.0, 2.6)
_DEPTH = sp.Max(INDENTATION, sp.Float(1e-9)) / REFERENCE_DEPTH


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose the exponents of a flat punch to a cone."""
    return [{"contact_exponent": exponent} for exponent in EXPONENTS]


def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose other exponents, with the force found where the tip is deepest, or its slope midway.

    Under a preload the stiffness, which is that at 1 mm, must change along with the exponent.
    """
    old, mean = found["contact_exponent"], extent.depth - extent.indentation
    proposed = []
    for new in EXPONENTS:
        deepest = (extent.depth / REFERENCE_DEPTH) ** (old - new) if extent.depth > 0.0 else 1.0
        proposed.append({"contact_exponent": new, "stiffness": found["stiffness"] * deepest})
        if mean > 0.0:
            midway = (mean / REFERENCE_DEPTH) ** (old - new) * old / new
            proposed.append({"contact_exponent": new, "stiffness": found["stiffness"] * midway})
    return proposed


def _form(lost: sp.Expr, switches: tuple[Switch, ...], forms: tuple[Effect, ...] = ()) -> Effect:
    return Effect(
        name="hertz_contact",
        family="stiffening",
        physics="The spring's force is k x0 (x / x0)^n in contact (x0 = 1 mm), and none out of it",
        says="the force grows as depth^{contact_exponent:.2f}",
        parameters=(Parameter(CONTACT_EXPONENT, "1", default=1.5, lower=1.0, upper=3.5),),
        force=STIFFNESS * INDENTATION * (_DEPTH ** (CONTACT_EXPONENT - 1) - 1),
        contact=TISSUE_FORCE * lost,
        switches=switches,
        neutral=1.0,
        starts=starts,
        near=near,
        forms=forms,
        simpler=("contact_loss",),
        limit=str(CONTACT_EXPONENT),
        excludes=(
            "cubic_stiffening",
            "exponential_stiffening",
            "hunt_crossley",
            "saturating_spring",
        ),
        assumptions="Elastic half space; n is 1 for a flat punch, 3/2 for a sphere, 2 for a cone; "
        "the damping acts in contact",
        reference="Hertz (1881); Johnson, Contact Mechanics (1985), section 4.2; stiffness is the "
        "secant's at 1 mm",
    )


_TOUCHES = Switch(TOUCHING, INDENTATION, -INDENTATION)
_NEVER_PULLS = _form(TOUCHING * PUSHING, (_TOUCHES, Switch(PUSHING, TISSUE_FORCE, -TISSUE_FORCE)))
HERTZ_CONTACT = _form(TOUCHING, (_TOUCHES,), (_NEVER_PULLS,))
