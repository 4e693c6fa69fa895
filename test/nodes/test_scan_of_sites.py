"""A scan of chosen sites, and what it tells of estimates."""

from __future__ import annotations

import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Point

from conftest import SCAN, STAGE, Scanning, activate, collect, driver, estimator, goal
from tissue_probe.mapping.grid import Grid
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED
from tissue_probe.nodes.session import NodeProcess
from tissue_probe_msgs.action import ScanGrid
from tissue_probe_msgs.msg import PalpationSite, StiffnessMap


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
    assert "unknown: no map was heard on /probe/stiffness_map" in answer.result.message


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
    running.wait_until(lambda: told in running.log("scan"), "the log")


class MapperOfTwoRows:
    """Says of each cell what it is told to, when the last of the sites is lifted.

    Its grid holds more than the scan's, and begins elsewhere: cells are found by their position.
    """

    ORIGIN = (-0.01, 0.0, 0.0)

    def __init__(self, node, verdicts: dict[tuple[float, float], int], sites: int) -> None:
        self._grid = Grid(self.ORIGIN, 0.01, 2, 4)
        self._verdicts = verdicts
        self._left = sites
        self._publisher = node.create_publisher(StiffnessMap, "/probe/stiffness_map", LATCHED)
        node.create_subscription(
            PalpationSite, "/probe/palpation_site", self._on_site, ANNOUNCEMENTS
        )
        self._publish(PalpationSite().header.stamp, {})

    def _on_site(self, site: PalpationSite) -> None:
        self._left -= site.phase == PalpationSite.LIFTED
        if site.phase == PalpationSite.LIFTED and self._left == 0:
            self._publish(site.header.stamp, self._verdicts)

    def _publish(self, stamp, verdicts) -> None:
        cells = [0] * len(self._grid)
        for (x, y), verdict in verdicts.items():
            row, column = self._grid.nearest((x, y))
            cells[row * self._grid.columns + column] = verdict
        x, y, z = self._grid.origin
        message = StiffnessMap(origin=Point(x=x, y=y, z=z), spacing=0.01, rows=2, columns=4)
        message.header.stamp = stamp
        message.verdict = cells
        self._publisher.publish(message)


def test_the_result_tells_which_sites_have_an_estimate(session):
    running = session(driver(), STAGE, SCAN)
    MapperOfTwoRows(
        running.node,
        {
            (0.0, 0.0): StiffnessMap.MEASURED,
            (0.01, 0.0): StiffnessMap.MODEL_REJECTED,
            (0.01, 0.01): StiffnessMap.DISTURBED,
            (0.0, 0.01): StiffnessMap.NO_ESTIMATE,
        },
        sites=4,
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
