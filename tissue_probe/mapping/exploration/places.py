"""Places spread evenly over an area.

Contents: the grid within a polygon.
"""

from __future__ import annotations

import math

import numpy as np

from tissue_probe.mapping.polygon import Polygon
from tissue_probe.signals import FloatArray

#: Places of the rectangle for one inside, at most.
_SPARSE = 100.0


def spread(within: Polygon, most: int) -> tuple[FloatArray, FloatArray, float]:
    """Return x and y of about so many places within an area, and their distance; all in m.

    They go from edge to edge: an inclusion at the edge is found by a site on it.
    """
    low, high = within.corners.min(axis=0), within.corners.max(axis=0)
    # Of a sliver across its rectangle few places in a hundred would be inside.
    step = math.sqrt(max(within.area, float(np.prod(high - low)) / _SPARSE) / most)
    counts = [max(int(side / step + 0.5), 1) + 1 for side in high - low]
    along = [np.linspace(a, b, n) for a, b, n in zip(low, high, counts, strict=True)]
    x, y = (each.ravel() for each in np.meshgrid(*along))
    inside = within.contains(x, y)
    if not inside.any():
        # A sliver between the rows: its corners are inside whatever it is.
        x, y = within.corners.T
        return x, y, step
    return x[inside], y[inside], step
