"""Where to palpate again after a scan: beside sites on which an inclusion hangs.

Contents: the choice of these places.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.mapping.chart import Chart
from tissue_probe.mapping.posterior.posterior_sample import Sampled
from tissue_probe.mapping.sites import Sites

_MM = 1e3


def places_again(sites: Sites, outliers: float, most: int) -> list[tuple[float, float, float]]:
    """Return at most so many places in the sites' frame [m], of the surest inclusion first.

    Parameters
    ----------
    sites : Sites
        All that was felt.
    outliers : float
        Share of sites that err far more than they state.
    most : int
        How many places at most.

    Raises
    ------
    ParameterError
        If no site has a value, or their surface folds over.
    """
    chart = Chart.of(sites)
    doubts = Sampled.of(chart.sites, outliers=outliers).doubts[:most]
    if not doubts:
        return []
    x, y = np.array([(one.x, one.y) for one in doubts]).T / _MM
    return [(float(a), float(b), float(c)) for a, b, c in chart.places(x, y)]
