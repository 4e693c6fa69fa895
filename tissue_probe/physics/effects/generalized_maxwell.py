"""Stress relaxation with two time constants."""

from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.dynamic_stiffness import handed_over, of_branch
from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Extent, Parameter, State

K1, K2 = sp.symbols("relaxing_stiffness_1 relaxing_stiffness_2", real=True)
R1, R2 = sp.symbols("relaxation_rate_1 relaxation_rate_2", positive=True)
E1, E2 = sp.symbols("branch_compression_1 branch_compression_2", real=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose pairs of rates a decade apart and more, from slow to the tip's own."""
    rates = [0.5 / extent.duration * 6.0**i for i in range(5)]
    return [
        {"relaxation_rate_1": slow, "relaxation_rate_2": fast}
        for i, slow in enumerate(rates)
        for fast in rates[i + 1 :]
    ]


def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose other rates, and most or half of the tissue's dynamic stiffness for the branches.

    At one frequency tissue and branches are alike, and lie along a valley too long for a search.
    """
    known = sum(
        found[f"relaxing_stiffness_{i}"]
        * of_branch(extent.frequency, found[f"relaxation_rate_{i}"])
        for i in (1, 2)
    )
    proposed = []
    for slow in (extent.frequency * f for f in (0.03, 0.1, 0.3)):
        unit = of_branch(extent.frequency, slow) + of_branch(extent.frequency, 10.0 * slow)
        for share in (0.5, 0.95):
            stiffness, rest = handed_over(extent.frequency, found, known, unit, share)
            proposed.append(
                {
                    "relaxing_stiffness_1": stiffness,
                    "relaxing_stiffness_2": stiffness,
                    "relaxation_rate_1": slow,
                    "relaxation_rate_2": 10.0 * slow,
                    **rest,
                }
            )
    return proposed


GENERALIZED_MAXWELL = Effect(
    name="generalized_maxwell",
    family="relaxation",
    physics="Two springs, each in series with a damper, beside the tissue: two relaxation times",
    says="it relaxes within {relaxation_rate_1:period} and {relaxation_rate_2:period}",
    parameters=(
        Parameter(K1, "N/m", default=200.0, lower=0.0, upper=1e5),
        Parameter(K2, "N/m", default=200.0, lower=0.0, upper=1e5),
        Parameter(R1, "1/s", default=5.0, lower=1e-4, upper=2e3),
        Parameter(R2, "1/s", default=100.0, lower=1e-4, upper=2e3),
    ),
    # Each spring's compression e follows e' = x' - r e.
    force=K1 * E1 + K2 * E2,
    states=(
        State(E1, TIP_VELOCITY - R1 * E1, spread="branch"),
        State(E2, TIP_VELOCITY - R2 * E2, spread="branch"),
    ),
    strengths=2,
    starts=starts,
    near=near,
    simpler=("standard_linear_solid",),
    excludes=("springpot", "standard_linear_solid"),
    assumptions="Small strains; relaxation times a factor apart",
    reference="Wiechert (1893); Fung, Biomechanics (1993), section 2.11",
)
