"""Which effect is missing: the candidates in order, and what may be said of them.

What belongs here: the rules by which fits are compared, and the verdict.
What does not: fitting (``search``, ``candidates``), further effects (``improvement``).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from tissue_probe.diagnosis.evidence.adequacy import (
    ROUNDING,
    STRAINED,
    explained,
    is_coarse,
)
from tissue_probe.diagnosis.fitting.fit import Fit

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

#: A better fit is real where the BIC falls by more than this and the residual by this share.
LEAST_GAIN, LEAST_SHARE = 20.0, 0.003
#: Fits whose BIC is within this of the best are not distinguished from it.
TIE = 14.0
#: An effect that contains a simpler one stands back where its BIC gains less than this, or the
#: residual less than the share above.
SIMPLER = 30.0

#: The family of what recedes from the tip.
RELAXATION = "relaxation"


def significant(simple: Fit, better: Fit) -> bool:
    """Whether the second fit explains more than noise would let it, or a rig that is unlikely.

    Where it alone explains all, it need only be told from the first.
    """
    needed = TIE if explained(better) and not explained(simple) else LEAST_GAIN
    less = better.ratio < (1.0 - LEAST_SHARE) * simple.ratio
    likelier = better.strain < STRAINED <= simple.strain
    return simple.bic - better.bic > needed and (less or likelier)


def only_rounding(fit: Fit) -> bool:
    """Whether an encoder's rounding alone is as large as what a fit leaves.

    More than its size is not known, and among the few lines of a steady motion any further
    parameter may follow it: a fit that leaves less is no better.
    """
    return explained(fit) and fit.rounding > ROUNDING * fit.noise and fit.ratio <= 1.0


def preferred(fits: Iterable[Fit]) -> list[Fit]:
    """Order fits by BIC.

    Where the coarse steps of an encoder explain all and the best does not, they come first: they
    are there to be seen, and what smooths the force instead (a lag) may do better by a criterion
    that takes their noise for white.
    """
    order = sorted(fits, key=lambda fit: fit.bic)
    if order and not explained(order[0]):
        order.sort(key=lambda fit: not (is_coarse(fit) and explained(fit)))
    return order


def ranked(fits: Sequence[Fit]) -> list[Fit]:
    """Order fits with one effect more, a simpler effect before one that contains it."""
    order = preferred(fits)
    for fit in list(order):
        for name in added(fit).simpler:
            simpler = next((each for each in order if added(each).name == name), None)
            if simpler is None or gains_much(simpler, fit):
                continue
            if order.index(simpler) > order.index(fit):
                order.remove(simpler)
                order.insert(order.index(fit), simpler)
    return order


def gains_much(simpler: Fit, fit: Fit) -> bool:
    """Whether a fit with an effect that contains the other's is worth what it has more.

    One that ends in the limit where it is the other, or follows an encoder's rounding, is not.
    Where it alone explains all, it need only be told from the other.
    """
    if only_rounding(simpler) or in_limit(fit):
        return False
    share = 1.0 - fit.ratio / simpler.ratio
    needed = TIE if explained(fit) and not explained(simpler) else SIMPLER
    return simpler.bic - fit.bic > needed and share > LEAST_SHARE


def in_limit(fit: Fit) -> bool:
    """Whether an effect that contains a simpler one ended in the limit where it is that."""
    limits = [each for each in added(fit).parameters if each.name == added(fit).limit]
    return any(fit.named()[each.name] <= each.lower for each in limits)


def added(fit: Fit) -> Effect:
    """Return the effect that a fit has more than the model it was added to."""
    return fit.composition.effects[-1]


def exclude(effect: Effect, other: Effect) -> bool:
    """Whether two effects are forms of one law: beside one of them the other only bends it."""
    return other.name in effect.excludes or effect.name in other.excludes
