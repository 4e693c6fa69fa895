"""The tissue's stiffness changes gradually: at a constant rate, or towards a value that it nears.

dk s((t - t0) / T): s grows from 0 to 1 in a straight line, or as 1 - exp(-3 (t - t0) / T), which
has come 95 % of the way after T. A ramp that is short is a step with a rise time.
"""

from __future__ import annotations

import sympy as sp

from tissue_probe.physics.effects.effect import (
    ELASTIC_DEPTH,
    TIME,
    Effect,
    Extent,
    Parameter,
    Starts,
)

CHANGE = sp.Symbol("ramp_change", real=True)
BEGIN = sp.Symbol("ramp_begin", real=True)
LENGTH = sp.Symbol("ramp_duration", positive=True)
#: Time constants that a settling change lasts: 95 % are done then.
LASTING = 3


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose the whole record, its halves, and shorter pieces."""
    return [
        {"ramp_begin": extent.duration * begin, "ramp_duration": extent.duration * length}
        for length in (1.0, 0.5, 0.25)
        for begin in [i * length / 2 for i in range(int(2 / length) - 1)]
    ]


def few(extent: Extent) -> list[dict[str, float]]:
    """Propose some pieces: a search begins where that for a straight ramp ended, too."""
    return [
        {"ramp_begin": extent.duration * begin, "ramp_duration": 0.3 * extent.duration}
        for begin in (0.0, 0.2, 0.4, 0.6)
    ]


def _form(
    done: tuple[tuple[sp.Expr | int, sp.Basic | bool], ...],
    assumptions: str,
    begun: Starts,
    forms: tuple[Effect, ...] = (),
) -> Effect:
    return Effect(
        name="stiffness_ramp",
        family="time-varying",
        physics="The tissue's stiffness moves from one value to another, at a constant rate or "
        "more and more slowly",
        says="the stiffness changes by {ramp_change:N/m} within {ramp_duration:s}",
        parameters=(
            Parameter(CHANGE, "N/m", default=100.0, lower=-1e5, upper=1e5),
            Parameter(BEGIN, "s", default=0.0, lower=-1.0, upper=1e4),
            Parameter(LENGTH, "s", default=1.0, lower=5e-3, upper=1e4),
        ),
        force=CHANGE * ELASTIC_DEPTH * sp.Piecewise((0, TIME < BEGIN), *done),
        of_run=("ramp_begin", "ramp_duration"),
        starts=begun,
        forms=forms,
        simpler=("stiffness_step",),
        limit=str(LENGTH),
        excludes=("stiffness_step",),
        assumptions=f"{assumptions}, of all that is elastic alike; the damping stays",
        reference="Ljung, System Identification (1999), section 11.2, on time-varying systems",
    )


_SETTLES = _form(
    ((1 - sp.exp(-LASTING * (TIME - BEGIN) / LENGTH), True),), "One change with one time", few
)
STIFFNESS_RAMP = _form(
    ((1, TIME > BEGIN + LENGTH), ((TIME - BEGIN) / LENGTH, True)),
    "One ramp",
    starts,
    (_SETTLES,),
)
