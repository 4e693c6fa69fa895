"""Contact of a round tip: a force that grows with a power of the indentation."""

import sympy as sp

from tissue_probe.physics.effects.effect import (
    INDENTATION,
    STIFFNESS,
    TISSUE_FORCE,
    Effect,
    Extent,
    Parameter,
    Switch,
)

EXPONENT = sp.Symbol("contact_exponent", positive=True)
TOUCHING, PUSHING = sp.symbols("touching pushing", nonnegative=True)
REFERENCE_DEPTH = 1e-3
_DEPTH = sp.Max(INDENTATION, sp.Float(1e-9)) / REFERENCE_DEPTH


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose the exponents of a flat punch to a cone."""
    return [{"contact_exponent": exponent} for exponent in (1.2, 1.5, 2.0, 2.6)]


def _form(lost: sp.Expr, switches: tuple[Switch, ...], forms: tuple[Effect, ...] = ()) -> Effect:
    return Effect(
        name="hertz_contact",
        family="stiffening",
        physics="The spring's force is k x0 (x / x0)^n in contact (x0 = 1 mm), and none out of it",
        parameters=(Parameter(EXPONENT, "1", default=1.5, lower=0.8, upper=3.5),),
        force=STIFFNESS * INDENTATION * (_DEPTH ** (EXPONENT - 1) - 1),
        contact=TISSUE_FORCE * lost,
        switches=switches,
        neutral=1.0,
        starts=starts,
        forms=forms,
        simpler=("contact_loss",),
        assumptions="Elastic half space; n is 3/2 for a sphere, 2 for a cone; the damping acts in "
        "contact",
        reference="Hertz (1881); Johnson, Contact Mechanics (1985), section 4.2; stiffness is the "
        "secant's at 1 mm",
    )


_TOUCHES = Switch(TOUCHING, INDENTATION, -INDENTATION)
_NEVER_PULLS = _form(TOUCHING * PUSHING, (_TOUCHES, Switch(PUSHING, TISSUE_FORCE, -TISSUE_FORCE)))
HERTZ_CONTACT = _form(TOUCHING, (_TOUCHES,), (_NEVER_PULLS,))
