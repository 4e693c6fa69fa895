"""An effect of one's own: a band of rubber that is stretched far, and flows.

Its result on a measured elastomer: ``docs/measured_data.md``.
"""

import sympy as sp

from tissue_probe.physics.effects.effect import (
    INDENTATION,
    STIFFNESS,
    TIP_VELOCITY,
    Effect,
    Extent,
    Parameter,
    State,
)

STRAIN = sp.Symbol("strain_per_metre", positive=True)
FLOWING, RATE = sp.symbols("flowing_stiffness flow_rate", positive=True)
HELD = sp.Symbol("elastic_elongation", real=True)

# Of rubber under stretch s the force is that of k L / 3 (s - 1 / s^2), with s = 1 + x / L.
_STRAIN = STRAIN * sp.Max(INDENTATION, 0)
_LAW = INDENTATION * (1 + _STRAIN + _STRAIN**2 / 3) / (1 + _STRAIN) ** 2
_SLOPE = (1 + 2 * (1 + _STRAIN) ** -3) / 3


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose bands that are stretched by a half to five times their length, and slow flow."""
    return [
        {"strain_per_metre": strain / extent.depth, "flow_rate": flow / extent.duration}
        for strain in (0.5, 1.5, 5.0)
        for flow in (1.0, 10.0, 100.0)
    ]


RUBBER_BAND = Effect(
    name="rubber_band",
    family="softening",
    physics="Ideal rubber in tension; a part of it flows at a rate r, e' = law' x' - r e",
    parameters=(
        Parameter(STRAIN, "1/m", default=10.0, lower=0.0, upper=1e4),
        Parameter(FLOWING, "N/m", default=10.0, lower=0.0, upper=1e6),
        Parameter(RATE, "1/s", default=0.1, lower=1e-5, upper=1e3),
    ),
    force=STIFFNESS * (_LAW - INDENTATION) + FLOWING * HELD,
    states=(State(HELD, _SLOPE * TIP_VELOCITY - RATE * HELD, spread="branch"),),
    strengths=2,
    starts=starts,
    assumptions="Elongation counts as positive; one rate; the flowing part has the same law",
    reference="Treloar, The Physics of Rubber Elasticity (1975), eq. 5.12; Bergstrom and Boyce, "
    "J. Mech. Phys. Solids 46 (1998), 931",
)
