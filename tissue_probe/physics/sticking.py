"""Dry friction that truly holds the tip: it sticks until it is pulled hard enough to slide.

Contents: when a tip that is held by friction slides, which way, and when it sticks.
"""

import sympy as sp

from tissue_probe.physics.effects.effect import NET_FORCE, TIP_VELOCITY, Switch

#: Transition velocity [m/s] of friction that creeps, below which it is hardly told from sticking.
SHARPEST = 1e-4
#: A recording may begin in motion: a tip that moves faster than this [m/s] slides.
STILL_TIP = 1e-6
#: More than any force [N]: a tip that slides one way does not begin to slide the other.
BARRED = 1e9


def sliding(name: str, breakaway: sp.Expr) -> tuple[Switch, Switch]:
    """Return switches of a tip that slides forward, into the tissue, and back; both off: it sticks.

    It sticks where its velocity turns, and slides, maybe at once, where the other forces on it
    exceed the force that friction holds (Karnopp, J. Dynamic Systems 107 (1985), 100). For a
    filter, which remembers no switch, it creeps instead.

    Parameters
    ----------
    name : str
        Of the effect, of which the switches' symbols are made.
    breakaway : Expr
        Force that friction holds at rest [N].
    """
    forward, back = sp.symbols(f"{name}_forward {name}_back", nonnegative=True)

    def switch(own: sp.Symbol, other: sp.Symbol, way: int) -> Switch:
        holds = sp.Min(breakaway - way * NET_FORCE, STILL_TIP - way * TIP_VELOCITY)
        return Switch(
            own,
            on=way * TIP_VELOCITY,
            off=holds + BARRED * other,
            first=False,
            alone=(1 + way * sp.tanh(TIP_VELOCITY / SHARPEST)) / 2,
        )

    return switch(forward, back, 1), switch(back, forward, -1)
