"""The force channel's zero moves."""

import sympy as sp

from tissue_probe.physics.effects.effect import FORCE, TIME, Effect, Parameter

DRIFT, BIAS = sp.symbols("force_drift drift_start", real=True)

FORCE_DRIFT = Effect(
    name="force_drift",
    family="offset",
    physics="The force's zero moves at a constant rate",
    parameters=(
        Parameter(DRIFT, "N/s", default=0.02, lower=-1e3, upper=1e3),
        Parameter(BIAS, "N", default=0.02, lower=-1e3, upper=1e3),
    ),
    output=FORCE + BIAS + DRIFT * TIME,
    strengths=2,
    of_run=("drift_start",),
    simpler=("force_bias",),
    assumptions="Linear over the record: a part of a slow exponential",
    reference="Doebelin, Measurement Systems (2004), section 3.2, on zero drift",
)
