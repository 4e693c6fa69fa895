"""Which fits come first, and which are better: by the evidence of a model, one number for all.

Contents: comparing fits, and how effects stand to each other.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from tissue_probe.diagnosis.evidence.posterior import RIVAL, evidence, is_at_limit
from tissue_probe.diagnosis.fitting.fit import Fit

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect


def rank_fits(base: Fit, fits: Iterable[Fit]) -> list[Fit]:
    """Order fits by their evidence beside a base, the most probable first."""
    return sorted(fits, key=lambda fit: -evidence(fit, base))


def significant(simple: Fit, better: Fit, base: Fit) -> bool:
    """Whether a fit is surely more probable than another one, were there these two only."""
    return evidence(better, base) - evidence(simple, base) > RIVAL


def in_limit(fit: Fit) -> bool:
    """Whether the added effect ended in the limit where it is a simpler one."""
    return is_at_limit(find_added_effect(fit), fit.named())


def find_added_effect(fit: Fit) -> Effect:
    """Return the effect that a fit has more than the model it was added to."""
    return fit.composition.effects[-1]


def exclude(effect: Effect, other: Effect) -> bool:
    """Whether two effects are forms of one law: beside one of them the other only bends it."""
    return other.name in effect.excludes or effect.name in other.excludes
