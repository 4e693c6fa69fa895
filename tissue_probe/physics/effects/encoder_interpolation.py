"""The encoder's error within each period of its grating."""

import sympy as sp

from tissue_probe.physics.effects.effect import POSITION, Effect, Parameter
from tissue_probe.physics.extent import Extent

SINE, COSINE = sp.symbols("interpolation_sine interpolation_cosine", real=True)
PERIOD = sp.Symbol("grating_period", positive=True)


def _error(position: sp.Expr) -> sp.Expr:
    angle = 2 * sp.pi * position / PERIOD
    return SINE * sp.sin(angle) + COSINE * sp.cos(angle)


def _slope(position: sp.Expr) -> sp.Expr:
    angle = 2 * sp.pi * position / PERIOD
    return 2 * sp.pi / PERIOD * (SINE * sp.cos(angle) - COSINE * sp.sin(angle))


def _improved(position: sp.Expr) -> sp.Expr:
    """Take a step of Halley's towards the position whose error leads to the one that was read."""
    off, slope = position + _error(position) - POSITION, 1 + _slope(position)
    curvature = -((2 * sp.pi / PERIOD) ** 2) * _error(position)
    return position - 2 * off * slope / (2 * slope**2 - off * curvature)


# The error is periodic in the true position, which follows from the measured one as the eccentric
# anomaly from the mean one (Kepler's equation).
_STEEPEST = (2 * sp.pi / PERIOD) ** 2 * (SINE**2 + COSINE**2)
_TRUE = _improved(POSITION - _error(POSITION) / sp.sqrt(1 + 2 * _slope(POSITION) + _STEEPEST))


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose the periods of common gratings."""
    periods = (4e-6, 8e-6, 10e-6, 16e-6, 20e-6, 25e-6, 32e-6, 40e-6, 50e-6, 80e-6, 100e-6, 200e-6)
    return [{"grating_period": period} for period in periods]


ENCODER_INTERPOLATION = Effect(
    name="encoder_interpolation",
    family="encoder",
    physics="The position errs periodically with the encoder's grating",
    says="the position errs with a period of {grating_period:m}",
    parameters=(
        Parameter(SINE, "m", default=5e-7, lower=-2e-5, upper=2e-5),
        Parameter(COSINE, "m", default=5e-7, lower=-2e-5, upper=2e-5),
        Parameter(PERIOD, "m", default=2e-5, lower=2e-6, upper=1e-3),
    ),
    position=_TRUE,
    strengths=2,
    starts=starts,
    excludes=("encoder_quantization",),
    assumptions="First harmonic only; smaller than a sixth of the period",
    reference="Heydemann, Applied Optics 20 (1981), 3382",
)
