"""How far from the sites the map says something.

What belongs here: rectangle, reach and raster. What does not: what is said (``posterior_map``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.moves import Region
from tissue_probe.signals import FloatArray

_MM = 1e3
#: A tip of 3 mm radius feels so far beyond its middle [mm].
TIP = 3.0
#: A single site has no spacing of its own [mm].
_LONE = 10.0
#: Of a spacing: the middle of four sites is 0.71 away from each.
_REACH = 0.75
#: Of a raster: an array of them takes 32 MB.
_MOST_CELLS = 4_000_000


@dataclass(frozen=True)
class Domain:
    """The places of which a map speaks [mm].

    Attributes
    ----------
    spacing : float
        Median distance of a site from its neighbour.
    reach : float
        A place farther from every site is unknown.
    box : array, shape (4,)
        Least and largest x, least and largest y.
    """

    spacing: float
    reach: float
    box: FloatArray
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
        places = np.unique(np.round(np.column_stack([x, y]), 3), axis=0)
        if len(places) > 1:
            nearest = cKDTree(places).query(places, k=2)[0][:, 1]
            spacing = float(np.median(nearest))
        else:
            spacing = _LONE
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
        return Domain(spacing, max(_REACH * spacing, TIP), box, places, hanging, within)

    @property
    def area(self) -> float:
        """The area within reach [mm^2]."""
        step = max(self.reach / 4.0, 1e-3)
        x, y = self.raster(step)
        return float(self.known(x, y).mean()) * (x[-1] - x[0]) * (y[-1] - y[0])

    def region(self, x: FloatArray, y: FloatArray) -> Region:
        """Return where the chains' sites x, y [mm] are, and where inclusions may be."""
        if self._within is None:
            return Region(x, y, self.reach, self.spacing, self.box, self.area)
        sides = self.box[1::2] - self.box[::2]
        return Region(x, y, np.inf, self.spacing, self.box, float(np.prod(sides)))

    def raster(self, step: float) -> tuple[FloatArray, FloatArray]:
        """Return x and y of a raster over the box, its cells about ``step`` [mm] wide.

        Raises
        ------
        ParameterError
            If it has too many cells.
        """
        sides = self.box[1] - self.box[0], self.box[3] - self.box[2]
        counts = [max(round(side / step), 2) + 1 for side in sides]
        if counts[0] * counts[1] > _MOST_CELLS:
            raise ParameterError(
                f"a raster of {step:g} mm has {counts[0]} x {counts[1]} cells here: make raster "
                "coarser"
            )
        x = self.box[0] + step * np.arange(counts[0])
        y = self.box[2] + step * np.arange(counts[1])
        return x, y

    def known(self, x: FloatArray, y: FloatArray) -> np.ndarray:
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
        return known
