"""A scan of given sites goes back to where one site alone feels an inclusion."""

import numpy as np
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Point

from conftest import PATIENT, Acting, activate, driver
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED
from tissue_probe.nodes.session import NodeProcess
from tissue_probe_msgs.action import ScanSites
from tissue_probe_msgs.msg import PalpationSite, SiteResult, SiteResults, StiffnessMap

SPACING = 0.01  # m
SLIPPED = 9


class MapperWithASlip:
    """Tells 450 N/m of each visit, give or take 1 %, and 1200 N/m of one."""

    def __init__(self, node) -> None:
        self._rng, self._begin = np.random.default_rng(0), None
        self._results: list[SiteResult] = []
        self._publisher = node.create_publisher(SiteResults, "/probe/sites", LATCHED)
        node.create_subscription(
            PalpationSite, "/probe/palpation_site", self._on_site, ANNOUNCEMENTS
        )

    def _on_site(self, site: PalpationSite) -> None:
        if site.phase == PalpationSite.DWELL:
            self._begin = site.header
        if site.phase != PalpationSite.LIFTED:
            return
        felt = 450.0 * (1.0 + 0.01 * float(self._rng.standard_normal()))
        result = SiteResult(
            header=self._begin,
            site=site.site,
            position=site.position,
            normal=site.normal,
            stiffness=1200.0 if site.site == SLIPPED else felt,
            stiffness_stddev=2.0,
            verdict=StiffnessMap.MEASURED,
            leaving=site.leaving,
        )
        self._results.append(result)
        self._publisher.publish(SiteResults(results=self._results))


def test_given_sites_are_palpated_and_then_beside_the_one_that_alone_feels_an_inclusion(session):
    scan = NodeProcess("scan", "scan", parameters={**PATIENT, "outliers": 0.01, "speed": 0.3})
    running = session(driver(), NodeProcess("stage", "stage", "/stage", {"speed": 0.5}), scan)
    MapperWithASlip(running.node)
    activate(running)
    places = [(SPACING * i, SPACING * j) for j in range(4) for i in range(4)]
    wanted = ScanSites.Goal(sites=[Point(x=x, y=y) for x, y in places], dwell_time=0.1)
    acting = Acting(running, ScanSites, "scan_sites", wanted)
    answer = acting.result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    assert "1 of them beside one on which an inclusion hangs" in answer.result.message
    *given, again = [(site.position.x, site.position.y) for site in acting.dwells()]
    assert given == places
    apart = np.hypot(*np.subtract(again, places[SLIPPED]))
    assert 0.0005 < apart < 0.4 * SPACING
    assert answer.result.sites_visited == 17
    assert acting.feedback[-1].sites_total == 17
