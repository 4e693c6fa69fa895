"""Dry friction that is larger at low speed."""

from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Parameter
from tissue_probe.physics.extent import Extent
from tissue_probe.physics.sticking import SHARPEST, sliding

COULOMB = sp.Symbol("stribeck_coulomb_force", real=True)
BREAKAWAY = sp.Symbol("breakaway_excess", real=True)
STRIBECK = sp.Symbol("stribeck_velocity", positive=True)
STRIBECK_TRANSITION_VELOCITY = sp.Symbol("stribeck_transition_velocity", positive=True)
#: Transition velocity [m/s] from which on, falling at such speeds, the friction never reaches its
#: breakaway force.
BLUNTEST = 1e-3
_CURVE = COULOMB + BREAKAWAY * sp.exp(-((TIP_VELOCITY / STRIBECK) ** 2))


def speeds(extent: Extent) -> list[dict[str, float]]:
    """Propose speeds up to a good part of the largest one."""
    return [{"stribeck_velocity": extent.speed * f} for f in (0.015, 0.05, 0.15, 0.4)]


def other_speeds(extent: Extent, values: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose a fall at other speeds."""
    return [{"stribeck_velocity": values["stribeck_velocity"] * f} for f in (0.25, 0.5, 2.0)]


def around(extent: Extent, values: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose a fall at other speeds, and from other forces: each stick is a bend of the valley."""
    return [
        {
            "stribeck_velocity": values["stribeck_velocity"] * f,
            "breakaway_excess": values["breakaway_excess"] * g,
        }
        for f in (0.25, 0.5, 0.7, 1.4, 2.0)
        for g in (0.7, 1.0, 1.4, 2.8)
    ]


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose speeds, and how sharply the friction turns with the direction."""
    falls = {max(each["stribeck_velocity"], BLUNTEST) for each in speeds(extent)}
    return [
        {"stribeck_velocity": fall, "stribeck_transition_velocity": turn}
        for fall in sorted(falls)
        for turn in (3e-4, BLUNTEST)
    ]


def near(extent: Extent, values: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose a sharper turn, and a fall at other speeds: where the turn is sharp, only these."""
    tried = other_speeds(extent, values)
    if values["stribeck_transition_velocity"] > SHARPEST:
        tried.append({"stribeck_velocity": values["stribeck_velocity"]})
    return [{**each, "stribeck_transition_velocity": SHARPEST} for each in tried]


_FORCES = (
    Parameter(COULOMB, "N", default=0.03, lower=0.0, upper=1e3),
    Parameter(BREAKAWAY, "N", default=0.03, lower=0.0, upper=1e3),
)
_FORWARD, _BACK = sliding("stribeck", COULOMB + BREAKAWAY)
_SAYS = "dry friction of {stribeck_coulomb_force:N}, {breakaway_excess:N} more where it breaks away"

_STICKS = Effect(
    name="stribeck_friction",
    family="friction",
    physics="Dry friction that falls from breakaway to Coulomb level; the tip sticks as it turns",
    says=_SAYS,
    parameters=(*_FORCES, Parameter(STRIBECK, "m/s", default=1e-2, lower=1e-4, upper=1.0)),
    drag=_CURVE * (_FORWARD.symbol - _BACK.symbol),
    moving=_FORWARD.symbol + _BACK.symbol,
    switches=(_FORWARD, _BACK),
    strengths=2,
    starts=speeds,
    near=around,
    simpler=("coulomb_friction",),
    limit="breakaway_excess",
)
STRIBECK_FRICTION = Effect(
    name="stribeck_friction",
    family="friction",
    physics="Dry friction that falls from breakaway to Coulomb level, (Fc + Fb e^-(v/vs)^2) sign v",
    says=_SAYS,
    parameters=(
        *_FORCES,
        Parameter(STRIBECK, "m/s", default=1e-2, lower=BLUNTEST, upper=1.0),
        Parameter(
            STRIBECK_TRANSITION_VELOCITY, "m/s", default=BLUNTEST, lower=SHARPEST, upper=BLUNTEST
        ),
    ),
    drag=_CURVE * sp.tanh(TIP_VELOCITY / STRIBECK_TRANSITION_VELOCITY),
    strengths=2,
    starts=starts,
    near=near,
    forms=(_STICKS,),
    simpler=("coulomb_friction",),
    limit="breakaway_excess",
    excludes=("coulomb_friction", "bouc_wen_hysteresis", "prandtl_ishlinskii"),
    assumptions="Creeps below the transition velocity instead of sticking, or sticks at once",
    reference="Stribeck (1902); Armstrong-Helouvry et al., Automatica 30 (1994), 1083, eq. 1",
)
