"""The surface that an exploration comes to: a plane that is given, bent to where contact was felt.

Contents: height and normal at the next site.

The offset from the plane is a Gaussian process (C. E. Rasmussen and C. K. I. Williams, "Gaussian
Processes for Machine Learning", 2006, eq. 2.23; ``kernel``, and a plane, eq. 2.39): any
number of felt heights will do, without any it is the plane, and the slope follows from the heights.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tissue_probe.mapping.kernel import correlate_places, slope
from tissue_probe.signals import FloatArray

#: A felt height is wrong by so much of the distance by which the surface is off the plane [-]:
#: contact is searched in steps of a fifth of the depth, or finer ones, and is felt within a step.
WRONG = 0.1


class ExploredSurface:
    """The surface over an area.

    Parameters
    ----------
    corners : array, shape (n, 3)
        Corners of the area [m]; the plane is the one through them by least squares.
    """

    def __init__(self, corners: FloatArray) -> None:
        self._middle = corners.mean(axis=0)
        off = corners - self._middle
        self._slope = np.linalg.lstsq(off[:, :2], off[:, 2], rcond=None)[0]
        # A surface bends over the extent of the area, not within a part of it.
        self._bends_over = float(np.hypot(*np.ptp(corners[:, :2], axis=0))) / 2.0

    def at(
        self, place: tuple[float, float], felt: Sequence[tuple[float, float, float]]
    ) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Return the point of the surface at a place and the outward normal there, of length 1.

        Parameters
        ----------
        place : tuple
            x and y [m].
        felt : sequence of tuple
            Points [m] where the surface was found.
        """
        here = np.array(place)
        offset, bend = self._offset(here, np.reshape(felt, (-1, 3)))
        height = self._plane(here) + offset
        normal = np.array([*-(self._slope + bend), 1.0])
        normal /= np.linalg.norm(normal)
        x, y, z = map(float, normal)
        return (*place, float(height)), (x, y, z)

    def _plane(self, places: FloatArray) -> FloatArray:
        height: FloatArray = self._middle[2] + (places - self._middle[:2]) @ self._slope
        return height

    def _offset(self, here: FloatArray, felt: FloatArray) -> tuple[float, FloatArray]:
        """Return the height above the plane [m], and its slope along x and y."""
        places, offsets = felt[:, :2], felt[:, 2] - self._plane(felt[:, :2])
        between, _ = self._correlate_offsets(places[:, None], places)
        weights = np.linalg.solve(between + WRONG**2 * np.eye(len(felt)), offsets)
        alike, slopes = self._correlate_offsets(here, places)
        return float(alike @ weights), slopes.T @ weights

    def _correlate_offsets(
        self, here: FloatArray, there: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return how alike the offsets at places [m] are, and how that changes with ``here``."""
        here, there = ((each - self._middle[:2]) / self._bends_over for each in (here, there))
        off = here - there
        bent = correlate_places(np.linalg.norm(off, axis=-1))
        # The plane may be given as wrong, in height and in tilt, as the surface is bent.
        return bent + 1.0 + (here * there).sum(axis=-1), (slope(off) + there) / self._bends_over
