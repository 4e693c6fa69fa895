"""How alike two places of one surface are: the Matern kernel of order 5/2.

C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning, 2006, eq. 4.17.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.signals import FloatArray


def correlate_places(distance: FloatArray) -> FloatArray:
    """Return the correlation of places so many lengths of the kernel apart, of any shape."""
    r = np.sqrt(5.0) * distance
    return np.asarray((1.0 + r + r**2 / 3.0) * np.exp(-r))


def slope(off: FloatArray) -> FloatArray:
    """Return how the correlation changes with a place, shape (..., d).

    Parameters
    ----------
    off : array, shape (..., d)
        That place less the other, in lengths of the kernel.
    """
    r = np.sqrt(5.0) * np.linalg.norm(off, axis=-1)
    return np.asarray(-5.0 / 3.0 * ((1.0 + r) * np.exp(-r))[..., None] * off)
