"""Adhesion with a range: what holds the tip gives way over a distance, and not at once.

The tissue holds the tip where it lifts off its free surface, as far as the pull T of the tissue is
less than what holds, which is the weaker, the wider the gap g = max(-x, 0): the force is
max(T, -P(g)). It is P (1 - g / R), as of a bridge that thins evenly and is torn at g = R, or
P exp(-g / R), as of threads that go one by one, torn where less than a hundredth is left. What is
torn holds again after the tip has met the surface: on the way in there is no pull.
"""

import math
from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.effects.effect import (
    INDENTATION,
    TISSUE_FORCE,
    Effect,
    Parameter,
    Switch,
)
from tissue_probe.physics.extent import Extent

BOND = sp.Symbol("bond_force", positive=True)
RANGE = sp.Symbol("adhesion_range", positive=True)
BRIDGED, YIELDING = sp.symbols("bridged yielding", nonnegative=True)
_GAP = sp.Max(-INDENTATION, 0)
#: The gap over the range at which threads are torn: less than a hundredth of them is left.
TORN = math.log(100.0)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose shares of the largest tension, held over parts of the travel."""
    largest = extent.tensions[0] if extent.tensions else max(extent.pull, 0.2 * extent.force)
    return [
        {str(BOND): share * largest, str(RANGE): f * extent.indentation}
        for share in (0.1, 0.5)
        for f in (0.05, 0.2, 0.8)
    ]


def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose ranges by which the bond is torn in some cycles more or less.

    Which lifts tear it decides what follows, and no small change of the range adds or takes one.
    """
    return [{str(RANGE): found[str(RANGE)] * f} for f in (0.4, 0.8, 0.95, 0.98, 1.02, 1.05, 1.25)]


def _form(
    held: sp.Expr, torn_at: float, assumptions: str, forms: tuple[Effect, ...] = ()
) -> Effect:
    return Effect(
        name="adhesion_within_range",
        family="contact",
        physics="The tissue holds the tip the less, the farther it is lifted off",
        says="the tissue holds the tip with {bond_force:N}, which falls over a gap of "
        "{adhesion_range:m}",
        parameters=(
            Parameter(BOND, "N", default=0.1, lower=0.0, upper=1e3),
            Parameter(RANGE, "m", default=2e-4, lower=1e-5, upper=1e-2),
        ),
        contact=BRIDGED * ((1 - YIELDING) * TISSUE_FORCE - YIELDING * BOND * held),
        switches=(
            Switch(BRIDGED, INDENTATION + torn_at * RANGE, -INDENTATION),
            Switch(
                YIELDING,
                -(TISSUE_FORCE + BOND * held),
                TISSUE_FORCE + BOND * held,
                first=False,
            ),
        ),
        starts=starts,
        near=near,
        forms=forms,
        simpler=("contact_loss",),
        limit=str(RANGE),
        excludes=("adhesion",),
        assumptions=f"{assumptions}; sticks again where the tip meets the free surface",
        reference="Barenblatt, Advances in Applied Mechanics 7 (1962), 55, on forces that fall "
        "with the gap; Maugis, J. Colloid and Interface Science 150 (1992), 243, on their range",
    )


_THREADS = _form(sp.exp(-_GAP / RANGE), TORN, "Threads that go one by one")
ADHESION_WITHIN_RANGE = _form(
    sp.Max(1 - _GAP / RANGE, 0), 1.0, "A bridge that thins evenly", (_THREADS,)
)
