"""The posterior map of a scan that goes on, computed beside the node's own work.

Contents: the thread, and when it computes.

A map takes some tenths of a second, and the first one of an installation compiles for half a
minute: meanwhile estimates have to be taken and verdicts published.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tissue_probe.errors import TissueProbeError
from tissue_probe.mapping.site_result import SiteResult, sites_of
from tissue_probe.mapping.sites import Sites
from tissue_probe.nodes.low_priority import lower_priority

if TYPE_CHECKING:
    from tissue_probe.mapping.lift import Lift
    from tissue_probe.mapping.posterior.results import PosteriorMap

#: How long the end of a node waits for a map; a compilation takes longer [s].
_PATIENCE = 1.0


class Posterior(NamedTuple):
    """A map, the results that it tells of, and the way from it into their frame."""

    results: tuple[SiteResult, ...]
    map: PosteriorMap
    lift: Lift


class LivePosterior:
    """Computes the map of the results that were given last.

    Parameters
    ----------
    outliers : float
        Share of sites that err far more than they state.
    """

    def __init__(self, outliers: float) -> None:
        self._outliers = outliers
        self._changed = threading.Condition()
        self._asked: tuple[SiteResult, ...] | None = None
        self._found: Posterior | str | None = None
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="posterior", daemon=True)
        self._thread.start()

    def ask(self, results: Sequence[SiteResult]) -> None:
        """Have the map of these results computed next, and of none that were given before."""
        with self._changed:
            self._asked = tuple(results)
            self._changed.notify()

    def take(self) -> Posterior | str | None:
        """Return a map that was not returned before, why there is none, or nothing new."""
        with self._changed:
            found, self._found = self._found, None
            return found

    def close(self) -> None:
        """End, after the map that is being computed if that is soon done."""
        with self._changed:
            self._ended = True
            self._changed.notify()
        self._thread.join(_PATIENCE)

    def _run(self) -> None:
        lower_priority(threading.get_native_id())  # the map waits for measurements
        # Here, since it takes seconds to import: the node is there before.
        from tissue_probe.mapping.chart import Chart
        from tissue_probe.mapping.posterior.posterior_map import map_of

        map_of(_few())  # has all compiled, or loaded, before the first site is done
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._ended or self._asked is not None)
                if self._ended or self._asked is None:
                    return
                results, self._asked = self._asked, None
            try:
                chart = Chart.of(sites_of(results))
                told = map_of(chart.sites, outliers=self._outliers)
                if chart.note:
                    notes = (*told.check.notes, chart.note)
                    told = replace(told, check=replace(told.check, notes=notes))
                found: Posterior | str = Posterior(results, told, chart.places)
            except TissueProbeError as error:
                found = str(error)
            with self._changed:
                self._found = found


def _few() -> Sites:
    x, y = (each.ravel() for each in np.meshgrid([0.0, 0.01], [0.0, 0.01]))
    return Sites(x, y, np.zeros(4), None, np.array([1.0, 1.0, 1.0, 3.0]), np.full(4, 0.01))
