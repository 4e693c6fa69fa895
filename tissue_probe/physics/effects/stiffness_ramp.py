"""The tissue's stiffness changes gradually."""

import sympy as sp

from tissue_probe.physics.effects.effect import ELASTIC_DEPTH, TIME, Effect, Parameter
from tissue_probe.physics.extent import Extent

RAMP_CHANGE = sp.Symbol("ramp_change", real=True)
BEGIN = sp.Symbol("ramp_begin", real=True)
RAMP_DURATION = sp.Symbol("ramp_duration", positive=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose the whole record, its halves, and shorter pieces."""
    return [
        {"ramp_begin": extent.duration * begin, "ramp_duration": extent.duration * length}
        for length in (1.0, 0.5, 0.25)
        for begin in [i * length / 2 for i in range(int(2 / length) - 1)]
    ]


STIFFNESS_RAMP = Effect(
    name="stiffness_ramp",
    family="time-varying",
    physics="The tissue's stiffness moves from one value to another at a constant rate",
    says="the stiffness changes by {ramp_change:N/m} within {ramp_duration:s}",
    parameters=(
        Parameter(RAMP_CHANGE, "N/m", default=100.0, lower=-1e5, upper=1e5),
        Parameter(BEGIN, "s", default=0.0, lower=-1.0, upper=1e4),
        Parameter(RAMP_DURATION, "s", default=1.0, lower=5e-3, upper=1e4),
    ),
    force=RAMP_CHANGE
    * ELASTIC_DEPTH
    * sp.Piecewise(
        (0, TIME < BEGIN), (1, TIME > BEGIN + RAMP_DURATION), ((TIME - BEGIN) / RAMP_DURATION, True)
    ),
    of_run=("ramp_begin", "ramp_duration"),
    starts=starts,
    simpler=("stiffness_step",),
    limit=str(RAMP_DURATION),
    excludes=("stiffness_step",),
    assumptions="One ramp, of all that is elastic alike; the damping stays",
    reference="Ljung, System Identification (1999), section 11.2, on time-varying systems",
)
