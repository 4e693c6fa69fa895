"""Damping that grows with the indentation."""

import sympy as sp

from tissue_probe.physics.effects.effect import (
    INDENTATION,
    TIP_VELOCITY,
    TISSUE_FORCE,
    Effect,
    Parameter,
    Switch,
)
from tissue_probe.physics.extent import Extent

DEPTH_DAMPING = sp.Symbol("depth_damping", real=True)
DEPTH_DAMPING_EXPONENT = sp.Symbol("depth_damping_exponent", positive=True)
TOUCHING = sp.Symbol("touching", nonnegative=True)
REFERENCE_DEPTH = 1e-3


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose the exponents of a line, a sphere and a cone."""
    return [{"depth_damping_exponent": exponent} for exponent in (1.0, 1.5)]


def _form(depth: sp.Expr, lost: bool, forms: tuple[Effect, ...] = ()) -> Effect:
    ratio = sp.Max(depth, sp.Float(1e-9)) / REFERENCE_DEPTH
    return Effect(
        name="hunt_crossley",
        family="stiffening",
        physics="A damping that grows with the indentation, b (x / x0)^n x' (x0 = 1 mm)",
        says="the damping grows as depth^{depth_damping_exponent:.2f}",
        parameters=(
            Parameter(DEPTH_DAMPING, "N s/m", default=3.0, lower=0.0, upper=1e3),
            Parameter(DEPTH_DAMPING_EXPONENT, "1", default=1.0, lower=0.5, upper=3.0),
        ),
        force=DEPTH_DAMPING * ratio**DEPTH_DAMPING_EXPONENT * TIP_VELOCITY,
        contact=TISSUE_FORCE * TOUCHING if lost else TISSUE_FORCE,
        switches=(Switch(TOUCHING, INDENTATION, -INDENTATION),) if lost else (),
        starts=starts,
        forms=forms,
        excludes=("cubic_stiffening", "exponential_stiffening", "hertz_contact"),
        assumptions="No plastic set; the spring stays linear",
        reference="Hunt and Crossley, J. Applied Mechanics 42 (1975), 440",
    )


HUNT_CROSSLEY = _form(
    INDENTATION, False, (_form(sp.Abs(INDENTATION), False), _form(INDENTATION, True))
)
