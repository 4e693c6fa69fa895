"""Damping that changes with the speed: by a power of it, by its direction, or by its past.

Quadratic: c |v| v. By a power: c |v / v0|^(n - 1) v with v0 = 10 mm/s in a record of the usual size
(see ``effect_scale``). By the direction: c |v|, which adds to the damping on the way in and takes
from it on the way out. Thixotropic: c s v, where s is |v| after a first-order lag; without a lag it
is quadratic.
"""

from dataclasses import replace

import sympy as sp

from tissue_probe.physics.effects.effect import (
    TIP_VELOCITY,
    Effect,
    Parameter,
    Starts,
    State,
)
from tissue_probe.physics.extent import Extent

QUADRATIC = sp.Symbol("quadratic_damping", real=True)
ONE_WAY = sp.Symbol("damping_by_direction", real=True)
POWERED, EXPONENT = sp.symbols("damping_at_10_mm_s speed_exponent", real=True)
MEMORY = sp.Symbol("speed_memory", positive=True)
RECENT = sp.Symbol("recent_speed", real=True)
REFERENCE_SPEED = 1e-2
#: Below this speed [m/s] a power of it is straight: its slope at rest would be without bound.
ROUNDED = 1e-4
_RELATIVE = sp.sqrt(TIP_VELOCITY**2 + ROUNDED**2) / REFERENCE_SPEED
_QUADRATIC = Parameter(QUADRATIC, "N s^2/m^2", default=50.0, lower=-1e5, upper=1e5)


def exponents(extent: Extent) -> list[dict[str, float]]:
    """Propose a damping that falls with the speed, and ones that grow with it."""
    return [{"speed_exponent": exponent} for exponent in (0.5, 1.5, 2.5)]


def memories(extent: Extent) -> list[dict[str, float]]:
    """Propose times from a part of a period to a good part of the record."""
    shortest = 0.3 / extent.frequency
    return [{"speed_memory": shortest}] + [
        {"speed_memory": extent.duration * f} for f in (0.03, 0.1, 0.3)
    ]


def _form(
    parameters: tuple[Parameter, ...],
    force: sp.Expr,
    says: str,
    assumptions: str,
    starts: Starts | None = None,
    states: tuple[State, ...] = (),
    forms: tuple[Effect, ...] = (),
) -> Effect:
    effect = Effect(
        name="nonlinear_damping",
        family="damping",
        physics="The damping changes with the speed: with its size, its direction or its past",
        says=says,
        parameters=parameters,
        force=force,
        states=states,
        forms=forms,
        assumptions=assumptions,
        reference="Cross, J. Colloid Science 20 (1965), 417, on powers of the speed; Barnes, J. "
        "Non-Newtonian Fluid Mechanics 70 (1997), 1, on thixotropy",
    )
    return effect if starts is None else replace(effect, starts=starts)


_POWER = _form(
    (
        Parameter(POWERED, "N s/m", default=3.0, lower=-1e4, upper=1e4),
        Parameter(EXPONENT, "1", default=1.5, lower=0.2, upper=3.0),
    ),
    POWERED * _RELATIVE ** (EXPONENT - 1) * TIP_VELOCITY,
    "a part of the damping's force grows as speed^{speed_exponent:.2f}",
    "A power of the speed beside the linear damping; straight below 0.1 mm/s. This speed, and the "
    "10 mm/s of the name, are other ones in a record of another size, of which a note tells",
    exponents,
)
_DIRECTED = _form(
    (Parameter(ONE_WAY, "N s/m", default=3.0, lower=-1e4, upper=1e4),),
    ONE_WAY * sp.Abs(TIP_VELOCITY),
    "the damping is {damping_by_direction:N s/m} more on the way in, and less on the way out",
    "Linear in the speed in either direction",
)
_THIXOTROPIC = _form(
    (_QUADRATIC, Parameter(MEMORY, "s", default=0.1, lower=1e-3, upper=1e3)),
    QUADRATIC * RECENT * TIP_VELOCITY,
    "the damping follows the speed of the last {speed_memory:s}",
    "The damping follows the mean speed of the recent past, by one time",
    memories,
    (State(RECENT, (sp.Abs(TIP_VELOCITY) - RECENT) / MEMORY, spread="speed"),),
)
NONLINEAR_DAMPING = _form(
    (_QUADRATIC,),
    QUADRATIC * sp.Abs(TIP_VELOCITY) * TIP_VELOCITY,
    "the damping grows with the speed, by {quadratic_damping:N s^2/m^2}",
    "Quadratic beside the linear damping, as a flow through wide pores",
    forms=(_POWER, _DIRECTED, _THIXOTROPIC),
)
