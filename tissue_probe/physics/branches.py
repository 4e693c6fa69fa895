"""Branches of a relaxing tissue side by side, each a spring in series with a damper.

Contents: the unknowns of two branches and more, and where a search for them begins.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import sympy as sp

from tissue_probe.physics.dynamic_stiffness import hand_over, of_branch
from tissue_probe.physics.effects.effect import Parameter, State
from tissue_probe.physics.extent import Extent

#: Rates to begin with: from the slowest that a record just tells, so far apart that five reach from
#: slow creep to the tip's own motion.
SLOWEST_TRIED, RATES_APART, RATES_TRIED = 0.5, 6.0, 5
#: Near the found ones branches are tried a decade apart.
DECADE = 10.0


class Branches:
    """Branches that are told apart by their number, from 1.

    Parameters
    ----------
    *rates : float
        Rate [1/s] that is typical of each.
    """

    def __init__(self, *rates: float) -> None:
        numbers = range(1, len(rates) + 1)
        self.count = len(rates)
        self.stiffnesses = [sp.Symbol(f"relaxing_stiffness_{n}", real=True) for n in numbers]
        self.rates = [sp.Symbol(f"relaxation_rate_{n}", positive=True) for n in numbers]
        self.compressions = [sp.Symbol(f"branch_compression_{n}", real=True) for n in numbers]
        self.parameters = (
            *(Parameter(k, "N/m", default=200.0, lower=0.0, upper=1e5) for k in self.stiffnesses),
            *(
                Parameter(rate, "1/s", default=usual, lower=1e-4, upper=2e3)
                for rate, usual in zip(self.rates, rates, strict=True)
            ),
        )
        self.force = sum(
            (k * e for k, e in zip(self.stiffnesses, self.compressions, strict=True)), sp.S.Zero
        )
        times = [f"{{{rate}:period}}" for rate in self.rates]
        #: How their times are told, see ``Effect.says``.
        self.times = f"{', '.join(times[:-1])} and {times[-1]}"

    def states(self, speed: sp.Expr) -> tuple[State, ...]:
        """Return the compression e [m] of each spring: e' = speed - r e, with its end's speed."""
        return tuple(
            State(e, speed - rate * e, spread="branch")
            for e, rate in zip(self.compressions, self.rates, strict=True)
        )

    def starts(self, extent: Extent) -> list[dict[str, float]]:
        """Propose rates a factor apart and more, from slow to the tip's own."""
        rates = [SLOWEST_TRIED / extent.duration * RATES_APART**i for i in range(RATES_TRIED)]
        names = [str(rate) for rate in self.rates]
        return [dict(zip(names, some, strict=True)) for some in combinations(rates, self.count)]

    def near(self, extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
        """Propose other rates, and most or half of the tissue's dynamic stiffness for the branches.

        At one frequency tissue and branches are alike, and lie along a valley too long for a
        search.
        """
        pairs = [*zip(map(str, self.stiffnesses), map(str, self.rates), strict=True)]
        known = sum(found[k] * of_branch(extent.frequency, found[rate]) for k, rate in pairs)
        proposed = []
        for slow in (extent.frequency * f for f in (0.03, 0.1, 0.3)):
            rates = [slow * DECADE**i for i in range(self.count)]
            unit = sum(of_branch(extent.frequency, rate) for rate in rates)
            for share in (0.5, 0.95):
                stiffness, rest = hand_over(extent.frequency, found, known, unit, share)
                own = dict.fromkeys(map(str, self.stiffnesses), stiffness)
                own |= {name: rate for (_, name), rate in zip(pairs, rates, strict=True)}
                proposed.append(own | rest)
        return proposed


TWO = Branches(5.0, 100.0)
THREE = Branches(1.0, 10.0, 100.0)
