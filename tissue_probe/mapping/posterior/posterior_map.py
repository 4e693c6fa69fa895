"""The map of a list of sites: chains run, and read out.

Contents: the parts put together, and their units changed to SI.
"""

from __future__ import annotations

import math

import numpy as np

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.boundary import MEMBERS, boundaries, share_inside
from tissue_probe.mapping.posterior.check import LEAST_PASSED, predictive_probability
from tissue_probe.mapping.posterior.doubt import SiteDoubt
from tissue_probe.mapping.posterior.felt_surface import sums_at, surface_of
from tissue_probe.mapping.posterior.found_inclusions import FoundInclusion
from tissue_probe.mapping.posterior.hidden_inclusions import could_hide
from tissue_probe.mapping.posterior.posterior_sample import (
    FORM_ERROR,
    LEAST_SITES,
    FeltSites,
    Sampled,
)
from tissue_probe.mapping.posterior.process import VARIANCE_LEVELS, map_of_process
from tissue_probe.mapping.posterior.results import (
    Again,
    Check,
    CouldHide,
    Inclusion,
    PosteriorMap,
    SurfaceFelt,
    TissueBackground,
)
from tissue_probe.mapping.posterior.sampling import AGREEMENT, States
from tissue_probe.mapping.sites import Sites
from tissue_probe.signals import FloatArray

RASTER = 0.5e-3  # m
SOUGHT_CONTRAST = 1.5
_MM = 1e3
#: The background is the tissue that most places are like.
_MOST_ALIKE = 0.25
#: States that tell P(inclusion) of a place: enough for an error of 2 %.
_SHARE_STATES = 1000
_TREND_STATES = 200
#: Visits of one place contradict one another where they are not alike, and differ by so many of
#: their standard deviations: by chance one pair in a million does.
_SURE = 5.0
_COARSEST = 1.5  # mm, of the raster of what could hide: no finer than its radii are of use


