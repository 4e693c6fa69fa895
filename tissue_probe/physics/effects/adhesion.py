"""Adhesion: the tissue holds the tip until it is pulled off."""

from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.effects.effect import (
    INDENTATION,
    TISSUE_FORCE,
    Effect,
    Extent,
    Parameter,
    Switch,
)

PULL_OFF = sp.Symbol("pull_off_force", positive=True)
ATTACHED = sp.Symbol("attached", nonnegative=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose pull-off forces up to twice the tension read: the tip's inertia hides a part.

    A weak one differs from none where the tip leaves the tissue often: there they lie closer.
    """
    shares = (0.01, 0.03, *(i / 10 for i in range(1, 21)))
    return [{"pull_off_force": _tension(extent) * share} for share in shares]


def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose pull-off forces about one that was found, up to a tenth of the tension apart."""
    shares = (i / 100 for i in (-8, -6, -4, -3, -2, -1, 1, 2, 3, 4, 6, 8))
    return [{"pull_off_force": found["pull_off_force"] + _tension(extent) * i} for i in shares]


def _tension(extent: Extent) -> float:
    """Return the tension that may have been [N], also where inertia hid it from the load cell."""
    return max(extent.pull, 0.2 * extent.force)


def _form(attached: Switch, physics: str, forms: tuple[Effect, ...] = ()) -> Effect:
    return Effect(
        name="adhesion",
        family="contact",
        physics=physics,
        parameters=(Parameter(PULL_OFF, "N", default=0.1, lower=0.0, upper=1e3),),
        contact=TISSUE_FORCE * ATTACHED,
        switches=(attached,),
        neutral=1e3,
        starts=starts,
        near=near,
        forms=forms,
        simpler=("contact_loss",),
        assumptions="Comes off at once, and sticks again where the tip meets the free surface",
        reference="Johnson, Kendall and Roberts, Proc. Royal Society A 324 (1971), 301",
    )


# It sticks where it is in the tissue and pushed back: pulled off by damping while still inside, it
# would otherwise stick again at once.
ADHESION = _form(
    Switch(ATTACHED, TISSUE_FORCE + PULL_OFF, sp.Max(-INDENTATION, -TISSUE_FORCE)),
    "The tip stays in contact until it is pulled at with the pull-off force",
)
