"""The force channel's zero moves, at a constant rate or more and more slowly."""

import sympy as sp

from tissue_probe.physics.effects.effect import FORCE, TIME, Effect, Parameter
from tissue_probe.physics.extent import Extent

DRIFT, BIAS = sp.symbols("force_drift drift_start", real=True)
SETTLING = sp.Symbol("drift_time", positive=True)
_PARAMETERS = (
    Parameter(DRIFT, "N/s", default=0.02, lower=-1e3, upper=1e3),
    Parameter(BIAS, "N", default=0.02, lower=-1e3, upper=1e3),
)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose times within the record: of much longer ones it shows a constant rate."""
    return [{"drift_time": extent.duration * f} for f in (0.05, 0.2, 0.6)]


_SAYS = "the force's zero moves by {force_drift:N/s}"

_SETTLES = Effect(
    name="force_drift",
    family="offset",
    physics="The force's zero moves towards another: a load cell that creeps, or warms up",
    says=_SAYS,
    parameters=(*_PARAMETERS, Parameter(SETTLING, "s", default=0.4, lower=0.02, upper=1e3)),
    output=FORCE + BIAS - DRIFT * SETTLING * (sp.exp(-TIME / SETTLING) - 1),
    strengths=2,
    of_run=("drift_start",),
    zero="drift_start",
    starts=starts,
    simpler=("force_bias",),
)
FORCE_DRIFT = Effect(
    name="force_drift",
    family="offset",
    physics="The force's zero moves, at a constant rate or towards another zero",
    says=_SAYS,
    parameters=_PARAMETERS,
    output=FORCE + BIAS + DRIFT * TIME,
    strengths=2,
    of_run=("drift_start",),
    zero="drift_start",
    forms=(_SETTLES,),
    simpler=("force_bias",),
    assumptions="Constant rate, or one time constant: a load cell's creep has several",
    reference="Doebelin, Measurement Systems (2004), section 3.2, on zero drift; OIML R 60 (2021) "
    "on creep",
)
