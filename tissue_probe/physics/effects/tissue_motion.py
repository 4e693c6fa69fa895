"""The body moves under the probe: breathing, heartbeat."""

import sympy as sp

from tissue_probe.physics.effects.effect import TIME, Effect, Parameter
from tissue_probe.physics.extent import Extent

SINE, COSINE = sp.symbols("motion_sine motion_cosine", real=True)
MOTION_FREQUENCY = sp.Symbol("motion_frequency", positive=True)
_ANGLE = 2 * sp.pi * MOTION_FREQUENCY * TIME
_SURFACE = SINE * sp.sin(_ANGLE) + COSINE * sp.cos(_ANGLE)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose frequencies up to 3 Hz, so close that none lies between two of them."""
    step = max(0.15 / extent.duration, 0.03)
    return [{"motion_frequency": 0.12 + i * step} for i in range(int(2.9 / step))]


TISSUE_MOTION = Effect(
    name="tissue_motion",
    family="body motion",
    physics="The tissue's surface moves to and fro by itself, at one frequency",
    says="the tissue moves by itself at {motion_frequency:Hz}",
    parameters=(
        Parameter(SINE, "m", default=1e-4, lower=-0.05, upper=0.05),
        Parameter(COSINE, "m", default=1e-4, lower=-0.05, upper=0.05),
        Parameter(MOTION_FREQUENCY, "Hz", default=1.0, lower=0.05, upper=5.0),
    ),
    surface=(_SURFACE, _SURFACE.diff(TIME)),
    strengths=2,
    of_run=("motion_sine", "motion_cosine"),
    starts=starts,
    simpler=("force_bias", "force_drift"),
    assumptions="Sinusoidal; the probe's base stands still",
    reference="Ginhoux et al., IEEE Trans. Robotics 21 (2005), 67, section II",
)
