"""Inclusions that hang on one site: it may have slipped, and is to be palpated again.

Contents: which sites feel an inclusion, and where to palpate again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.domain import Domain
from tissue_probe.mapping.posterior.felt_surface import sums_at
from tissue_probe.mapping.posterior.found_inclusions import FoundInclusion
from tissue_probe.mapping.posterior.outliers import VARIANCES
from tissue_probe.mapping.posterior.sampling import States
from tissue_probe.signals import FloatArray, IntArray

#: Less probable than this, sites elsewhere tell more than another visit.
LEAST_DOUBTED = 0.2
#: A site feels an inclusion that adds so many standard deviations of what it is told by all others.
_FEELS = 2.0
#: Of the spacing: so far aside a nodule is felt as well, and what made the tip slip may be past.
ASIDE = 0.25
#: Of that: a site as near was palpated there again.
_VISITED = 1.5
#: Below, it would not make an inclusion certain if the site had not slipped.
_SLIPPED = 0.1
#: Places nearer than the tip's position is known are one [mm].
_SAME = 0.2
#: Enough for a median.
_MEDIAN_MEMBERS = 100


@dataclass(frozen=True)
class SiteDoubt:
    """A site on which an inclusion hangs: it alone feels it, or there is none if it slipped.

    Attributes
    ----------
    number : int
        Of the inclusion, among those found.
    row : int
        Of the site.
    alone : bool
        Whether no other feels it.
    x, y : float
        Where to palpate again, a little aside towards the inclusion's middle [mm].
    probability : float
        Of the inclusion.
    """

    number: int
    row: int
    alone: bool
    x: float
    y: float
    probability: float


def find_visits_of(one: FoundInclusion, states: States, background: Background) -> IntArray:
    """Return the rows of the visits that feel an inclusion, in most states that have it."""
    rows, count, chosen = one.some(_MEDIAN_MEMBERS)
    _, _, level, kinds = (each[chosen] for each in states.flat())
    added = np.log(sums_at(rows, count, background.x, background.y))
    told = np.diagonal(background.precision, axis1=1, axis2=2)[level]
    # By Sherman and Morrison, of each outlier alone.
    told = told / (1.0 + VARIANCES[kinds] * told)
    return np.flatnonzero(np.median(np.abs(added) * np.sqrt(told), axis=0) > _FEELS)


def doubts_of(
    found: list[FoundInclusion],
    felt: list[IntArray],
    states: States,
    domain: Domain,
    places: FloatArray,
) -> list[SiteDoubt]:
    """Return the inclusions that hang on one site, where no other visit was, surest first.

    Parameters
    ----------
    found : list of Found
        The most probable first.
    felt : list of array
        The rows of the visits that feel each.
    states : States
        That have them.
    domain : Domain
        Of the sites.
    places : array, shape (n, 2)
        The sites [mm].
    """
    doubts: list[SiteDoubt] = []
    aside = ASIDE * domain.spacing
    slipped = states.flat()[3] > 0
    for number, (one, rows) in enumerate(zip(found, felt, strict=True)):
        if not rows.size or one.probability < LEAST_DOUBTED:
            continue
        # How probably a site slipped, and nothing is there.
        instead = np.delete(slipped[:, rows], one.states, axis=0).sum(axis=0) / len(slipped)
        row, alone = int(rows[instead.argmax()]), rows.size == 1
        away = np.hypot(*(places - places[row]).T)
        visited = (away < _VISITED * aside).sum() > 1
        if visited or (instead.max() < _SLIPPED and not alone):
            continue
        x, y = _place_beside(places[row], one.centre, places, aside)
        doubts.append(SiteDoubt(number, row, alone, float(x), float(y), one.probability))
    return doubts


def _place_beside(
    site: FloatArray, middle: FloatArray, places: FloatArray, by: float
) -> FloatArray:
    """Return a place beside a site, towards a middle, or to most other sites where that is off."""
    low, high = places.min(axis=0), places.max(axis=0)
    for target in (middle, places.mean(axis=0)):
        way = target - site
        length = float(np.hypot(*way))
        if length > _SAME:
            place = site + by * way / length
            if (low - _SAME <= place).all() and (place <= high + _SAME).all():
                return place
    return site
