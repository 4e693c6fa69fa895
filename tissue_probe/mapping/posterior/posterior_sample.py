"""The posterior of a list of sites, as states of chains: what all that is told of them rests on.

Contents: the sites in the chains' units, and how long the chains run.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.bodies import bodies_of
from tissue_probe.mapping.posterior.domain import Domain
from tissue_probe.mapping.posterior.doubt import SiteDoubt, doubts_of, find_visits_of
from tissue_probe.mapping.posterior.found_inclusions import FoundInclusion, find_inclusions
from tissue_probe.mapping.posterior.outliers import prior_of
from tissue_probe.mapping.posterior.sampling import AGREEMENT, STRETCH, Chains, States
from tissue_probe.mapping.sites import Sites
from tissue_probe.signals import FloatArray, IntArray

_MM = 1e3
#: A plane takes three sites; a fourth is the first to contradict it.
LEAST_SITES = 4
#: How far an inclusion's true form is from the model's, relative to k at a site. Those of finite
#: elements are off by 0.5 % (rms), and by 2 % where most. Sites that are more exact would be
#: explained by further inclusions, which are not there, and each chain would find some of its own.
FORM_ERROR = 0.02


@dataclass(frozen=True)
class FeltSites:
    """The sites that tell something, in mm, in an order that does not depend on theirs."""

    x: FloatArray
    y: FloatArray
    t: FloatArray | None
    log_k: FloatArray
    noise: FloatArray
    level: float

    @staticmethod
    def of(sites: Sites) -> FeltSites:
        """Return the sites that tell something."""
        felt = np.flatnonzero(sites.felt)
        keys = [sites.k_sd, sites.k, *([sites.t] if sites.t is not None else []), sites.y, sites.x]
        felt = felt[np.lexsort([key[felt] for key in keys])]
        log_k = np.log(sites.k[felt])
        level = float(np.median(log_k))
        t = sites.t[felt] if sites.t is not None else None
        noise = sites.k_sd[felt] / sites.k[felt]
        return FeltSites(_MM * sites.x[felt], _MM * sites.y[felt], t, log_k - level, noise, level)

    @property
    def visits(self) -> list[IntArray]:
        """The rows of each place, in the order of places."""
        at = np.round(np.column_stack([self.x, self.y]), 3)
        place = np.unique(at, axis=0, return_inverse=True)[1].ravel()
        return [np.flatnonzero(place == number) for number in range(place.max() + 1)]


@dataclass(frozen=True)
class Sampled:
    """The states, and all that they were drawn for; lengths in mm.

    Attributes
    ----------
    felt : Felt
        The sites that tell something.
    domain : Domain
        The places of which the states speak.
    background : Background
        Of the sites.
    states : States
        Of all chains.
    found : list of Found
        The inclusions that they have in common.
    disagreement : float
        Largest difference between two halves of the chains in the probability of an inclusion.
    """

    felt: FeltSites
    domain: Domain
    background: Background
    states: States
    found: list[FoundInclusion]
    disagreement: float

    @cached_property
    def felt_by(self) -> list[IntArray]:
        """The rows of the visits that feel each inclusion."""
        return [find_visits_of(one, self.states, self.background) for one in self.found]

    @cached_property
    def doubts(self) -> list[SiteDoubt]:
        """The inclusions that hang on one site, and where to palpate again; surest first."""
        places = np.column_stack([self.felt.x, self.felt.y])
        return doubts_of(self.found, self.felt_by, self.states, self.domain, places)

    @staticmethod
    def of(
        sites: Sites,
        within: Polygon | None = None,
        *,
        quick: bool = False,
        outliers: float | None = 0.0,
        raster: float | None = None,
    ) -> Sampled:
        """Run chains until their halves agree. The same sites have the same states, bit for bit.

        Parameters
        ----------
        sites : Sites
            In any order.
        within : Polygon, optional
            An area in which inclusions may be however far from the sites; by default they may be
            near sites alone.
        quick : bool
            Run them half a stretch each, whether they agree or not: for a choice that is made again
            with the next site, not for a probability that is told.
        outliers : float, optional
            Share of sites that err far more than they state, 0 to below 1; None if it is learnt.
        raster : float, optional
            Step of the surface that is to be read out [m], which is refused before the chains run.

        Raises
        ------
        ParameterError
            If no site has a value, ``outliers`` is out of its range, or the raster has too many
            cells.
        """
        if outliers is not None and not 0.0 <= outliers < 1.0:
            raise ParameterError(f"outliers is {outliers}; give a share from 0 to below 1")
        if not sites.felt.any():
            raise ParameterError(
                f"none of {sites.x.size} sites has a stiffness above 0: there is nothing to map"
            )
        felt = FeltSites.of(sites)
        hanging = _MM * np.column_stack([sites.x, sites.y])[sites.hanging]
        domain = Domain.of(felt.x, felt.y, hanging, within)
        if raster is not None:
            domain.raster(_MM * raster)
        error = np.hypot(felt.noise, FORM_ERROR)
        background = Background.of(felt.x, felt.y, felt.t, error)
        region = domain.region(felt.x, felt.y)
        chains = Chains(felt.log_k, region, background, prior_of(outliers))
        parts: list[States] = []
        while True:
            parts.append(chains.further(STRETCH // 2 if quick else STRETCH))
            states = States.join_parts(parts)
            found = bodies_of(find_inclusions(states), region.area)
            halves = [one.by_chain.reshape(2, -1).mean(axis=1) for one in found]
            disagreement = max((abs(float(a - b)) for a, b in halves), default=0.0)
            if quick or disagreement <= AGREEMENT or chains.exhausted:
                return Sampled(felt, domain, background, states, found, disagreement)
