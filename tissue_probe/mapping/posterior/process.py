"""The map where no inclusions explain the sites: a Gaussian process of log k.

Contents: the surface that the check falls back to, and the stiff places on it.

Mean and covariance are the background's (trend, drift, Matern 5/2, nugget) over a wide grid of
sizes and lengths, weighted by marginal likelihood (Rasmussen and Williams, Gaussian Processes for
Machine Learning, 2006, eq. 5.8).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label, maximum_filter
from scipy.special import ndtr

from tissue_probe.mapping.posterior.background import Background, Levels
from tissue_probe.mapping.posterior.boundary import contours
from tissue_probe.mapping.posterior.results import Inclusion
from tissue_probe.signals import FloatArray

_MM = 1e3
#: From what a plain map varies by to stiffness over orders of magnitude.
VARIANCE_LEVELS = Levels(
    np.geomspace(0.003, 1.0, 12),
    tuple((0.97, length, 0.25) for length in (3.0, 6.0, 12.0, 24.0)),
    usual=1.0,
)


@dataclass(frozen=True)
class Departure:
    """log k over a raster: mean, standard deviation, and how far the mean is off its median."""

    mean: FloatArray
    stddev: FloatArray
    above: FloatArray


def map_of_process(
    background: Background, log_k: FloatArray, level: float, x: FloatArray, y: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, list[Inclusion]]:
    """Return mean and sd of the stiffness [N/m], P(inclusion), and the places that stand out.

    Parameters
    ----------
    background : Background
        Of the sites, at ``VARIANCE_LEVELS``.
    log_k : array, shape (n,)
        log of the stiffness at the sites, less ``level``.
    x, y : array
        The raster [mm]; layers have shape (len y, len x).
    """
    found = _process(background, log_k, x, y)
    middle = np.exp(level + found.mean + 0.5 * found.stddev**2)
    sd = middle * np.sqrt(np.expm1(found.stddev**2))
    share, inclusions = np.zeros(found.mean.shape), []
    for sign in (1.0, -1.0):
        for row, column, inside in _standing_out(found, sign):
            share = np.maximum(share, inside)
            inclusions.append(_inclusion(found, middle, sd, row, column, inside, x, y))
    return middle, sd, share, sorted(inclusions, key=lambda one: -one.probability)


def _process(background: Background, log_k: FloatArray, x: FloatArray, y: FloatArray) -> Departure:
    quadratic = np.einsum("i,lij,j->l", log_k, background.precision, log_k)
    weight = background.log_weight - 0.5 * quadratic
    weight = np.exp(weight - weight.max())
    likely = np.flatnonzero(weight > 0.01)
    places = [each.ravel() for each in np.meshgrid(x, y)]
    mean, square = np.zeros(places[0].size), np.zeros(places[0].size)
    for level in likely:
        cross, own = background.cross(int(level), *places)
        explained = cross @ background.precision[level]
        middle = explained @ log_k
        variance = np.maximum(own - (explained * cross).sum(axis=1), 0.0)
        share = weight[level] / weight[likely].sum()
        mean += share * middle
        square += share * (variance + middle**2)
    stddev = np.sqrt(np.maximum(square - mean**2, 1e-12))
    shape = (y.size, x.size)
    mean = mean.reshape(shape)
    return Departure(mean, stddev.reshape(shape), mean - np.median(mean))


def _standing_out(found: Departure, sign: float) -> list[tuple[int, int, FloatArray]]:
    """Return row and column of each peak, and how probably places are above half of it."""
    above = sign * found.above
    peaks = (above == maximum_filter(above, size=9)) & (above > 2.0 * found.stddev)
    taken, regions = np.zeros(above.shape, dtype=bool), []
    for row, column in sorted(np.argwhere(peaks), key=lambda at: -above[tuple(at)]):
        if taken[row, column]:
            continue
        half = 0.5 * above[row, column]
        labels, _ = label(above > half)
        own = labels == labels[row, column]
        inside = ndtr((above - half) / found.stddev)
        inside[~own & (labels > 0)] = 0.0
        taken |= own
        regions.append((int(row), int(column), inside))
    return regions


def _inclusion(
    found: Departure,
    stiffness: FloatArray,
    sd: FloatArray,
    row: int,
    column: int,
    inside: FloatArray,
    x: FloatArray,
    y: FloatArray,
) -> Inclusion:
    weight = np.where(inside > 0.5, inside, 0.0)
    across, up = (
        float((weight.sum(axis=i) * axis).sum() / weight.sum()) for i, axis in ((0, x), (1, y))
    )
    width = weight.sum() * (x[1] - x[0]) ** 2 / np.pi
    certain = abs(found.above[row, column]) / found.stddev[row, column]
    lines = contours(x, y, inside, {50: 0.5, 90: 0.1, 95: 0.05})
    return Inclusion(
        across / _MM,
        up / _MM,
        np.eye(2) * width / certain**2 / _MM**2,
        float(2.0 * ndtr(certain) - 1.0),
        float(stiffness[row, column]),
        float(sd[row, column]),
        float(np.exp(found.above[row, column])),
        None,
        *(lines[percent] / _MM for percent in (50, 90, 95)),
    )
