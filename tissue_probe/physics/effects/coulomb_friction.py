"""Dry friction on the tip."""

from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Parameter
from tissue_probe.physics.extent import Extent
from tissue_probe.physics.sticking import SHARPEST, sliding

FRICTION = sp.Symbol("coulomb_force", real=True)
TRANSITION_VELOCITY = sp.Symbol("transition_velocity", positive=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose how sharply the friction turns with the direction."""
    return [{"transition_velocity": velocity} for velocity in (3e-4, 1e-3, 5e-3)]


def near(extent: Extent, values: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose a sharper turn: among many frequencies a search ends at one that is too blunt."""
    return [{"transition_velocity": SHARPEST}]


_STRENGTH = Parameter(FRICTION, "N", default=0.03, lower=0.0, upper=1e3)
_FORWARD, _BACK = sliding("coulomb", FRICTION)
_SAYS = "dry friction of {coulomb_force:N}"

_STICKS = Effect(
    name="coulomb_friction",
    family="friction",
    physics="A force against the motion whatever the speed, Fc; the tip sticks where it turns",
    says=_SAYS,
    parameters=(_STRENGTH,),
    drag=FRICTION * (_FORWARD.symbol - _BACK.symbol),
    moving=_FORWARD.symbol + _BACK.symbol,
    switches=(_FORWARD, _BACK),
)
COULOMB_FRICTION = Effect(
    name="coulomb_friction",
    family="friction",
    physics="A force against the motion whatever the speed, Fc tanh(x' / vt)",
    says=_SAYS,
    parameters=(
        _STRENGTH,
        Parameter(TRANSITION_VELOCITY, "m/s", default=1e-3, lower=SHARPEST, upper=2e-2),
    ),
    drag=FRICTION * sp.tanh(TIP_VELOCITY / TRANSITION_VELOCITY),
    starts=starts,
    near=near,
    forms=(_STICKS,),
    excludes=("stribeck_friction", "bouc_wen_hysteresis", "prandtl_ishlinskii"),
    assumptions="Creeps below the transition velocity instead of sticking, or sticks at once",
    reference="Coulomb (1785); Olsson et al., European J. Control 4 (1998), 176, section 3",
)
