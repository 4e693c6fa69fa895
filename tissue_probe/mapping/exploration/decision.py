"""One decision of an exploration: whether the question is answered, and else where to probe next.

Contents: the two put together, from one posterior.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tissue_probe.mapping.exploration.answer import SiteAnswer, Sought, answer
from tissue_probe.mapping.exploration.choice import (
    USUAL_TRAVEL,
    NextSite,
    Purpose,
    Travel,
    next_sites,
)
from tissue_probe.mapping.exploration.first import first_sites
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.posterior_sample import Sampled
from tissue_probe.mapping.sites import Sites

Place = tuple[float, float]


@dataclass(frozen=True)
class SoughtQuestion:
    """What is asked of an area, and where the probe may go.

    Attributes
    ----------
    within : Polygon
        The area.
    no_go : tuple of Polygon
        Where no site may be; inclusions may.
    sought : Sought
        Which inclusions matter, and how surely the answer is to be given.
    purpose : str
        What sites are chosen for, as for ``next_sites``.
    outliers : float
        Share of sites that err far more than they state.
    """

    within: Polygon
    no_go: tuple[Polygon, ...] = ()
    sought: Sought = field(default_factory=Sought)
    purpose: Purpose = "both"
    outliers: float = 0.0


@dataclass(frozen=True)
class Decision:
    """What is known, and the site that tells most.

    Attributes
    ----------
    answer : Answer
        If answered, by as many states as a map has.
    site : NextSite or None
        None once the question is answered.
    """

    answer: SiteAnswer
    site: NextSite | None


def decide(
    sites: Sites,
    question: SoughtQuestion,
    *,
    start: Place | None = None,
    pending: Sequence[Place] = (),
    unreachable: Sequence[Place] = (),
    travel: Travel = USUAL_TRAVEL,
) -> Decision:
    """Return the decision that follows from the sites so far.

    Parameters
    ----------
    sites : Sites
        All that was felt.
    question : Question
        What is asked.
    start, pending, unreachable, travel
        As for ``next_sites``.

    Raises
    ------
    ParameterError
        If no site has a value, or no place is left for another.
    """
    sampled = Sampled.of(sites, question.within, quick=True, outliers=question.outliers)
    told = answer(sampled, question.sought, checked=False)
    if told.answered:
        told = final(sites, question)
        if told.answered:
            return Decision(told, None)
    (site,) = next_sites(
        sampled,
        1,
        question.within,
        no_go=question.no_go,
        start=start,
        pending=pending,
        unreachable=unreachable,
        travel=travel,
        purpose=question.purpose,
    )
    return Decision(told, site)


def final(sites: Sites, question: SoughtQuestion) -> SiteAnswer:
    """Return the answer by as many states as a map has; ParameterError if no site has a value."""
    sampled = Sampled.of(sites, question.within, outliers=question.outliers)
    return answer(sampled, question.sought)


def rehearse(question: SoughtQuestion) -> None:
    """Decide on sites that are made up: then all is compiled, or loaded."""
    x, y = np.array(first_sites(question.within, question.no_go)).T
    k = np.where(np.arange(x.size) == 0, 3.0, 1.0)
    made_up = Sites(x, y, np.zeros_like(x), np.arange(float(x.size)), k, 0.01 * k)
    decide(made_up, question)
    final(made_up, question)
