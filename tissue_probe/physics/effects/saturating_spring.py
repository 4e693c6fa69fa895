"""A spring that softens: the deeper it is pressed, the less its force grows."""

import sympy as sp

from tissue_probe.physics.effects.effect import INDENTATION, STIFFNESS, Effect, Parameter
from tissue_probe.physics.extent import Extent

#: Over the depth s, whose inverse this is [1/m], the force over the depth falls to a half of what
#: it is at first, or to three quarters.
SOFTENING = sp.Symbol("softening_with_depth", nonnegative=True)
_SHARE = SOFTENING * sp.Abs(INDENTATION)
#: Below this tanh(y) / y, which has no value at 0, is 1 - y^2 / 3 to 13 digits.
NONE = 1e-3


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose springs that soften little over the travel, and that hardly resist at its end."""
    deepest = max(extent.depth, extent.indentation)
    return [{str(SOFTENING): f / deepest} for f in (0.3, 1.0, 3.0)]


def _form(share: sp.Expr, assumptions: str, forms: tuple[Effect, ...] = ()) -> Effect:
    return Effect(
        name="saturating_spring",
        family="stiffening",
        physics="The spring softens with depth: its force k x / (1 + x / s), or k s tanh(x / s)",
        says="the spring softens over {softening_with_depth:depth}",
        parameters=(Parameter(SOFTENING, "1/m", default=200.0, lower=0.0, upper=1e5),),
        force=STIFFNESS * INDENTATION * (share - 1),
        starts=starts,
        forms=forms,
        excludes=("cubic_stiffening", "exponential_stiffening", "hertz_contact"),
        assumptions=assumptions,
        reference="Kondner, J. Soil Mechanics and Foundations 89 (1963), 115, on hyperbolic laws; "
        "Ramberg and Osgood, NACA TN 902 (1943), on yielding ones",
    )


_YIELDING = _form(
    sp.Piecewise((1 - _SHARE**2 / 3, _SHARE < NONE), (sp.tanh(_SHARE) / _SHARE, True)),
    "k s tanh(x / s): straight at first; the same in compression and tension",
)
SATURATING_SPRING = _form(
    1 / (1 + _SHARE), "k x / (1 + x / s); the same in compression and tension", (_YIELDING,)
)
