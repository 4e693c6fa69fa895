"""Power-law relaxation: the springpot, as a ladder of Maxwell branches."""

import math
from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.dynamic_stiffness import hand_over
from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Parameter, State
from tissue_probe.physics.extent import Extent

SPRINGPOT_STIFFNESS = sp.Symbol("springpot_stiffness", real=True)
SPRINGPOT_EXPONENT = sp.Symbol("springpot_exponent", positive=True)
#: So near, branches leave a law of a power by 0.03 % (the trapezoidal rule over log r).
PER_DECADE = 2.0
#: A tenth of the slowest rate, and ten times the fastest, that records of the usual size tell: of
#: 100 to a million samples, whose length and period have a geometric mean near 0.2 s.
RATES = [10 ** (-3.5 + i / PER_DECADE) for i in range(15)]
BRANCHES = sp.symbols(f"springpot_branch_1:{len(RATES) + 1}", real=True)

# The relaxation function c (t / s)^-a / Gamma(1 - a) is an integral of exponentials over all rates
# r with the density r^(a - 1) sin(pi a) / pi; each branch stands for a stretch of log r, and its
# state is the compression e of its spring.
_WIDTH = math.log(10.0) / PER_DECADE
_WEIGHTS = [
    sp.Float(rate) ** SPRINGPOT_EXPONENT * sp.sin(sp.pi * SPRINGPOT_EXPONENT) / sp.pi
    for rate in RATES
]


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose exponents from nearly a spring to nearly a damper."""
    return [{"springpot_exponent": exponent} for exponent in (0.15, 0.3, 0.5, 0.7)]


def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose other exponents, tissue and springpot together as stiff at the motion's frequency.

    With the strength found, as stiff there as it is, and with shares of the whole: all lie along a
    valley too long and bent for a search, and of no strength the way up may begin downhill.
    """
    turned = 1j * extent.frequency
    known = found[str(SPRINGPOT_STIFFNESS)] * turned ** found[str(SPRINGPOT_EXPONENT)]
    proposed = []
    for other in (0.1, 0.25, 0.4, 0.55, 0.7, 0.85):
        unit = turned**other
        most, _ = hand_over(extent.frequency, found, known, unit, 1.0)
        own = min(abs(known / unit) / most, 1.0) if most > 0.0 else 0.0
        for share in (own, 0.3, 0.8):
            scaled, rest = hand_over(extent.frequency, found, known, unit, share)
            proposed.append(
                {str(SPRINGPOT_STIFFNESS): scaled, str(SPRINGPOT_EXPONENT): other, **rest}
            )
    return proposed


SPRINGPOT = Effect(
    name="springpot",
    family="relaxation",
    physics="A force that follows the fractional derivative of the indentation, c s^a D^a x",
    says="the force relaxes as time^-{springpot_exponent:.2f}",
    parameters=(
        Parameter(SPRINGPOT_STIFFNESS, "N/m s^a", default=50.0, lower=0.0, upper=1e5),
        Parameter(SPRINGPOT_EXPONENT, "1", default=0.3, lower=0.02, upper=0.98),
    ),
    force=SPRINGPOT_STIFFNESS
    * _WIDTH
    * sum(w * e for w, e in zip(_WEIGHTS, BRANCHES, strict=True)),
    states=tuple(
        State(e, TIP_VELOCITY - rate * e, spread="branch")
        for rate, e in zip(RATES, BRANCHES, strict=True)
    ),
    starts=starts,
    near=near,
    excludes=("standard_linear_solid", "generalized_maxwell", "quasi_linear_relaxation"),
    assumptions="Small strains; relaxation times between 0.3 ms and 3000 s, what is faster being "
    "the damping's and what is slower the stiffness's",
    reference="Koeller, J. Applied Mechanics 51 (1984), 299; Schmidt and Gaul, "
    "Nonlinear Dynamics 29 (2002), 37",
)
