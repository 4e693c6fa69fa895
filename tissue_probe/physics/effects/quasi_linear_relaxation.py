"""Quasi-linear viscoelasticity: the spring's own law, whatever it is, times a relaxation function.

F = k D(x(t)) + integral of G(t - s) dD(x(s)), where k D is the spring's force: with Hertz's law
beside this effect D is x (x / 1 mm)^(n - 1), with a straight spring the indentation x. G [N/m] is a
sum of branches K exp(-r t). As a differential equation, each branch has a state e [m] that follows
e' = D'(x) x' - r e, and its force is K e.
"""

import sympy as sp

from tissue_probe.physics.branches import THREE, TWO
from tissue_probe.physics.effects import standard_linear_solid as single
from tissue_probe.physics.effects.effect import (
    ELASTIC_RATE,
    Effect,
    Parameter,
    Starts,
    State,
)
from tissue_probe.physics.extent import Extent

SPECTRUM, SLOPE = sp.symbols("spectrum_stiffness spectrum_slope", real=True)
SLOWEST_RATE, FASTEST_RATE = sp.symbols("slowest_rate fastest_rate", positive=True)
#: So many branches follow a flat spectrum of three decades to 1 % of its strength.
COUNT = 6
COMPRESSIONS = sp.symbols(f"spectrum_branch_1:{COUNT + 1}", real=True)
_RATIO = FASTEST_RATE / SLOWEST_RATE
_PLACES = [sp.Rational(i, COUNT - 1) for i in range(COUNT)]
_RATES = [SLOWEST_RATE * _RATIO**place for place in _PLACES]
_WEIGHTS = [_RATIO ** (SLOPE * place) for place in _PLACES]


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose flat spectra of two to four decades, from the slowest that the record tells."""
    slow = [0.5 / extent.duration * f for f in (1.0, 10.0)]
    return [
        {"slowest_rate": rate, "fastest_rate": rate * span}
        for rate in slow
        for span in (1e2, 1e3, 1e4)
        if rate * span <= 2e3
    ]


def _form(
    parameters: tuple[Parameter, ...],
    force: sp.Expr,
    states: tuple[State, ...],
    begun: Starts,
    says: str,
    assumptions: str,
    forms: tuple[Effect, ...] = (),
) -> Effect:
    return Effect(
        name="quasi_linear_relaxation",
        family="relaxation",
        physics="Branches whose springs are curved as the tissue's own: its force times a "
        "relaxation function",
        says=says,
        parameters=parameters,
        force=force,
        states=states,
        strengths=sum(each.unit == "N/m" for each in parameters),
        starts=begun,
        forms=forms,
        simpler=("standard_linear_solid", "generalized_maxwell"),
        excludes=("standard_linear_solid", "generalized_maxwell", "springpot"),
        assumptions=f"{assumptions}, the same at every depth; the damping stays linear",
        reference="Fung, Biomechanics: Mechanical Properties of Living Tissues (1993), section "
        "7.6; Puso and Weiss, J. Biomechanical Engineering 120 (1998), 62, on discrete spectra",
    )


_EVEN = _form(
    (
        Parameter(SPECTRUM, "N/m", default=300.0, lower=0.0, upper=1e5),
        Parameter(SLOWEST_RATE, "1/s", default=1.0, lower=1e-4, upper=2e3),
        Parameter(FASTEST_RATE, "1/s", default=100.0, lower=1e-4, upper=2e3),
        Parameter(SLOPE, "1", default=0.0, lower=-2.0, upper=2.0),
    ),
    SPECTRUM * sum(w * e for w, e in zip(_WEIGHTS, COMPRESSIONS, strict=True)) / sum(_WEIGHTS),
    tuple(
        State(e, ELASTIC_RATE - rate * e, spread="branch")
        for rate, e in zip(_RATES, COMPRESSIONS, strict=True)
    ),
    starts,
    "its whole curved force relaxes within {fastest_rate:period} to {slowest_rate:period}",
    "Relaxation times spread evenly by their logarithm, weighed by a power of the rate",
)
_TWO, _THREE = (
    _form(
        each.parameters,
        each.force,
        each.states(ELASTIC_RATE),
        each.starts,
        f"its whole curved force relaxes within {each.times}",
        f"{each.count} relaxation times",
    )
    for each in (TWO, THREE)
)
QUASI_LINEAR_RELAXATION = _form(
    single.STANDARD_LINEAR_SOLID.parameters,
    single.STANDARD_LINEAR_SOLID.force,
    (State(single.COMPRESSION, ELASTIC_RATE - single.RATE * single.COMPRESSION, spread="branch"),),
    single.starts,
    "its whole curved force relaxes within {relaxation_rate:period}",
    "One relaxation time",
    (_TWO, _THREE, _EVEN),
)
