"""How high the tissue's surface is between the sites.

Contents: height, and the normal that follows from it.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.mapping.sites import Sites
from tissue_probe.signals import FloatArray


def height_at(sites: Sites, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return z [m] at places: linear between the sites, that of the nearest beyond them."""
    return height_over(np.column_stack([sites.x, sites.y, sites.z]), x, y)


def height_over(points: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the third coordinate of a surface through points, shape (n, 3), as ``height_at``."""
    # Here, since it takes a second to import, and nodes import this module.
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator
    from scipy.spatial import QhullError

    places, height = points[:, :2], points[:, 2]
    nearest = NearestNDInterpolator(places, height)(x, y)
    try:
        between = LinearNDInterpolator(places, height)(x, y)
    except QhullError:  # on one line, or fewer than three
        return np.asarray(nearest)
    over: FloatArray = np.where(np.isfinite(between), between, nearest)
    return over
