"""Adhesion: the tissue holds the tip until it is pulled off."""

from collections.abc import Mapping, Sequence

import sympy as sp

from tissue_probe.physics.effects.effect import (
    INDENTATION,
    TISSUE_FORCE,
    Effect,
    Parameter,
    Switch,
)
from tissue_probe.physics.extent import Extent

PULL_OFF = sp.Symbol("pull_off_force", positive=True)
ATTACHED = sp.Symbol("attached", nonnegative=True)
#: Between how many of the largest peaks of the tension a search begins, and about a force found.
LARGEST, NEAREST = 12, 12
#: Peaks that differ by less than this share of the largest count as one.
SAME_PEAK = 2e-4


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose pull-off forces between the largest peaks of the tension, and shares of the largest.

    Which peaks pull the tip off decides everything that follows, and no small change of the force
    adds or takes one. A weak one differs from none where the tip leaves the tissue often: there
    they lie closer.
    """
    largest = extent.tensions[0] if extent.tensions else max(extent.pull, 0.2 * extent.force)
    shares = (0.01, 0.03, *(i / 10 for i in range(1, 10)), 0.95, 1.05, 1.2, 1.5, 2.0)
    between = _between(extent.tensions)[:LARGEST]
    return [{"pull_off_force": force} for force in (*between, *(largest * i for i in shares))]


def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose pull-off forces that pull off in a few cycles more or less than the one found."""
    between = _between(extent.tensions)
    between.sort(key=lambda force: abs(force - found["pull_off_force"]))
    return [{"pull_off_force": force} for force in between[:NEAREST]]


def _between(tensions: Sequence[float]) -> list[float]:
    """Return forces halfway between each peak and the next one that differs, largest first."""
    pairs = zip(tensions, (*tensions[1:], 0.0), strict=False)
    return [(high + low) / 2 for high, low in pairs if high - low > SAME_PEAK * tensions[0]]


def _form(attached: Switch, physics: str, forms: tuple[Effect, ...] = ()) -> Effect:
    return Effect(
        name="adhesion",
        family="contact",
        physics=physics,
        says="the tissue holds the tip until {pull_off_force:N} pull it off",
        parameters=(Parameter(PULL_OFF, "N", default=0.1, lower=0.0, upper=1e3),),
        contact=TISSUE_FORCE * ATTACHED,
        switches=(attached,),
        neutral=1e3,
        starts=starts,
        near=near,
        forms=forms,
        simpler=("contact_loss",),
        limit=str(PULL_OFF),
        assumptions="Comes off at once, and sticks again where the tip meets the free surface",
        reference="Johnson, Kendall and Roberts, Proc. Royal Society A 324 (1971), 301",
    )


# It sticks where it is in the tissue and pushed back: pulled off by damping while still inside, it
# would otherwise stick again at once.
ADHESION = _form(
    Switch(ATTACHED, TISSUE_FORCE + PULL_OFF, sp.Max(-INDENTATION, -TISSUE_FORCE)),
    "The tip stays in contact until it is pulled at with the pull-off force",
)
