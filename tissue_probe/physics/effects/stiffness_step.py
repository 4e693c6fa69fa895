"""The tissue's stiffness changes at once."""

from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.effects.effect import (
    ELASTIC_DEPTH,
    TIME,
    Effect,
    Parameter,
    Switch,
)
from tissue_probe.physics.extent import Extent

STEP_CHANGE = sp.Symbol("step_change", real=True)
INSTANT = sp.Symbol("step_time", real=True)
AFTER = sp.Symbol("after_step", nonnegative=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose instants every twenty-fifth of the record."""
    return [{"step_time": extent.duration * i / 25} for i in range(1, 25)]


def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose instants about one that was found, closer than the tissue is pressed and left."""
    spacings = (extent.duration / 25 / 8, extent.duration / 25 / 64)
    return [{"step_time": found["step_time"] + i * s} for s in spacings for i in range(-7, 8) if i]


STIFFNESS_STEP = Effect(
    name="stiffness_step",
    family="time-varying",
    physics="The tissue's stiffness jumps at one instant",
    says="the stiffness changes by {step_change:N/m} at {step_time:s}",
    parameters=(
        Parameter(STEP_CHANGE, "N/m", default=100.0, lower=-1e5, upper=1e5),
        Parameter(INSTANT, "s", default=1.0, lower=0.0, upper=1e4),
    ),
    force=STEP_CHANGE * AFTER * ELASTIC_DEPTH,
    switches=(Switch(AFTER, sp.Integer(1), INSTANT - TIME, first=False),),
    of_run=("step_time",),
    starts=starts,
    near=near,
    excludes=("stiffness_ramp",),
    assumptions="One step, of all that is elastic alike; the damping stays",
    reference="Basseville and Nikiforov, Detection of Abrupt Changes (1993), section 2.1",
)
