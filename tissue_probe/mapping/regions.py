"""Stiff regions: where a map says that something harder lies in the tissue.

What belongs here: finding regions, and holding them against known nodules. What does not: the
interpolation they are found on (``surface``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.stiffness_map import StiffnessMapData
from tissue_probe.mapping.surface import Surface, interpolate
from tissue_probe.signals import FloatArray

CONTRAST = 1.3  # least stiffness over background; tumours reach 2-3 at the surface, less in depth
SIGNIFICANCE = 3.0  # least distance from the background in standard deviations

_NORMAL_HALF = 1.349  # width of the middle half of a normal distribution over its stddev


@dataclass(frozen=True)
class Background:
    """The tissue that is not nodule.

    The median and the width of the half of the cells that lie closest together in stiffness
    (Rousseeuw and Leroy 1987, section 4.2). Nodules spread into their neighbour cells and make
    them all stiffer, never softer; that draws the median and the MAD of all cells upwards.

    Attributes
    ----------
    stiffness, stddev : float
        [N/m]
    """

    stiffness: float
    stddev: float

    @staticmethod
    def of(stiffness: FloatArray) -> Background:
        """Estimate from the cells' stiffness [N/m]; NaN is left out, nodules fill under half.

        Raises
        ------
        ValueError
            If no cell has a value.
        """
        measured = np.sort(stiffness[np.isfinite(stiffness)])
        if measured.size == 0:
            raise ParameterError("no cell of the map has been measured; there is no background")
        half = measured.size // 2 + 1
        width = measured[half - 1 :] - measured[: measured.size - half + 1]
        densest = np.argmin(width)
        median = np.median(measured[densest : densest + half])
        return Background(float(median), float(width[densest]) / _NORMAL_HALF)

    @property
    def threshold(self) -> float:
        """Stiffness above which tissue is no background [N/m]."""
        return max(CONTRAST * self.stiffness, self.stiffness + SIGNIFICANCE * self.stddev)


@dataclass(frozen=True)
class Region:
    """One connected region that is stiffer than the background.

    Attributes
    ----------
    x, y : float
        Centre [m]: the centroid, weighted by the stiffness above the threshold.
    stiffness, stiffness_stddev : float
        The highest stiffness in the region and its standard deviation [N/m].
    ratio : float
        That stiffness over the background's [-].
    area : float
        Area above the threshold [m^2].
    """

    x: float
    y: float
    stiffness: float
    stiffness_stddev: float
    ratio: float
    area: float

    @property
    def diameter(self) -> float:
        """Diameter of the circle of the same area [m]."""
        return 2.0 * math.sqrt(self.area / math.pi)


def find_regions(stiffness_map: StiffnessMapData) -> list[Region]:
    """Find the stiff regions of a map, the stiffest first.

    A region is a connected part of the interpolated surface above the background's threshold, in
    which at least one point differs from the background by ``SIGNIFICANCE`` times the standard
    deviations of both, taken together. Nodules nearer to each other than about two spacings may
    appear as one region. A map without any measured cell has no regions.
    """
    if not stiffness_map.measured.any():
        return []
    background = Background.of(stiffness_map.stiffness)
    surface = interpolate(
        stiffness_map.grid, stiffness_map.stiffness, stiffness_map.stiffness_stddev
    )
    labels, count = label(surface.mean > background.threshold)
    excess = surface.mean - background.stiffness
    significant = excess > SIGNIFICANCE * np.hypot(surface.stddev, background.stddev)
    regions = [
        _region(surface, labels == number, background)
        for number in range(1, count + 1)
        if significant[labels == number].any()
    ]
    return sorted(regions, key=lambda region: -region.stiffness)


def _region(surface: Surface, inside: np.ndarray, background: Background) -> Region:
    row, column = np.nonzero(inside)
    stiffness = surface.mean[inside]
    weight = stiffness - background.threshold
    peak = np.argmax(stiffness)
    return Region(
        x=float(np.average(surface.x[column], weights=weight)),
        y=float(np.average(surface.y[row], weights=weight)),
        stiffness=float(stiffness[peak]),
        stiffness_stddev=float(surface.stddev[inside][peak]),
        ratio=float(stiffness[peak]) / background.stiffness,
        area=row.size * surface.step**2,
    )


@dataclass(frozen=True)
class Match:
    """Found regions held against true positions, all by their index in what was given.

    Attributes
    ----------
    pairs : tuple of (int, int, float)
        Index of the found region, index of the true position, and their distance [m].
    missed : tuple of int
        True positions without a found region.
    false : tuple of int
        Found regions without a true position.
    """

    pairs: tuple[tuple[int, int, float], ...]
    missed: tuple[int, ...]
    false: tuple[int, ...]


def match(
    found: Sequence[Region], true_positions: Sequence[tuple[float, float]], tolerance: float
) -> Match:
    """Pair found regions with true positions one to one.

    Of all pairings within the tolerance, one with the most pairs is taken, and among these the one
    with the smallest sum of distances.

    Parameters
    ----------
    found : sequence of Region
        As ``find_regions`` gives them.
    true_positions : sequence of (float, float)
        x and y of each true nodule [m].
    tolerance : float
        Largest distance of a pair [m].
    """
    centres = np.array([(region.x, region.y) for region in found]).reshape(-1, 2)
    distance = cdist(centres, np.array(true_positions, dtype=float).reshape(-1, 2))
    # One pair too far apart costs more than all pairs within the tolerance together.
    too_far = tolerance * (min(distance.shape) + 1) + 1.0
    rows, columns = linear_sum_assignment(np.where(distance <= tolerance, distance, too_far))
    pairs = tuple(
        (int(row), int(column), float(distance[row, column]))
        for row, column in zip(rows, columns, strict=True)
        if distance[row, column] <= tolerance
    )
    return Match(
        pairs=pairs,
        missed=tuple(sorted(set(range(len(true_positions))) - {pair[1] for pair in pairs})),
        false=tuple(sorted(set(range(len(found))) - {pair[0] for pair in pairs})),
    )
