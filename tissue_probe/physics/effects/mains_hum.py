"""The mains' frequency in the force channel."""

import sympy as sp

from tissue_probe.physics.effects.effect import FORCE, TIME, Effect, Parameter
from tissue_probe.physics.extent import Extent

SINE, COSINE = sp.symbols("hum_sine hum_cosine", real=True)
HUM_FREQUENCY = sp.Symbol("hum_frequency", positive=True)
_ANGLE = 2 * sp.pi * HUM_FREQUENCY * TIME


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose the mains' frequencies."""
    return [{"hum_frequency": 50.0}, {"hum_frequency": 60.0}]


MAINS_HUM = Effect(
    name="mains_hum",
    family="mains hum",
    physics="A sine at the mains' frequency is added to the force",
    says="a hum at {hum_frequency:Hz}",
    parameters=(
        Parameter(SINE, "N", default=0.01, lower=-1e2, upper=1e2),
        Parameter(COSINE, "N", default=0.01, lower=-1e2, upper=1e2),
        Parameter(HUM_FREQUENCY, "Hz", default=50.0, lower=48.5, upper=61.5),
    ),
    output=FORCE + SINE * sp.sin(_ANGLE) + COSINE * sp.cos(_ANGLE),
    strengths=2,
    of_run=("hum_sine", "hum_cosine"),
    starts=starts,
    absolute=True,
    assumptions="The fundamental only, its amplitude constant",
    reference="Horowitz and Hill, The Art of Electronics (2015), section 8.13",
)
