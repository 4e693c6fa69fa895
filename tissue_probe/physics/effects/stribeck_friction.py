"""Dry friction that is larger at low speed."""

from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Extent, Parameter

COULOMB = sp.Symbol("stribeck_coulomb_force", real=True)
BREAKAWAY = sp.Symbol("breakaway_excess", real=True)
STRIBECK = sp.Symbol("stribeck_velocity", positive=True)
TRANSITION = sp.Symbol("stribeck_transition_velocity", positive=True)
#: Transition velocities [m/s] below which a turn is hardly told from a jump.
SHARP = (1e-5, 1e-4)
_CURVE = COULOMB + BREAKAWAY * sp.exp(-((TIP_VELOCITY / STRIBECK) ** 2))


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose speeds up to a good part of the largest one."""
    return [
        {"stribeck_velocity": extent.speed * f, "stribeck_transition_velocity": transition}
        for f in (0.015, 0.05, 0.15, 0.4)
        for transition in (3e-4, 3e-3)
    ]


def near(extent: Extent, values: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose a sharper turn, and a fall at other speeds: where the turn is sharp, only these."""
    sharp = values["stribeck_transition_velocity"] <= SHARP[-1]
    return [
        {"stribeck_velocity": values["stribeck_velocity"] * f, "stribeck_transition_velocity": each}
        for f in ((0.25, 0.5, 2.0) if sharp else (0.25, 0.5, 1.0, 2.0))
        for each in SHARP
    ]


STRIBECK_FRICTION = Effect(
    name="stribeck_friction",
    family="friction",
    physics="Dry friction that falls from breakaway to Coulomb level, (Fc + Fb e^-(v/vs)^2) sign v",
    parameters=(
        Parameter(COULOMB, "N", default=0.03, lower=0.0, upper=1e3),
        Parameter(BREAKAWAY, "N", default=0.03, lower=0.0, upper=1e3),
        Parameter(STRIBECK, "m/s", default=1e-2, lower=1e-4, upper=1.0),
        Parameter(TRANSITION, "m/s", default=1e-3, lower=1e-5, upper=2e-2),
    ),
    drag=_CURVE * sp.tanh(TIP_VELOCITY / TRANSITION),
    strengths=2,
    starts=starts,
    near=near,
    simpler=("coulomb_friction",),
    assumptions="Creeps below the transition velocity instead of sticking",
    reference="Stribeck (1902); Armstrong-Helouvry et al., Automatica 30 (1994), 1083, eq. 1",
)
