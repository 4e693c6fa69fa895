"""The noise of sites whose table does not tell it, from their scatter about their neighbours."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree
from scipy.stats import norm

from tissue_probe.errors import ParameterError
from tissue_probe.signals import FloatArray

#: A plane has three unknowns: as many neighbours again make its error smaller than the noise.
SITES_AROUND = 6


def scatter(x: FloatArray, y: FloatArray, k: FloatArray) -> float:
    """Return the standard deviation of the logarithm of stiffness, as neighbours tell it.

    Each site is compared with the plane through its nearest neighbours (after T. Gasser, L. Sroka,
    C. Jennen-Steinmetz, Biometrika 73 (1986), 625, in two dimensions). Of all sites the median
    counts: those at the rim of an inclusion are few.

    Parameters
    ----------
    x, y : array, shape (n,)
        Places [m].
    k : array, shape (n,)
        Stiffness there, positive [N/m].

    Raises
    ------
    ParameterError
        If there are too few sites.
    """
    if k.size <= SITES_AROUND:
        raise ParameterError(
            f"k_sd is not given, and {k.size} sites are too few to learn it from their scatter: "
            f"give it, or more than {SITES_AROUND} sites"
        )
    places, told = np.column_stack([x, y]), np.log(k)
    _, near = cKDTree(places).query(places, k=SITES_AROUND + 1)
    left = np.empty(k.size)
    for site, (own, *others) in enumerate(near):
        plane = np.column_stack([np.ones(SITES_AROUND), places[others] - places[own]])
        weights = np.linalg.pinv(plane)[0]
        error = told[own] - weights @ told[others]
        left[site] = abs(error) / np.sqrt(1.0 + weights @ weights)
    return float(np.median(left) / norm.ppf(0.75))
