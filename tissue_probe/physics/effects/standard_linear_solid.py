"""Stress relaxation with one time constant: part of the stiffness yields."""

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Extent, Parameter, State

RELAXING_STIFFNESS = sp.Symbol("relaxing_stiffness", real=True)
RATE = sp.Symbol("relaxation_rate", positive=True)
COMPRESSION = sp.Symbol("branch_compression", real=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose rates three a decade, from those seen in the whole record to the tip's own."""
    slowest = 0.3 / extent.duration
    return [{"relaxation_rate": slowest * 10 ** (i / 3)} for i in range(12)]


STANDARD_LINEAR_SOLID = Effect(
    name="standard_linear_solid",
    family="relaxation",
    physics="A spring k1 in series with a damper k1 / r beside the tissue: it yields at rate r",
    parameters=(
        Parameter(RELAXING_STIFFNESS, "N/m", default=300.0, lower=0.0, upper=1e5),
        Parameter(RATE, "1/s", default=50.0, lower=1e-4, upper=2e3),
    ),
    # The spring's compression e follows e' = x' - r e; at rest for long, the damper has taken all.
    force=RELAXING_STIFFNESS * COMPRESSION,
    states=(State(COMPRESSION, TIP_VELOCITY - RATE * COMPRESSION, spread="branch"),),
    starts=starts,
    assumptions="Small strains; one relaxation time",
    reference="Fung, Biomechanics: Mechanical Properties of Living Tissues (1993), section 2.11",
)
