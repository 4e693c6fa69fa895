"""The map of a list of sites: chains run, and read out.

What belongs here: the parts put together, and their units changed to SI. What does not: each part,
and the results as data (``results``).
"""

from __future__ import annotations

import math

import numpy as np

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.boundary import boundaries, share_inside
from tissue_probe.mapping.posterior.check import LEAST, predictive_probability
from tissue_probe.mapping.posterior.felt_surface import sums_at, surface_of
from tissue_probe.mapping.posterior.found import Found
from tissue_probe.mapping.posterior.hidden import could_hide
from tissue_probe.mapping.posterior.process import LEVELS, map_of_process
from tissue_probe.mapping.posterior.results import (
    Check,
    CouldHide,
    Inclusion,
    PosteriorMap,
    SurfaceFelt,
    TissueBackground,
)
from tissue_probe.mapping.posterior.sampled import LEAST_SITES, Felt, Sampled
from tissue_probe.mapping.posterior.sampling import AGREEMENT, States
from tissue_probe.mapping.sites import Sites
from tissue_probe.signals import FloatArray

RASTER = 0.5e-3  # m
CONTRAST = 1.5
_MM = 1e3
#: The background is the tissue that most places are like.
_ALIKE = 0.25
#: States that tell P(inclusion) of a place: enough for an error of 2 %.
_SHARE_STATES = 1000
_TREND_STATES = 200
_COARSEST = 1.5  # mm, of the raster of what could hide: no finer than its radii are of use


def map_of(
    sites: Sites,
    *,
    raster: float = RASTER,
    contrast: float = CONTRAST,
    within: Polygon | None = None,
) -> PosteriorMap:
    """Return the posterior map of a list of sites. The same sites have the same map, bit for bit.

    Parameters
    ----------
    sites : Sites
        In any order.
    raster : float
        Step of the surface [m].
    contrast : float
        Of the inclusions that could hide: stiffness over their middle, over the background's.
    within : Polygon, optional
        An area of which the map is to speak, however far from the sites.

    Raises
    ------
    ParameterError
        If no site has a value, or a parameter is out of its range.
    """
    return read_out(Sampled.of(sites, within), sites, raster=raster, contrast=contrast)


def read_out(
    sampled: Sampled, sites: Sites, *, raster: float = RASTER, contrast: float = CONTRAST
) -> PosteriorMap:
    """Return the map of sites whose states are known; errors as ``map_of``."""
    if not (math.isfinite(raster) and raster > 0.0):
        raise ParameterError(f"raster is {raster} m; it must be positive and finite")
    if not 1.0 < contrast < 100.0:
        raise ParameterError(f"contrast is {contrast}; it must be above 1 and below 100")
    felt, domain, background = sampled.felt, sampled.domain, sampled.background
    states, found, disagreement = sampled.states, sampled.found, sampled.disagreement
    probability = predictive_probability(states, background, felt.log_k)
    notes = [*sites.left_out, *_notes(felt, disagreement, probability)]
    step = _MM * raster
    x, y = domain.raster(step)
    if probability < LEAST:
        wide = Background.of(felt.x, felt.y, felt.t, felt.noise, LEVELS)
        model, (mean, sd, share, inclusions) = (
            "gaussian_process",
            map_of_process(wide, felt.log_k, felt.level, x, y),
        )
    else:
        model = "inclusions"
        mean, sd = (
            math.exp(felt.level) * each for each in surface_of(states, background, felt.log_k, x, y)
        )
        rows, count, _ = states.some(_SHARE_STATES)
        share = share_inside(rows[np.arange(rows.shape[1]) < count[:, None]], count.size, x, y)
        inclusions = [_inclusion(one, mean, sd, x, y) for one in found]
    if felt.x.size < LEAST_SITES:
        inclusions = []
    unknown = ~domain.known(x, y)
    for layer in (mean, sd, share):
        layer[unknown] = np.nan
    hx, hy = domain.raster(max(step, _COARSEST))
    hidden = could_hide(states, background, felt.log_k, contrast, hx, hy)
    hidden[~domain.known(hx, hy)] = np.nan
    tissue = _tissue(states, background, felt)
    alike = np.abs(mean[~unknown] / tissue.stiffness - 1.0) < _ALIKE
    if alike.mean() < 0.5:
        notes.append(
            f"only {alike.mean():.0%} of the tissue is within {_ALIKE:.0%} of the background of "
            f"{tissue.stiffness:.0f} N/m: it is not certain which tissue is the background"
        )
    chains, kept = states.count.shape
    return PosteriorMap(
        tuple(inclusions),
        SurfaceFelt(x / _MM, y / _MM, mean, sd, share),
        CouldHide(hx / _MM, hy / _MM, hidden / _MM, contrast),
        tissue,
        Check(model, probability, disagreement, chains * kept, tuple(notes)),
    )


def _notes(felt: Felt, disagreement: float, probability: float) -> list[str]:
    told = []
    if felt.x.size < LEAST_SITES:
        told.append(
            f"{felt.x.size} sites cannot tell an inclusion from a tilted background: "
            f"give {LEAST_SITES} or more"
        )
    if disagreement > AGREEMENT:
        told.append(
            f"two halves of the chains differ by {disagreement:.2f} in the probability of an "
            f"inclusion after all moves: read probabilities with this error"
        )
    if probability < LEAST:
        told.append(
            "inclusions on a smooth background do not explain the sites (posterior-predictive "
            f"probability {probability:.3f}): surface and inclusions are those of a Gaussian "
            "process, and what could hide is not reliable"
        )
    return told


def _inclusion(
    one: Found, mean: FloatArray, sd: FloatArray, x: FloatArray, y: FloatArray
) -> Inclusion:
    centre = one.centre
    row, column = (int(np.abs(axis - at).argmin()) for axis, at in ((y, centre[1]), (x, centre[0])))
    lines = boundaries(one.members)
    return Inclusion(
        *(float(each) / _MM for each in centre),
        one.covariance / _MM**2,
        one.probability,
        float(mean[row, column]),
        float(sd[row, column]),
        one.contrast,
        *(lines[percent] / _MM for percent in (50, 90, 95)),
    )


def _tissue(states: States, background: Background, felt: Felt) -> TissueBackground:
    """Return the background: coefficients of the trend, less the mean of what inclusions add."""
    rows, count, level = states.some(_TREND_STATES)
    explained = np.log(sums_at(rows, count, background.x, background.y)).mean(axis=0)
    used = int(np.bincount(level).argmax())
    trend = background.trend(used, felt.log_k - explained)
    middle = math.exp(felt.level + trend.level)
    return TissueBackground(
        middle,
        middle * trend.level_sd,
        (_MM * trend.tilt[0], _MM * trend.tilt[1]),
        float(np.mean([background.levels.size(int(each)) for each in level])),
        math.exp(trend.drift) - 1.0,
    )
