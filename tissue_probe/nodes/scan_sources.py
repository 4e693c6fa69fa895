"""Where the sites of a scan come from: a grid, or a list that the user gives.

Contents: which site comes next, and the message on the visited ones.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.site_result import sites_of
from tissue_probe.nodes.decision_process import DecisionProcess
from tissue_probe.nodes.site_outcomes import SiteOutcomes
from tissue_probe.signals import UP, sound_normal, sound_position
from tissue_probe_msgs import msg
from tissue_probe_msgs.action import ScanGrid, ScanSites

if TYPE_CHECKING:
    from tissue_probe.mapping.exploration.choice import Purpose

#: Longest stay at a site [s].
LONGEST_DWELL = 3600.0
#: Longest wait for a decision: the first one of an installation compiles for half a minute [s].
LONGEST_DECISION = 300.0
#: Of results that are not told, a decision is made without [s].
UNTOLD = 2.0
#: So many sites are named in a message; all are in the result.
NAMED = 10
#: As many as a grid may have.
MOST_SITES = 10_000

#: Waits until a condition holds, at most so long [s], while the scan may be stopped; returns
#: whether it holds.
Wait = Callable[[Callable[[], bool], float], bool]


class Site(NamedTuple):
    """A site: its number in the scan, its place on the tissue [m], the outward normal there."""

    number: int
    position: tuple[float, float, float]
    normal: tuple[float, float, float] = UP


class Choosing(NamedTuple):
    """How sites are chosen on the way.

    ``purpose`` is that of an exploration's sites, ``outliers`` the share of sites that err,
    ``again`` how many of the given sites are palpated again at most, as a share.
    """

    purpose: Purpose = "both"
    outliers: float = 0.0
    again: float = 0.0


class SourceKind(Protocol):
    """A class of ``Source``, made of a goal and of what is known of sites."""

    ACTION: Any
    NAME: str

    def __call__(self, goal: Any, outcomes: SiteOutcomes, /) -> Source:
        """Make the sites of a goal; ValueError where it is refused."""


class Source(ABC):
    """The sites of one scan, which one action asks for. ValueError where its goal is refused.

    Attributes
    ----------
    dwell_time : float
        Longest stay at a site [s].
    visited : list of Site
        Those that were palpated, in their order.
    untouched : list of Site
        Those where no surface was found.
    begins : list of int
        When each dwell began [ns since the epoch].
    choosing : Choosing
        How sites are chosen that are not given.
    """

    #: An action's type, which ROS generates without annotations.
    ACTION: ClassVar[Any]
    NAME: ClassVar[str]

    def __init__(self, dwell_time: float) -> None:
        if not 0.0 < dwell_time <= LONGEST_DWELL:
            raise ValueError(f"dwell_time is {dwell_time} s; give a time up to {LONGEST_DWELL:g} s")
        self.dwell_time = dwell_time
        self.visited: list[Site] = []
        self.untouched: list[Site] = []
        self.begins: list[int] = []
        self.choosing = Choosing()

    @abstractmethod
    def prepare(self, wait: Wait) -> None:
        """Get ready, while nobody moves yet: imports and compilation may hold up this process."""

    @abstractmethod
    def next(self, wait: Wait) -> Site | None:
        """Return the site to palpate next; None where there is none."""

    def dwelling(self, site: Site, begin: int) -> None:
        """Note that a dwell begins [ns since the epoch]."""
        self.begins.append(begin)

    def palpated(self, site: Site) -> None:
        """Note that a site was palpated."""
        self.visited.append(site)

    def not_reached(self, site: Site) -> bool:
        """Note that the robot did not reach a site; return whether there is another instead."""
        return False

    def not_touched(self, site: Site) -> bool:
        """Note that no surface was found at a site; return whether the scan goes on."""
        self.untouched.append(site)
        return True

    @abstractmethod
    def is_judged(self) -> bool:
        """Whether nothing more is to be expected of the sites that were palpated."""

    @abstractmethod
    def ended(self) -> str:
        """Say how the scan ended where nothing stopped it."""

    @abstractmethod
    def so_far(self) -> str:
        """Say how far the scan came where something stopped it; nothing if it was over."""

    @abstractmethod
    def feedback(self, announced: msg.PalpationSite) -> Any:
        """Return the feedback with an announcement."""

    @abstractmethod
    def result(self, how: str) -> Any:
        """Return the result; ``how`` says how the scan ended."""


class ListedSites(Source):
    """Sites that are known when the scan begins; judged by their visits in this scan."""

    def __init__(self, sites: Sequence[Site], dwell_time: float, outcomes: SiteOutcomes) -> None:
        super().__init__(dwell_time)
        self._left, self._total = list(sites), len(sites)
        self._outcomes = outcomes

    def prepare(self, wait: Wait) -> None:
        """Do nothing: all is known."""

    def next(self, wait: Wait) -> Site | None:
        """Return the next of the list."""
        return self._left.pop(0) if self._left else None

    def ended(self) -> str:
        """Say that all are palpated, or where no surface was found."""
        if self.untouched:
            places = list_sites([site.number for site in self.untouched])
            count = len(self.visited)
            return f"{count} of {self._total} sites are palpated; no contact was found at {places}"
        return f"all {self._total} sites are palpated"

    def so_far(self) -> str:
        """Say how many are palpated."""
        if len(self.visited) + len(self.untouched) == self._total:
            return ""
        return f"{len(self.visited)} of {self._total} sites are palpated"

    def feedback(self, announced: msg.PalpationSite) -> Any:
        """Say how many of the sites are palpated."""
        return self.ACTION.Feedback(
            sites_visited=len(self.visited), sites_total=self._total, site=announced
        )

    def result(self, how: str) -> Any:
        """Say which sites have an estimate of this scan, as far as the mapper tells.

        A site of which nothing is known counts as one without: to palpate it again does no harm.
        The result of an earlier scan there does not count: this one may have felt nothing.
        """
        without = self._without_estimate()
        count = len(self.visited)
        if not count:
            told = ""
        elif unknown := self._outcomes.unknown(self.begins):
            told = f"; whether there are estimates is unknown: {unknown}"
        elif without:
            told = f"; {len(without)} of {count} have no estimate: {list_sites(without)}"
        else:
            told = f"; {count} of {count} have an estimate"
        return self.ACTION.Result(
            sites_visited=count,
            sites_estimated=count - len(without),
            sites_without_estimate=sorted([*without, *(site.number for site in self.untouched)]),
            message=how + told,
        )

    def is_judged(self) -> bool:
        """Whether each visit has a value, or nobody maps.

        One without may get its value yet: estimators may be late.
        """
        return self._outcomes.nobody_maps() or not self._without_estimate()

    def _without_estimate(self) -> list[int]:
        """Return the numbers of the palpated sites without a value."""
        known = {one.site for one in self._outcomes.of(self.begins) if one.has_value}
        return [site.number for site in self.visited if site.number not in known]


class GridSites(ListedSites):
    """The sites of a grid, row by row, in serpentine order."""

    ACTION, NAME = ScanGrid, "scan_grid"

    def __init__(self, goal: ScanGrid.Goal, outcomes: SiteOutcomes) -> None:
        origin = (goal.origin.x, goal.origin.y, goal.origin.z)
        grid = Grid(origin, goal.spacing, goal.rows, goal.columns)
        numbers = _numbers_of(goal, len(grid))
        super().__init__([Site(n, grid.position(n)) for n in numbers], goal.dwell_time, outcomes)


class GivenSites(ListedSites):
    """Sites that the user gives, in their order; then beside those on which an inclusion hangs."""

    ACTION, NAME = ScanSites, "scan_sites"

    def __init__(self, goal: ScanSites.Goal, outcomes: SiteOutcomes) -> None:
        if not 1 <= len(goal.sites) <= MOST_SITES:
            raise ValueError(f"{len(goal.sites)} sites are given; give 1 to {MOST_SITES}")
        if len(goal.normals) not in (0, len(goal.sites)):
            raise ValueError(
                f"{len(goal.normals)} normals are given for {len(goal.sites)} sites: give one "
                "each, or none"
            )
        places = [sound_position((p.x, p.y, p.z)) for p in goal.sites]
        normals = [sound_normal((n.x, n.y, n.z)) for n in goal.normals] or [UP] * len(places)
        if below := [number for number, normal in enumerate(normals) if normal[2] <= 0.0]:
            raise ValueError(
                f"the normals of sites {list_sites(below)} do not point up: the robot would come "
                "through the tissue"
            )
        sites = [Site(i, *each) for i, each in enumerate(zip(places, normals, strict=True))]
        super().__init__(sites, goal.dwell_time, outcomes)
        self._given, self._decides = sites, True
        self._process: DecisionProcess | None = None
        self._again = ""

    def prepare(self, wait: Wait) -> None:
        """Start the process that decides where to palpate again."""
        if self._most_again:
            self._process = DecisionProcess()

    def next(self, wait: Wait) -> Site | None:
        """Return the next of the list, then those to palpate again."""
        if not self._left and self._decides and self._most_again:
            self._decides = False
            self._palpate_again(wait)
        return super().next(wait)

    def ended(self) -> str:
        """Say that all are palpated, and how many again."""
        return super().ended() + self._again

    def result(self, how: str) -> Any:
        """Return the result; nothing is decided any more."""
        if self._process is not None:
            self._process.close()
        return super().result(how)

    def not_reached(self, site: Site) -> bool:
        """Go on where the robot does not reach a place beside the given sites."""
        if site.number < len(self._given):
            return False
        self._total -= 1
        return True

    @property
    def _most_again(self) -> int:
        """How many places at most; none where no site errs: the robot goes where it was sent."""
        return round(self.choosing.again * len(self._given)) if self.choosing.outliers else 0

    def _palpate_again(self, wait: Wait) -> None:
        """Append the places beside sites on which an inclusion hangs, as far as they are told."""
        # Here, since it takes a second to import, and a scan of a grid needs none of it.
        from tissue_probe.mapping.palpate_again import places_again

        wait(self.is_judged, UNTOLD)
        results = [one for one in self._outcomes.of(self.begins) if one.has_value]
        if not results or self._process is None:
            return
        asked = self._process.submit(
            places_again, sites_of(results), self.choosing.outliers, self._most_again
        )
        if not wait(asked.done, LONGEST_DECISION):
            self._again = f"; none again: the decision took more than {LONGEST_DECISION:g} s"
            return
        try:
            places = asked.result()
        except (ParameterError, RuntimeError) as error:  # the given sites are palpated all the same
            self._again = f"; none again: {error}"
            return
        first = len(self._given)
        for number, place in enumerate(places, first):
            beside = min(self._given, key=lambda one: math.dist(one.position, place))
            self._left.append(Site(number, place, beside.normal))
        self._total += len(places)
        if places:
            self._again = f", {len(places)} of them beside one on which an inclusion hangs"


def _numbers_of(goal: ScanGrid.Goal, count: int) -> list[int]:
    """Return the numbers of the sites to palpate, in the order of the way over the grid."""
    sites = list(goal.sites)
    if beyond := [site for site in sites if site >= count]:
        raise ValueError(
            f"sites has {list_sites(beyond)}; the grid's {count} sites are numbered from 0 to "
            f"{count - 1}"
        )
    if twice := sorted(site for site, n in Counter(sites).items() if n > 1):
        raise ValueError(f"sites has {list_sites(twice)} more than once; give each site once")
    return sorted(sites) or list(range(count))


def list_sites(sites: Sequence[int]) -> str:
    """Name sites; of many the first ones."""
    named = ", ".join(map(str, sites[:NAMED]))
    return f"{named} and {len(sites) - NAMED} more" if len(sites) > NAMED else named
