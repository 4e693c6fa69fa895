"""The encoder's steps are coarse."""

import sympy as sp

from tissue_probe.physics.effects.effect import Effect, Parameter
from tissue_probe.physics.extent import Extent
from tissue_probe.physics.rounding import COARSE_STEP

STEP = sp.Symbol("encoder_step", positive=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose the step seen in the positions, where it is coarse."""
    return [{"encoder_step": extent.step}] if extent.step > COARSE_STEP else []


ENCODER_QUANTIZATION = Effect(
    name="encoder_quantization",
    family="encoder",
    physics="The position is rounded to coarse steps; the true one is smooth between them",
    says="the position is rounded to {encoder_step:m}",
    parameters=(Parameter(STEP, "m", default=5e-6, lower=0.0, upper=1e-3),),
    rounded=STEP,
    starts=starts,
    excludes=("encoder_interpolation",),
    assumptions="The motion is smooth: its smoothest course within the steps is the true one",
    reference="Widrow and Kollar, Quantization Noise (2008), chapter 5",
)