def map_of(
    sites: Sites,
    *,
    raster: float = RASTER,
    contrast: float = SOUGHT_CONTRAST,
    within: Polygon | None = None,
    outliers: float | None = 0.0,
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
    outliers : float, optional
        Share of sites that err far more than they state; None if it is learnt.

    Raises
    ------
    ParameterError
        If no site has a value, or a parameter is out of its range.
    """
    sampled = Sampled.of(sites, within, outliers=outliers, raster=raster)
    return read_out(sampled, sites, raster=raster, contrast=contrast)


def read_out(
    sampled: Sampled, sites: Sites, *, raster: float = RASTER, contrast: float = SOUGHT_CONTRAST
) -> PosteriorMap:
    """Return the map of sites whose states are known; errors as ``map_of``."""
    if not 1.0 < contrast < 100.0:
        raise ParameterError(f"contrast is {contrast}; it must be above 1 and below 100")
    felt, domain, background = sampled.felt, sampled.domain, sampled.background
    states, found, disagreement = sampled.states, sampled.found, sampled.disagreement
    probability = predictive_probability(states, background, felt.log_k)
    notes = [*sites.left_out, *_notes(felt, disagreement, probability)]
    step = _MM * raster
    x, y = domain.raster(step)
    if probability < LEAST_PASSED:
        wide = Background.of(felt.x, felt.y, felt.t, felt.noise, VARIANCE_LEVELS)
        model, (mean, sd, share, inclusions) = (
            "gaussian_process",
            map_of_process(wide, felt.log_k, felt.level, x, y),
        )
    else:
        model = "inclusions"
        mean, sd = (
            math.exp(felt.level) * each for each in surface_of(states, background, felt.log_k, x, y)
        )
        rows, count, _, _ = states.some(_SHARE_STATES)
        share = share_inside(rows[np.arange(rows.shape[1]) < count[:, None]], count.size, x, y)
        inclusions = [
            _inclusion(one, rows.size, mean, sd, x, y)
            for one, rows in zip(found, sampled.felt_by, strict=True)
        ]
    doubts = sampled.doubts if model == "inclusions" else []
    if len(felt.visits) < LEAST_SITES:
        inclusions, doubts = [], []
    notes += [_describe_doubt(one, felt) for one in doubts]
    unknown = ~domain.find_known(x, y)
    for layer in (mean, sd, share):
        layer[unknown] = np.nan
    hx, hy = domain.raster(max(step, _COARSEST))
    hidden = could_hide(states, background, felt.log_k, contrast, hx, hy)
    hidden[~domain.find_known(hx, hy)] = np.nan
    tissue = _tissue(states, background, felt)
    alike = np.abs(mean[~unknown] / tissue.stiffness - 1.0) < _MOST_ALIKE
    if alike.mean() < 0.5:
        notes.append(
            f"only {alike.mean():.0%} of the tissue is within {_MOST_ALIKE:.0%} of the background "
            f"of {tissue.stiffness:.0f} N/m: it is not certain which tissue is the background"
        )
    chains, kept = states.count.shape
    return PosteriorMap(
        tuple(inclusions),
        SurfaceFelt(x / _MM, y / _MM, mean, sd, share),
        CouldHide(hx / _MM, hy / _MM, hidden / _MM, contrast),
        tissue,
        Check(model, probability, disagreement, chains * kept, tuple(notes)),
        tuple(Again(one.x / _MM, one.y / _MM, one.probability) for one in doubts),
    )


def _notes(felt: FeltSites, disagreement: float, probability: float) -> list[str]:
    told = _contradictions(felt)
    places = len(felt.visits)
    if places < LEAST_SITES:
        given = f"{places} site{'s' if places > 1 else ''}"
        if places < felt.x.size:
            given = f"{felt.x.size} visits of {given}"
        told.append(
            f"{given} cannot tell an inclusion from a tilted background: give {LEAST_SITES} or "
            "more places"
        )
    if exact := int((felt.noise == 0.0).sum()):
        told.append(
            f"k_sd is 0 at {exact} of {felt.x.size} sites: taken as exact, but for the "
            f"{FORM_ERROR:.0%} by which an inclusion may have another form than the model's"
        )
    if disagreement > AGREEMENT:
        told.append(
            f"two halves of the chains differ by {disagreement:.2f} in the probability of an "
            f"inclusion after all moves: read probabilities with this error"
        )
    if probability < LEAST_PASSED:
        told.append(
            "inclusions on a smooth background do not explain the sites (posterior-predictive "
            f"probability {probability:.3f}): surface and inclusions are those of a Gaussian "
            "process, and what could hide is not reliable"
        )
    return told


def _contradictions(felt: FeltSites) -> list[str]:
    """Say where visits of one place differ by far more than their errors."""
    told = []
    for rows in felt.visits:
        low, high = (int(rows[extreme(felt.log_k[rows])]) for extreme in (np.argmin, np.argmax))
        apart = felt.log_k[high] - felt.log_k[low]
        if apart > math.log1p(_MOST_ALIKE) and apart > _SURE * math.hypot(*felt.noise[[low, high]]):
            k = np.exp(felt.level + felt.log_k[[low, high]])
            told.append(
                f"at x {felt.x[low]:.4g} mm, y {felt.y[low]:.4g} mm visits felt {k[0]:.4g} and "
                f"{k[1]:.4g} N/m, which their errors do not explain: did the tissue change, is the "
                "place wrong, or k_sd too small?"
            )
    return told


def _describe_doubt(one: SiteDoubt, felt: FeltSites) -> str:
    hangs = "is felt by one site" if one.alone else "is none if one site slipped"
    return (
        f"the inclusion at the site at x {felt.x[one.row]:.4g} mm, y {felt.y[one.row]:.4g} mm, "
        f"P = {one.probability:.2f}, {hangs}: palpate again, at x {one.x:.4g} mm, "
        f"y {one.y:.4g} mm"
    )


def _inclusion(
    one: FoundInclusion,
    felt_by: int,
    mean: FloatArray,
    sd: FloatArray,
    x: FloatArray,
    y: FloatArray,
) -> Inclusion:
    centre = one.centre
    row, column = (int(np.abs(axis - at).argmin()) for axis, at in ((y, centre[1]), (x, centre[0])))
    lines = boundaries(*one.some(MEMBERS)[:2], one.places)
    return Inclusion(
        float(centre[0]) / _MM,
        float(centre[1]) / _MM,
        one.covariance / _MM**2,
        one.probability,
        float(mean[row, column]),
        float(sd[row, column]),
        one.contrast,
        felt_by,
        lines[50] / _MM,
        lines[90] / _MM,
        lines[95] / _MM,
    )


def _tissue(states: States, background: Background, felt: FeltSites) -> TissueBackground:
    """Return the background: of each state the trend, less what its inclusions add; their median.

    A site alone may lie on an inclusion or not, and states differ by that: their spread is in the
    error, and the median follows what most of them say.
    """
    rows, count, level, kinds = states.some(_TREND_STATES)
    added = np.log(sums_at(rows, count, background.x, background.y))
    trends = [
        background.trend(int(used), erring, felt.log_k - one)
        for used, erring, one in zip(level, kinds, added, strict=True)
    ]
    levels = np.array([trend.level for trend in trends])
    middle = float(np.median(levels))
    within = np.array([trend.level_sd for trend in trends])
    deviation = math.sqrt(float((within**2 + (levels - middle) ** 2).mean()))
    tilt = _MM * np.median([trend.tilt for trend in trends], axis=0)
    stiffness = math.exp(felt.level + middle)
    return TissueBackground(
        stiffness,
        stiffness * deviation,
        (float(tilt[0]), float(tilt[1])),
        float(np.mean([background.levels.size(int(each)) for each in level])),
        math.expm1(float(np.median([trend.drift for trend in trends]))),
    )
