"""A polygon over the tissue: where something is sought, or where no probe may go.

Contents: corners, checked, and what is inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.errors import ParameterError
from tissue_probe.signals import FloatArray

#: Nearer to an edge than this is on it [m]: a thousandth of what a robot repeats.
_ON_EDGE = 1e-8


@dataclass(frozen=True)
class Polygon:
    """Corners in their order; the last is joined to the first.

    Attributes
    ----------
    corners : array, shape (n, 2)
        x and y [m].

    Raises
    ------
    ParameterError
        If there are fewer than three corners, one is not finite, sides cross, or nothing is inside.
    """

    corners: FloatArray

    def __post_init__(self) -> None:
        if self.corners.ndim != 2 or self.corners.shape[1] != 2 or len(self.corners) < 3:
            raise ParameterError(
                f"a polygon has shape {self.corners.shape}: give x and y of three corners or more"
            )
        if not np.isfinite(self.corners).all():
            raise ParameterError("a corner of a polygon is not finite: give numbers in m")
        if crossed := self._find_crossing():
            one, other = crossed
            raise ParameterError(
                f"the sides of a polygon cross: that from corner {one + 1} on and that from corner "
                f"{other + 1} on; give the corners in their order around the area"
            )
        if not self.area > _ON_EDGE * float(np.ptp(self.corners, axis=0).max()):
            raise ParameterError("the corners of a polygon lie on one line: nothing is inside")

    def _find_crossing(self) -> tuple[int, int] | None:
        """Return two sides that cross, each by the number of its first corner; None if none do."""
        starts, ends = self.corners, np.roll(self.corners, -1, axis=0)
        for side, (start, end) in enumerate(zip(starts, ends, strict=True)):
            apart = _find_side(start, end, starts) * _find_side(start, end, ends) < 0.0
            apart &= _find_side(starts, ends, start) * _find_side(starts, ends, end) < 0.0
            if apart.any():
                return side, int(np.flatnonzero(apart)[0])
        return None

    @property
    def area(self) -> float:
        """The area inside [m^2]."""
        # From a corner on: far from the origin, differences of large products would be lost.
        (ax, ay), (bx, by) = (c.T for c in (self.corners, np.roll(self.corners, -1, axis=0)))
        ax, bx, ay, by = ax - ax[0], bx - ax[0], ay - ay[0], by - ay[0]
        return 0.5 * abs(float((ax * by - bx * ay).sum()))

    def contains(self, x: FloatArray, y: FloatArray) -> np.ndarray:
        """Return whether each place [m] is inside, or on the edge: by the crossings of a ray."""
        inside = np.zeros(np.shape(x), dtype=bool)
        on_edge = np.zeros(np.shape(x), dtype=bool)
        for a, b in zip(self.corners, np.roll(self.corners, -1, axis=0), strict=True):
            (ax, ay), (bx, by) = a, b
            off = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
            if ay != by:
                inside ^= ((ay > y) != (by > y)) & ((off > 0.0) == (by > ay))
            between = (x - ax) * (x - bx) + (y - ay) * (y - by) <= 0.0
            on_edge |= between & (np.abs(off) <= _ON_EDGE * np.hypot(bx - ax, by - ay))
        return inside | on_edge


def _find_side(start: FloatArray, end: FloatArray, place: FloatArray) -> FloatArray:
    """Return which side of a line places are on: positive to its left, 0 on it."""
    (ax, ay), (bx, by), (x, y) = start.T, end.T, place.T
    side: FloatArray = np.sign((bx - ax) * (y - ay) - (by - ay) * (x - ax))
    return side
