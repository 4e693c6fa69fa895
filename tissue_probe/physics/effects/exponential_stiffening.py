"""Stiffening as Fung describes it: the slope grows in proportion to the force."""

import sympy as sp

from tissue_probe.physics.effects.effect import INDENTATION, Effect, Parameter
from tissue_probe.physics.extent import Extent

EXPONENTIAL_FORCE = sp.Symbol("exponential_force", real=True)
EXPONENTIAL_LENGTH = sp.Symbol("exponential_length", positive=True)
_DEPTH = INDENTATION / EXPONENTIAL_LENGTH


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose lengths from a fifth of the indentation to many times it."""
    return [{"exponential_length": extent.indentation * f} for f in (0.2, 0.4, 0.8, 1.6, 5.0, 15.0)]


def _form(shape: sp.Expr, assumptions: str, forms: tuple[Effect, ...] = ()) -> Effect:
    return Effect(
        name="exponential_stiffening",
        family="stiffening",
        physics="A force that grows exponentially with the indentation, a (e^(x/L) - 1 - x/L)",
        says="the force grows e-fold every {exponential_length:m}",
        parameters=(
            Parameter(EXPONENTIAL_FORCE, "N", default=0.05, lower=0.0, upper=1e3),
            Parameter(EXPONENTIAL_LENGTH, "m", default=1e-3, lower=5e-5, upper=0.1),
        ),
        force=EXPONENTIAL_FORCE * shape,
        starts=starts,
        forms=forms,
        excludes=("cubic_stiffening", "hertz_contact", "hunt_crossley", "saturating_spring"),
        assumptions=assumptions,
        reference="Fung, American J. Physiology 213 (1967), 1532; Biomechanics (1993), eq. 7.5:1",
    )


_ODD = _form(
    sp.sign(INDENTATION) * (sp.exp(sp.Abs(_DEPTH)) - 1) - _DEPTH,
    "The same in compression and tension",
)
EXPONENTIAL_STIFFENING = _form(
    sp.exp(_DEPTH) - 1 - _DEPTH, "Stiffens in compression, softens in tension", (_ODD,)
)
