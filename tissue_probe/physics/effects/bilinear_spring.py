"""A spring with a knee: beyond a depth its stiffness is another one.

F = dk max(x - d, 0). With the knee d at the surface it is a spring of another stiffness in
compression than in tension.
"""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from tissue_probe.physics.effects.effect import INDENTATION, Effect, Parameter, Starts
from tissue_probe.physics.extent import Extent

STIFFNESS_BEYOND_KNEE = sp.Symbol("stiffness_beyond_knee", real=True)
KNEE = sp.Symbol("knee_depth", real=True)
_CHANGE = Parameter(STIFFNESS_BEYOND_KNEE, "N/m", default=200.0, lower=-1e6, upper=1e6)
_DEPTH = Parameter(KNEE, "m", default=5e-4, lower=-0.1, upper=0.1)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose knees throughout the travel."""
    return [{"knee_depth": extent.depth - 2.0 * extent.indentation * i / 6} for i in range(1, 6)]


def _form(
    parameters: tuple[Parameter, ...],
    depth: sp.Expr,
    says: str,
    assumptions: str,
    begun: Starts | None = None,
    forms: tuple[Effect, ...] = (),
) -> Effect:
    effect = Effect(
        name="bilinear_spring",
        family="stiffening",
        physics="A spring with a knee: beyond a depth, or pressed instead of pulled, it is another",
        says=says,
        parameters=parameters,
        force=STIFFNESS_BEYOND_KNEE * sp.Max(depth, 0),
        forms=forms,
        # A knee beyond the travel only shifts the force.
        simpler=("force_bias",),
        excludes=(
            "cubic_stiffening",
            "exponential_stiffening",
            "hertz_contact",
            "saturating_spring",
        ),
        assumptions=assumptions,
        reference="Shaw and Holmes, J. Sound and Vibration 90 (1983), 129, section 2",
    )
    return effect if begun is None else replace(effect, starts=begun)


_KNEE = _form(
    (_CHANGE, _DEPTH),
    INDENTATION - KNEE,
    "from {knee_depth:m} on the spring is {stiffness_beyond_knee:N/m} stiffer",
    "Straight on either side of a sharp knee",
    starts,
)
BILINEAR_SPRING = _form(
    (_CHANGE,),
    INDENTATION,
    "pressed, the spring is {stiffness_beyond_knee:N/m} stiffer than pulled",
    "Straight on either side of the surface",
    forms=(_KNEE,),
)
