"""The sites of an exploration: each is chosen while the probe palpates the one before.

Contents: the action's goal, its budget, and when a decision is made.

A decision takes a tenth of a second, as the mapper does to tell of a site. So that the probe does
not wait for both, the next site is chosen during a dwell: the site under the probe counts as
decided, with a value that is not known yet.
"""

from __future__ import annotations

import math
import time
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tissue_probe.errors import TissueProbeError
from tissue_probe.mapping.explored_surface import ExploredSurface
from tissue_probe.mapping.fusion import MapBuilder
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.site_result import SiteResult, sites_of
from tissue_probe.nodes.decision_process import DecisionProcess
from tissue_probe.nodes.scan_sources import LONGEST_DECISION, UNTOLD, Site, Source, Wait
from tissue_probe.nodes.site_outcomes import SiteOutcomes
from tissue_probe_msgs import msg
from tissue_probe_msgs.action import Explore

if TYPE_CHECKING:
    from tissue_probe.mapping.exploration.answer import SiteAnswer
    from tissue_probe.mapping.exploration.decision import Decision, SoughtQuestion

#: A robot that misses so many sites in a row, more than there are first ones, does not miss sites:
#: something holds it.
MISSED_IN_A_ROW = 10


class ExploredSites(Source):
    """Sites where they tell most, until the question is answered or the budget is spent."""

    ACTION, NAME = Explore, "explore"

    def __init__(self, goal: Explore.Goal, outcomes: SiteOutcomes) -> None:
        super().__init__(goal.dwell_time or 1.0)
        # Here, since it takes a second to import, and a scan of a grid needs none of it.
        from tissue_probe.mapping.exploration.answer import Sought
        from tissue_probe.mapping.exploration.decision import SoughtQuestion

        if not (goal.most_sites or goal.most_time):
            raise ValueError("no budget is given: give most_sites or most_time")
        if not 0.0 <= goal.most_time < math.inf:
            raise ValueError(f"most_time is {goal.most_time} s; give a time, or 0 for none")
        named = {name: getattr(goal, name) for name in Sought.__dataclass_fields__}
        sought = Sought(**{name: value for name, value in named.items() if value})
        within = _polygon(goal.area)
        self._question: SoughtQuestion = SoughtQuestion(
            within, tuple(map(_polygon, goal.no_go)), sought
        )
        self._surface = ExploredSurface(np.array([(p.x, p.y, p.z) for p in goal.area.points]))
        #: Where each dwell was [m], as ``begins`` has when: the surface that was felt.
        self._felt: list[tuple[float, float, float]] = []
        self._first = [(p.x, p.y) for p in goal.first]
        for x, y in self._first:
            here = np.array([x]), np.array([y])
            if not within.contains(*here)[0]:
                raise ValueError(f"first has ({x}, {y}) m, which is outside the area")
            if any(zone.contains(*here)[0] for zone in self._question.no_go):
                raise ValueError(f"first has ({x}, {y}) m, where no site may be")
        if goal.bag and not Path(goal.bag).exists():
            raise ValueError(f"there is no bag {goal.bag}")
        self._goal, self._outcomes = goal, outcomes
        self._earlier: list[SiteResult] = []
        self._began: float | None = None
        self._missed: list[tuple[float, float]] = []
        self._missed_in_a_row = 0
        self._process: DecisionProcess | None = None
        self._decision: Future[Decision] | None = None
        self._answer: SiteAnswer | None = None
        self._over = self._why = ""

    def prepare(self, wait: Wait) -> None:
        """Read the earlier part, choose the first sites, have the decisions compiled."""
        from tissue_probe.mapping.exploration.decision import rehearse
        from tissue_probe.mapping.exploration.first import first_sites

        self._question = replace(
            self._question, purpose=self.choosing.purpose, outliers=self.choosing.outliers
        )
        self._process = DecisionProcess()
        rehearsed = self._process.submit(rehearse, self._question)
        if self._goal.bag:
            self._earlier = _results_of(self._goal.bag)
        if not self._first and not any(one.has_value for one in self._earlier):
            self._first = first_sites(self._question.within, self._question.no_go)
        self._wait_for(rehearsed, wait)

    def next(self, wait: Wait) -> Site | None:
        """Return the next site: of the first ones, or as decided; None once it is over."""
        if self._began is None:
            self._began = time.monotonic()
        if self._is_spent():
            self._over = "the budget is spent"
        elif self._first:
            return self._site(self._first.pop(0))
        else:
            decision = self._decided(wait)
            if decision.site is None and len(self._outcomes.of(self.begins)) < len(self.begins):
                # Answered before the last site was told: it may contradict.
                wait(self.is_judged, UNTOLD)
                self._decide()
                decision = self._decided(wait)
            self._answer = decision.answer
            if decision.site is not None:
                self._why = f"the site probed now is one {decision.site.why}"
                return self._site((decision.site.x, decision.site.y))
            self._over = "the question is answered"
        self._finish(wait)
        return None

    def dwelling(self, site: Site, begin: int) -> None:
        """Choose the next site meanwhile, if none is planned."""
        super().dwelling(site, begin)
        self._felt.append(site.position)
        self._missed_in_a_row = 0
        if not self._first and not self._is_spent(planned=1):
            self._decide()

    def not_reached(self, site: Site) -> bool:
        """Note that a site was not reached: another one is chosen."""
        self._missed.append(site.position[:2])
        self._missed_in_a_row += 1
        self._decision = None
        return self._missed_in_a_row < MISSED_IN_A_ROW

    def not_touched(self, site: Site) -> bool:
        """Note that no surface was found: another site is chosen, as where none is reached."""
        return self.not_reached(site)

    def is_judged(self) -> bool:
        """Whether the mapper has told of each visit, or nobody maps."""
        return self._outcomes.have_all(self.begins)

    def ended(self) -> str:
        """Say why it is over."""
        return f"{self._over}; {self.so_far()}"

    def so_far(self) -> str:
        """Say how many sites are palpated, and the result so far."""
        told = f"{len(self.visited)} sites are palpated"
        return f"{told}: {self._answer.text}" if self._answer else told

    def feedback(self, announced: msg.PalpationSite) -> Any:
        """Say how far it is and which areas are open."""
        return Explore.Feedback(
            sites_visited=len(self.visited),
            sites_unreachable=len(self._missed),
            site=announced,
            answer=self._answer.text if self._answer else "",
            open=[
                *(self._answer.open if self._answer else ()),
                *([self._why] if self._why else ()),
            ],
        )

    def result(self, how: str) -> Any:
        """Return the answer."""
        if self._process is not None:
            self._process.close()
        return Explore.Result(
            sites_visited=len(self.visited),
            sites_unreachable=len(self._missed),
            answered=self._answer is not None and self._answer.answered,
            answer=self._answer.text if self._answer else "",
            open=list(self._answer.open) if self._answer else [],
            message=how,
        )

    def _finish(self, wait: Wait) -> None:
        """Say the result of all sites together."""
        from tissue_probe.mapping.exploration.decision import final

        wait(self.is_judged, UNTOLD)
        results = self._results()
        if self._process is not None and any(one.has_value for one in results):
            told = self._process.submit(final, sites_of(results), self._question)
            self._answer = self._wait_for(told, wait)

    def _is_spent(self, planned: int = 0) -> bool:
        """Whether the budget is spent, with so many sites that are planned."""
        goal = self._goal
        if goal.most_sites and len(self.visited) + planned >= goal.most_sites:
            return True
        if not goal.most_time or self._began is None:
            return False
        return bool(time.monotonic() - self._began >= goal.most_time)

    def _results(self) -> list[SiteResult]:
        return [*self._earlier, *self._outcomes.of(self.begins)]

    def _decide(self) -> None:
        """Have the next site chosen from all that is known now."""
        from tissue_probe.mapping.exploration.decision import decide

        results = self._results()
        if self._process is None or not any(one.has_value for one in results):
            self._decision = None
            return
        told = {one.stamp for one in results}
        dwells = zip(self._felt, self.begins, strict=True)
        pending = [place[:2] for place, begin in dwells if begin not in told]
        self._decision = self._process.submit(
            decide,
            sites_of(results),
            self._question,
            start=self._felt[-1][:2] if self._felt else None,
            pending=pending,
            unreachable=list(self._missed),
        )

    def _decided(self, wait: Wait) -> Decision:
        """Return the decision that was asked for, or ask for one now."""
        if self._decision is None:
            wait(self.is_judged, UNTOLD)
            self._decide()
        if self._decision is None:
            why = self._outcomes.unknown(self.begins) or "their results on sites say why"
            raise TissueProbeError(f"none of {len(self.begins)} sites has a value: {why}")
        decided, self._decision = self._wait_for(self._decision, wait), None
        found: Decision = decided
        return found

    def _wait_for(self, future: Future[Any], wait: Wait) -> Any:
        if not wait(future.done, LONGEST_DECISION):
            raise TissueProbeError(f"a decision took more than {LONGEST_DECISION:g} s")
        return future.result()

    def _site(self, place: tuple[float, float]) -> Site:
        position, normal = self._surface.at(place, self._felt)
        return Site(len(self.begins) + len(self._missed), position, normal)


def _polygon(area: Any) -> Polygon:
    return Polygon(np.array([(p.x, p.y) for p in area.points], dtype=float).reshape(-1, 2))


def _results_of(bag: str) -> list[SiteResult]:
    """Return the results of a recording's dwells, from its announcements and estimates."""
    from tissue_probe.recording.bags.reader import read_estimates, read_recording

    builder = MapBuilder()
    for site in read_recording(Path(bag)).sites:
        builder.announce(site)
    for found in read_estimates(Path(bag)).values():
        builder.add(found)
    return builder.results(under_way=False)
