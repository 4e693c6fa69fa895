"""The equations of one effect as it declares them, in LaTeX."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from tissue_probe.analysis.symbols import latex
from tissue_probe.physics.effects.effect import POSITION, POSITION_RATE, Effect

#: Operations in an expression from which on a reader gets more from the sentence beside it: laws
#: with a name have 12 at most, and sums over branches or periods 100 and more.
MOST_OPERATIONS = 60
#: The side on the left of each place where an effect may act; the places are fields of ``Effect``.
LEFT_SIDES = {
    "force": "\\text{tissue force} = k \\cdot x + \\beta \\cdot \\dot{x} + ",
    "contact": "\\text{force on the tip} = ",
    "drag": "\\text{force on the tip} = \\text{tissue force} + ",
    "moving": "\\text{the tip moves} = ",
    "inertia": "\\text{mass of the tip} = m + ",
    "stretch": "\\text{compression of the load cell} = ",
    "engaged": "\\text{load cell engaged} = ",
    "cell": "\\text{stiffness of the load cell} = k_0 \\cdot ",
    "output": "\\text{measured force} = ",
    "position": "\\text{true position} = ",
    "delay": "\\text{delay of the force} = ",
    "rounded": "\\text{step of the position} = ",
}
#: More are a ladder of branches of one form, which no reader wants line by line.
MOST_STATES = 5


def equations(effect: Effect) -> tuple[str, ...]:
    """Return the equations that differ from those of the model without the effect.

    Equations of more than ``MOST_OPERATIONS`` operations are left out.

    Parameters
    ----------
    effect : Effect
        In the form that is to be shown.

    Returns
    -------
    tuple of str
        LaTeX.
    """
    return tuple(
        f"{left}{_factor(right) if left.endswith('cdot ') else latex(right)}"
        for left, right in (*_places(effect), *_pairs(effect), *_states(effect))
        if sp.count_ops(right) <= MOST_OPERATIONS
    ) + tuple(_switches(effect))


def _factor(expression: sp.Expr) -> str:
    return f"\\left({latex(expression)}\\right)"


def _places(effect: Effect) -> Iterator[tuple[str, sp.Expr]]:
    plain = Effect("", "", "")
    for place, left in LEFT_SIDES.items():
        right = sp.sympify(getattr(effect, place))
        if right != sp.sympify(getattr(plain, place)):
            yield left, right


def _pairs(effect: Effect) -> Iterator[tuple[str, sp.Expr]]:
    if effect.surface != (sp.S.Zero, sp.S.Zero):
        yield "\\text{place of the surface} = ", effect.surface[0]
    if effect.coil != (POSITION, POSITION_RATE):
        yield "\\text{position of the load cell's end} = ", effect.coil[0]


def _states(effect: Effect) -> Iterator[tuple[str, sp.Expr]]:
    if len(effect.states) > MOST_STATES:
        return
    for state in effect.states:
        yield f"\\frac{{d}}{{dt}} {latex(state.symbol)} = ", sp.sympify(state.motion)


def _switches(effect: Effect) -> Iterator[str]:
    for switch in effect.switches:
        for turn, past in (("1 \\to 0", switch.on), ("0 \\to 1", switch.off)):
            yield f"{latex(switch.symbol)}: \\; {turn} \\text{{ as soon as }} {latex(past)} < 0"
