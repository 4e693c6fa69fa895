"""A further recorded channel, such as a pressure, a voltage or a temperature, drives the force.

F = c1 w + c2 w^2 + c3 w^3, where w is the channel in its own unit, or that after a first-order lag.
"""

from dataclasses import replace

import sympy as sp

from tissue_probe.physics.effects.effect import INPUT2, Effect, Parameter, State
from tissue_probe.physics.extent import Extent

GAIN, SQUARE, CUBE = sp.symbols("input2_gain input2_square input2_cube", real=True)
INPUT2_LAG = sp.Symbol("input2_lag", positive=True)
LAGGED_INPUT2 = sp.Symbol("lagged_input2", real=True)
_GAIN = Parameter(GAIN, "N/input2", default=0.02, lower=-1e3, upper=1e3)
_POLYNOMIAL = (
    _GAIN,
    Parameter(SQUARE, "N/input2^2", default=1e-3, lower=-1e3, upper=1e3),
    Parameter(CUBE, "N/input2^3", default=1e-4, lower=-1e3, upper=1e3),
)
# A shorter one is within a sample of most records, and would ask for very short steps.
_LAG = Parameter(INPUT2_LAG, "s", default=0.05, lower=1e-3, upper=1e3)
_STATE = State(LAGGED_INPUT2, (INPUT2 - LAGGED_INPUT2) / INPUT2_LAG, start=INPUT2, spread="input2")


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose lags from the shortest to a good part of the record."""
    longest = 0.3 * extent.duration
    return [{"input2_lag": lag} for lag in (0.003, 0.01, 0.03, 0.1, 0.3) if lag < longest] + [
        {"input2_lag": longest}
    ]


def _form(
    w: sp.Expr, curve: tuple[Parameter, ...], lagged: bool, forms: tuple[Effect, ...] = ()
) -> Effect:
    says = "the second input drives the force by {input2_gain:N/input2}"
    effect = Effect(
        name="second_input",
        family="second input",
        physics="A recorded channel w drives the force: c1 w + c2 w^2 + c3 w^3, maybe late",
        says=says + (", late by {input2_lag:s}" if lagged else ""),
        parameters=(*curve, *((_LAG,) if lagged else ())),
        drag=sum(each.symbol * w**power for power, each in enumerate(curve, 1)),
        states=(_STATE,) if lagged else (),
        strengths=len(curve),
        forms=forms,
        assumptions="No force where the channel reads 0; first-order lag; the channel has no noise",
        reference="Ljung, System Identification (1999), section 4.2, on several inputs; Doebelin, "
        "Measurement Systems (2004), section 3.3, on first-order instruments",
    )
    return replace(effect, starts=starts) if lagged else effect


SECOND_INPUT = _form(
    INPUT2,
    (_GAIN,),
    False,
    (
        _form(LAGGED_INPUT2, (_GAIN,), True),
        _form(INPUT2, _POLYNOMIAL, False),
        _form(LAGGED_INPUT2, _POLYNOMIAL, True),
    ),
)
