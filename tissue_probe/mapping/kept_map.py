"""A map that outlives its process: what was found before a restart is taken up again.

Contents: when kept results are taken up, and when they are kept.

Announcements reach who joins late, with the time at which each was sent. If the first dwell that is
heard of stands in the file as sent at that very time, the file is of the scan that goes on.
"""

from __future__ import annotations

from collections.abc import Callable

from tissue_probe.mapping.fusion import Dwell, Estimate, MapBuilder
from tissue_probe.mapping.site_result import SiteResult
from tissue_probe.mapping.site_results import SiteResults
from tissue_probe.mapping.stiffness_map import StiffnessMapData
from tissue_probe.signals import PalpationSite


class KeptMap:
    """A ``MapBuilder`` that keeps the results of dwells that have ended.

    Parameters
    ----------
    results : SiteResults
        Where they are kept, and were before.
    tell : callable
        Told in a sentence where a file cannot be read or written; the map goes on without it.
    """

    def __init__(self, results: SiteResults, tell: Callable[[str], None]) -> None:
        self._builder = MapBuilder()
        self._results, self._tell = results, tell
        self._sent: dict[Dwell, int] = {}
        self._under_way: Dwell | None = None
        self._keeps = False
        self._has_looked = False
        self._known_until = -1  # sent no later than this: what is taken up tells it

    @property
    def revision(self) -> int:
        """Rises with every change of the map."""
        return self._builder.revision

    def map(self) -> StiffnessMapData:
        """Return the map as known now; ValueError as ``MapBuilder.map``."""
        return self._builder.map()

    def results(self, *, under_way: bool = True) -> list[SiteResult]:
        """Return what each dwell found, as ``MapBuilder.results``."""
        return self._builder.results(under_way=under_way)

    def announce(self, site: PalpationSite, sent: int) -> None:
        """Note where the probe is, as announced at the time ``sent`` [ns since the epoch].

        Raises
        ------
        ValueError
            If that is no place.
        """
        if site.is_visit and not self._has_looked:
            self._has_looked = True
            self._try(lambda: self._take_up(sent))
        if sent <= self._known_until:
            return  # announced anew, it would take the place of the dwell with its values
        begun = self._builder.announce(site)
        if self._under_way is not None and self._under_way.ended:
            self._keep(self._under_way)
            self._under_way = None
        if begun is not None:
            self._under_way, self._sent[begun] = begun, sent

    def add_one(self, estimator: str, status: int, estimate: Estimate, sequence: int = 0) -> None:
        """Take one estimate of a live run, as ``MapBuilder.add_one``."""
        dwell = self._builder.add_one(estimator, status, estimate, sequence)
        if dwell is not None and dwell.ended:
            self._keep(dwell)

    def fall_silent(self, lease: int) -> None:
        """Note that the scan shows no more that it is alive, as ``MapBuilder.fall_silent``."""
        self._builder.fall_silent(lease)

    def _take_up(self, sent: int) -> None:
        """Begin with the results before a restart, if they are of this scan; else with none."""
        stored = self._results.read_stored()
        if sent not in stored:
            stored = {}
        for dwell in stored.values():
            self._builder.take_up(dwell)
        self._known_until = max(stored, default=-1)
        self._results.begin(stored)
        self._keeps = True

    def _keep(self, dwell: Dwell) -> None:
        if self._keeps and dwell in self._sent:
            self._try(lambda: self._results.keep(self._sent[dwell], dwell))

    def _try(self, access: Callable[[], None]) -> None:
        try:
            access()
        except OSError as error:
            self._keeps = False
            self._tell(f"site results are not kept for a restart: {error}")
