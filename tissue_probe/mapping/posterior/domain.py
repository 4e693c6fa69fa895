"""Where inclusions may lie, and how far from the sites the map says something.

Contents: rectangle, hull, reach and raster.

The middle of an inclusion may lie anywhere in the sites' hull. Scattered sites leave holes: were a
middle bound to lie near a site, one in a hole had no chance, and the sites around the hole would be
explained by an inclusion beside the true one. The surface is told near sites alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.moves import SitesRegion
from tissue_probe.signals import FloatArray

_MM = 1e3
#: A tip of 3 mm radius feels so far beyond its middle [mm].
TIP = 3.0
#: A single site has no spacing of its own [mm].
_LONE = 10.0
#: Of a spacing: the middle of four sites is 0.71 away from each.
_REACH = 0.75
#: Places are told apart by so many digits of a mm.
_DIGITS = 3
#: Of a raster: an array of them takes 32 MB.
_MOST_CELLS = 4_000_000


@dataclass(frozen=True)
class Domain:
    """The places of which a map speaks [mm].

    Attributes
    ----------
    spacing : float
        Of a raster of as many places over the same hull.
    reach : float
        A place farther from every site is unknown.
    box : array, shape (4,)
        Least and largest x, least and largest y.
    """

    spacing: float
    reach: float
    box: FloatArray
    _hull: ConvexHull
    _sites: FloatArray
    _hanging: FloatArray
    _within: Polygon | None

    @staticmethod
    def of(
        x: FloatArray, y: FloatArray, hanging: FloatArray, within: Polygon | None = None
    ) -> Domain:
        """Return the domain of sites at x, y [mm]; repeats at one place are one.

        ``hanging``, shape (m, 2), are sites without contact [mm]: they are in the box, and what is
        nearest to them is unknown. ``within`` is an area that is spoken of, too, however far from
        the sites.

        Raises
        ------
        ParameterError
            If the box has too many cells as wide as a tip's radius.
        """
        places: FloatArray = np.unique(np.column_stack([x, y]).round(_DIGITS), axis=0)
        spacing = _measure_spacing(places)
        beyond = min(spacing / 2.0, TIP)
        if within is not None:
            beyond = TIP
        corners = _MM * within.corners if within is not None else np.zeros((0, 2))
        palpated = np.concatenate([places, hanging, corners])
        low, high = palpated.min(axis=0) - beyond, palpated.max(axis=0) + beyond
        if np.prod((high - low) / TIP) > _MOST_CELLS:
            sides = " x ".join(f"{side:.3g}" for side in (high - low) / _MM)
            raise ParameterError(
                f"sites and area span {sides} m, too far for a map of what a tip of "
                f"{TIP:g} mm radius feels: give x and y in m; are these mm?"
            )
        box = np.array([low[0], high[0], low[1], high[1]])
        hull = _hull(np.concatenate([places, corners]), beyond)
        return Domain(spacing, max(_REACH * spacing, TIP), box, hull, places, hanging, within)

    def region(self, x: FloatArray, y: FloatArray) -> SitesRegion:
        """Return where the chains' sites x, y [mm] are, and where inclusions may be."""
        return SitesRegion(x, y, self.spacing, self.box, self._hull.equations, self._hull.volume)

    def raster(self, step: float) -> tuple[FloatArray, FloatArray]:
        """Return x and y of a raster over the box, its cells about ``step`` [mm] wide.

        Raises
        ------
        ParameterError
            If the step is not above 0 and finite, or the raster has too many cells.
        """
        if not (math.isfinite(step) and step > 0.0):
            raise ParameterError(f"raster is {step / _MM:g} m; it must be positive and finite")
        sides = self.box[1] - self.box[0], self.box[3] - self.box[2]
        # Quotients of floats: they may be beyond every integer.
        across, along = (max(float(side) / step, 2.0) for side in sides)
        if not (across + 1.0) * (along + 1.0) <= _MOST_CELLS:
            raise ParameterError(
                f"a raster of {step:g} mm has {across:.4g} x {along:.4g} cells over "
                f"{sides[0] / _MM:.3g} x {sides[1] / _MM:.3g} m: make raster coarser, or give x "
                "and y in m if these are mm"
            )
        counts = round(across) + 1, round(along) + 1
        x = self.box[0] + step * np.arange(counts[0])
        y = self.box[2] + step * np.arange(counts[1])
        return x, y

    def find_known(self, x: FloatArray, y: FloatArray) -> np.ndarray:
        """Return whether each place of a raster is spoken of, shape (len y, len x)."""
        columns, rows = np.meshgrid(x, y)
        return self.speaks_of(columns.ravel(), rows.ravel()).reshape(rows.shape)

    def speaks_of(self, x: FloatArray, y: FloatArray) -> np.ndarray:
        """Return whether each place [mm] is spoken of."""
        places = np.column_stack([x, y])
        nearest = cKDTree(self._sites).query(places)[0]
        known = nearest <= self.reach
        if self._within is not None:
            known |= self._within.contains(x / _MM, y / _MM)
        if len(self._hanging):
            known &= nearest < cKDTree(self._hanging).query(places)[0]
        found: np.ndarray = known
        return found


def _hull(places: FloatArray, beyond: float) -> ConvexHull:
    """Return the hull of the squares around places that reach so far beyond them.

    A square is what a raster's site stands for, and places on one line have a hull, too.

    Raises
    ------
    ParameterError
        If places are so far apart that the squares are lost in rounding.
    """
    corners = beyond * np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]])
    try:
        return ConvexHull((places[:, None] + corners).reshape(-1, 2))
    except QhullError:
        apart = float(np.ptp(places, axis=0).max()) / _MM
        raise ParameterError(
            f"sites lie {apart:.3g} m apart, too far for a map of one surface: are x and y in "
            "metres?"
        ) from None


def _measure_spacing(places: FloatArray) -> float:
    """Return the spacing of a raster of as many places, whose hull has the same area and perimeter.

    The cells of a raster of n places, s wide, end half a spacing beyond its hull of area A and
    perimeter P: A + P s / 2 + s^2 = n s^2. On a line s is the mean distance of neighbours.
    """
    others = len(places) - 1
    if not others:
        return _LONE
    hull = _hull(places, 0.1**_DIGITS / 2.0)
    quarter, area = hull.area / 4.0, hull.volume  # in a plane SciPy's area is the perimeter
    return round(float(quarter + np.sqrt(quarter**2 + others * area)) / others, _DIGITS)
