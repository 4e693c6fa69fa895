"""Stress relaxation with two time constants."""

import sympy as sp

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


GENERALIZED_MAXWELL = Effect(
    name="generalized_maxwell",
    family="relaxation",
    physics="Two springs, each in series with a damper, beside the tissue: two relaxation times",
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
    simpler=("standard_linear_solid",),
    assumptions="Small strains; relaxation times a factor apart",
    reference="Wiechert (1893); Fung, Biomechanics (1993), section 2.11",
)
