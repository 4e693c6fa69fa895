"""The first sites of an exploration: spread over the area, before anything is known of it.

Contents: their places and their order.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.cluster.vq import kmeans2

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.exploration.places import spread
from tissue_probe.mapping.polygon import Polygon

#: Six coefficients of a trend and its noise are told by no fewer; the states do better with sites
#: that they choose than with more of these.
FIRST_SITES = 9
_PLACES_TRIED = 2000


def first_sites(
    within: Polygon, no_go: Sequence[Polygon] = (), count: int = FIRST_SITES
) -> list[tuple[float, float]]:
    """Return places [m] from each of which a like part of the area is nearest, on a short way.

    Raises
    ------
    ParameterError
        If no place of the area is left.
    """
    x, y, _ = spread(within, _PLACES_TRIED)
    allowed = np.ones(x.size, dtype=bool)
    for zone in no_go:
        allowed &= ~zone.contains(x, y)
    places = np.column_stack([x, y])[allowed]
    if not len(places):
        raise ParameterError("no place is left for a site: all is outside, or no-go")
    middles, _ = kmeans2(places, min(count, len(places)), minit="++", seed=1)
    # A middle may be in a notch of the area, or in a zone.
    nearest = [int(np.hypot(*(places - middle).T).argmin()) for middle in middles]
    left = [(float(places[i, 0]), float(places[i, 1])) for i in dict.fromkeys(nearest)]
    way = [min(left)]
    left.remove(way[0])
    while left:
        here = np.array(way[-1])
        way.append(min(left, key=lambda place: float(np.hypot(*(np.array(place) - here)))))
        left.remove(way[-1])
    return way
