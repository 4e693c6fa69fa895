"""Where the probe palpated: the scans that were announced, and the grid through their sites.

Contents: which sites make the grid of a map.

The rule is one for a map that grows while a scan goes on and for the map of a recorded scan, so
that both are the same map.
"""

from __future__ import annotations

import math

import numpy as np

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.grid import Grid
from tissue_probe.signals import PalpationSite, Phase

#: x and y of a site on the tissue [m], as a whole number of nanometres tells them.
Place = tuple[float, float]
#: The height of the tissue at each place [m].
_Heights = dict[Place, float]


def place_of(site: PalpationSite) -> Place:
    """Return where a site is; ValueError if its position is not finite."""
    if not all(map(math.isfinite, site.position)):
        raise ParameterError(
            f"site {site.site} is announced at {site.position} m, which is no place"
        )
    x, y, _ = (float(value) for value in np.round(site.position, 9))
    return x, y


class PalpatedSites:
    """The sites of every scan that was announced, in the order of the scans.

    A scan numbers its sites upwards: a number that does not rise begins another scan.

    Attributes
    ----------
    count : int
        How many sites are known, all scans together; the grid may change only when it rises.
    """

    def __init__(self) -> None:
        self.count = 0
        self._scans: list[_Heights] = []
        self._last = -1
        self._awaited: Place | None = None
        self._cells: tuple[int, Grid, dict[Place, tuple[int, int]]] | None = None

    def add(self, site: PalpationSite) -> None:
        """Note an announcement of any phase; ValueError if its position is not finite."""
        place = place_of(site)
        if site.phase != Phase.APPROACH and site.site == self._last and self._awaited is not None:
            # Where contact was searched, the surface is known from the dwell on.
            height = self._scans[-1].pop(self._awaited)
            self._scans[-1][place] = site.position[2]
            self.count += (place, site.position[2]) != (self._awaited, height)
            self._awaited = None
            return
        here = bool(self._scans) and place in self._scans[-1]
        if site.site < self._last or (site.site == self._last and not here) or not self._scans:
            self._scans.append({})
            here = False
        self._last = site.site
        if not here:
            self._scans[-1][place] = site.position[2]
            self.count += 1
        self._awaited = place if site.phase == Phase.APPROACH and not here else None

    def cells(self) -> tuple[Grid, dict[Place, tuple[int, int]]]:
        """Return the grid of the map, and row and column of each site on it.

        It is the square grid through the sites of the last scan, and of those before on it. An
        earlier scan is on it if the sites of both lie on one square grid that is no finer than one
        of the two scans by itself: a part of the sites palpated again, or a finer grid between the
        sites of a coarse one. Where a scan is on another grid, it and all scans before it are no
        part of the map.

        Raises
        ------
        ValueError
            If there is no site, or those of the last scan lie on no square grid.
        """
        if self._cells is None or self._cells[0] != self.count:
            grid, places = self._on_one_grid()
            self._cells = self.count, grid, {place: grid.nearest(place) for place in places}
        return self._cells[1:]

    def _on_one_grid(self) -> tuple[Grid, _Heights]:
        places = dict(self._scans[-1]) if self._scans else {}
        for earlier in reversed(self._scans[:-1]):
            if not _are_one_grid(places, earlier):
                break
            places = {**earlier, **places}
        return _through(places), places


def _are_one_grid(places: _Heights, earlier: _Heights) -> bool:
    """Whether there is a square grid through both that is no finer than one of them by itself."""
    joined, *alone = (_grid(each) for each in ({**earlier, **places}, places, earlier))
    if joined is None:
        return False
    # A single site has no spacing of its own.
    spacings = [grid.spacing for grid in alone if grid is not None and len(grid) > 1]
    return not spacings or any(math.isclose(joined.spacing, s, rel_tol=1e-6) for s in spacings)


def _grid(places: _Heights) -> Grid | None:
    try:
        return _through(places)
    except ValueError:
        return None


def _through(places: _Heights) -> Grid:
    return Grid.through([(x, y, height) for (x, y), height in places.items()])
