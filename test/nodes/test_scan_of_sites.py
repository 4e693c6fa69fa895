"""A scan of chosen sites, and what it tells of estimates."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from action_msgs.msg import GoalStatus

from conftest import (
    SCAN,
    STAGE,
    Scanning,
    activate,
    collect,
    driver,
    estimator,
    goal,
    samples_publisher,
)
from tissue_probe.nodes.conversions import samples_to_message
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.recording.bags.reader import read_recording
from tissue_probe_msgs.action import ScanGrid
from tissue_probe_msgs.msg import PalpationSite, SiteResult, SiteResults, StiffnessMap

EXAMPLES = Path(__file__).parents[2] / "examples"


def goal_of(sites: list[int], rows: int = 2, columns: int = 2) -> ScanGrid.Goal:
    wanted = goal(rows, columns)
    wanted.sites = sites
    return wanted


def test_only_the_sites_asked_for_are_palpated_and_without_a_map_nothing_is_known(session):
    running = session(driver(), STAGE, SCAN)
    activate(running)
    sites = collect(running.node, PalpationSite, "/probe/palpation_site", ANNOUNCEMENTS)
    scanning = Scanning(running, goal_of([3, 1]))
    answer = scanning.result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    running.wait_until(lambda: len(sites) == 6, "the announcements")
    dwells = [site for site in sites if site.phase == PalpationSite.DWELL]
    # Numbered along the serpentine path over the whole grid.
    places = [(site.site, site.position.x, site.position.y) for site in dwells]
    assert places == [(1, 0.01, 0.0), (3, 0.0, 0.01)]
    assert scanning.feedback[-1].sites_visited == scanning.feedback[-1].sites_total == 2
    assert answer.result.sites_visited == 2
    assert answer.result.sites_estimated == 0
    assert list(answer.result.sites_without_estimate) == [1, 3]
    assert "all 2 sites are palpated" in answer.result.message
    assert "unknown: no result of them was heard on /probe/sites" in answer.result.message


@pytest.mark.parametrize(
    ("sites", "told"),
    [
        ([0, 4], "sites has 4; the grid's 4 sites are numbered from 0 to 3"),
        ([2, 1, 2], "sites has 2 more than once"),
    ],
)
def test_sites_that_the_grid_does_not_have_or_that_come_twice_are_refused(session, sites, told):
    running = session(SCAN)
    assert not Scanning(running, goal_of(sites)).handle.accepted
    running.wait_until(lambda: told in running.whole_log("scan"), "the log")


class MapperOfFourSites:
    """Says of each site what it is told to, when it is lifted; it has mapped them all before."""

    def __init__(self, node, verdicts: dict[int, int]) -> None:
        self._verdicts = verdicts
        self._begin = None
        self._publisher = node.create_publisher(SiteResults, "/probe/sites", LATCHED)
        node.create_subscription(
            PalpationSite, "/probe/palpation_site", self._on_site, ANNOUNCEMENTS
        )
        self._results = [
            SiteResult(site=site, stiffness=450.0, verdict=StiffnessMap.MEASURED, leaving=2)
            for site in verdicts
        ]

    def _on_site(self, site: PalpationSite) -> None:
        if site.phase == PalpationSite.DWELL:
            self._begin = site.header
        if site.phase != PalpationSite.LIFTED:
            return
        verdict = self._verdicts[site.site]
        usable = verdict in (StiffnessMap.MEASURED, StiffnessMap.DISTURBED)
        found = SiteResult(
            header=self._begin,
            site=site.site,
            stiffness=450.0 if usable else float("nan"),
            verdict=verdict,
            leaving=site.leaving,
        )
        self._results.append(found)
        self._publisher.publish(SiteResults(results=self._results))


def test_the_result_tells_which_sites_have_an_estimate_of_this_scan(session):
    running = session(driver(), STAGE, SCAN)
    MapperOfFourSites(
        running.node,
        {
            0: StiffnessMap.MEASURED,
            1: StiffnessMap.MODEL_REJECTED,
            2: StiffnessMap.DISTURBED,
            3: StiffnessMap.NO_ESTIMATE,
        },
    )
    activate(running)
    answer = Scanning(running, goal_of([])).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    assert answer.result.sites_visited == 4
    assert answer.result.sites_estimated == 2
    assert list(answer.result.sites_without_estimate) == [1, 3]
    assert answer.result.message == ("all 4 sites are palpated; 2 of 4 have no estimate: 1, 3")


def test_the_mapper_tells_the_scan_what_became_of_its_sites(session):
    running = session(
        driver(),
        STAGE,
        SCAN,
        estimator("ekf"),
        NodeProcess("mapper", "mapper", parameters={"estimators": ["ekf"]}),
    )
    running.activate({"/probe/driver": 2, "/probe/ekf": 1}, {"/probe/ekf": 2, "/probe/mapper": 2})
    wanted = goal_of([], rows=1)
    wanted.dwell_time = 1.0
    answer = Scanning(running, wanted).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    assert answer.result.message == "all 2 sites are palpated; 2 of 2 have an estimate"
    assert answer.result.sites_estimated == 2
    assert list(answer.result.sites_without_estimate) == []


def test_a_scan_whose_forces_are_not_known_has_no_estimate_whatever_was_there_before(session):
    """Nor where a filter keeps what it knew over the sites, and calls it converged."""
    running = session(
        STAGE,
        SCAN,
        estimator("ekf", restart_at_site=False),
        NodeProcess("mapper", "mapper", parameters={"estimators": ["ekf"]}),
    )
    known = read_recording(EXAMPLES / "scan.mcap").blocks[0]
    publisher = samples_publisher(running.node)
    began = running.node.get_clock().now().nanoseconds
    unknown = False
    sent = []

    def publish() -> None:
        first = 10 * len(sent)
        part = known[first % len(known) : first % len(known) + 10]
        force = np.full(10, np.nan) if unknown else part.force
        block = replace(part, stamp=began + 500_000 * first, sequence=first, force=force)
        sent.append(block)
        publisher.publish(samples_to_message(block, "probe"))

    running.wait_for_publishers({"/probe/mapper": 2})
    running.node.create_timer(0.005, publish)
    for unknown, told in ((False, "1 of 1 have an estimate"), (True, "1 of 1 have no estimate: 0")):
        wanted = goal_of([], rows=1, columns=1)
        wanted.dwell_time = 0.4
        answer = Scanning(running, wanted).result()
        assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
        assert told in answer.result.message
        assert answer.result.sites_estimated == (not unknown)
