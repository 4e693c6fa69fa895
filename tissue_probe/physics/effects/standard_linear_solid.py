"""Stress relaxation with one time constant: part of the stiffness yields."""

from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.dynamic_stiffness import hand_over, of_branch
from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Parameter, State
from tissue_probe.physics.extent import SLOWEST_RELAXATION, Extent

RELAXING_STIFFNESS = sp.Symbol("relaxing_stiffness", real=True)
RATE = sp.Symbol("relaxation_rate", positive=True)
COMPRESSION = sp.Symbol("branch_compression", real=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose rates three a decade, from those seen in the whole record to the tip's own."""
    slowest = SLOWEST_RELAXATION / extent.duration
    return [{"relaxation_rate": slowest * 10 ** (i / 3)} for i in range(12)]


def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose other rates, and most or half of the tissue's dynamic stiffness for the branch.

    At one frequency tissue and branch are alike, and lie along a valley too long for a search.
    """
    known = found["relaxing_stiffness"] * of_branch(extent.frequency, found["relaxation_rate"])
    proposed = []
    for rate in (extent.frequency * f for f in (0.1, 0.3, 1.0, 3.0)):
        unit = of_branch(extent.frequency, rate)
        for share in (0.5, 0.95):
            stiffness, rest = hand_over(extent.frequency, found, known, unit, share)
            proposed.append({"relaxing_stiffness": stiffness, "relaxation_rate": rate, **rest})
    return proposed


STANDARD_LINEAR_SOLID = Effect(
    name="standard_linear_solid",
    family="relaxation",
    physics="A spring k1 in series with a damper k1 / r beside the tissue: it yields at rate r",
    says="it relaxes within {relaxation_rate:period}, by {relaxing_stiffness:N/m}",
    parameters=(
        Parameter(RELAXING_STIFFNESS, "N/m", default=300.0, lower=0.0, upper=1e5),
        Parameter(RATE, "1/s", default=50.0, lower=1e-4, upper=2e3),
    ),
    # The spring's compression e follows e' = x' - r e; at rest for long, the damper has taken all.
    force=RELAXING_STIFFNESS * COMPRESSION,
    states=(State(COMPRESSION, TIP_VELOCITY - RATE * COMPRESSION, spread="branch"),),
    starts=starts,
    near=near,
    excludes=("springpot", "generalized_maxwell", "quasi_linear_relaxation"),
    assumptions="Small strains; one relaxation time",
    reference="Fung, Biomechanics: Mechanical Properties of Living Tissues (1993), section 2.11",
)
