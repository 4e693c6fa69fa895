"""Stress relaxation: part of the stiffness yields with time."""

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Parameter

STIFFNESS = sp.Symbol("relaxing_stiffness", real=True)
RATE = sp.Symbol("relaxation_rate", positive=True)
BRANCH = sp.Symbol("branch_extension", real=True)

RELAXATION = Effect(
    name="relaxation",
    physics="A spring k1 in series with a damper k1 / r beside the tissue (standard linear solid)",
    parameters=(
        Parameter(STIFFNESS, "N/m", default=0.0, lower=0.0, upper=1e5),
        Parameter(RATE, "1/s", default=50.0, lower=1e-2, upper=1e4),
    ),
    # The spring's extension y follows y' = x' - r y.
    force=STIFFNESS * BRANCH,
    states=(BRANCH,),
    motion=(TIP_VELOCITY - RATE * BRANCH,),
    assumptions="Small strains; one relaxation time",
    reference="Fung, Biomechanics: Mechanical Properties of Living Tissues (1993), section 2.11",
)
