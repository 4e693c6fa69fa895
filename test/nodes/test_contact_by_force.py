"""A scan that lowers the tip until the load cell feels the tissue."""

from __future__ import annotations

import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped

from conftest import PATIENT, STAGE, Scanning, collect, driver, estimator, goal
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED, POSES
from tissue_probe.nodes.session import NodeProcess
from tissue_probe_msgs.msg import PalpationSite, SiteResults, StiffnessMap

FILTERS = ["robust_ekf"]
MAPPER = NodeProcess("mapper", "mapper", parameters={"estimators": FILTERS})


def scan(**parameters: float) -> NodeProcess:
    values = {**PATIENT, "estimators": FILTERS, "contact_search": 0.0005, **parameters}
    return NodeProcess("scan", "scan", parameters=values)


def phantom(path, heights: list[float], stiffness: float = 450.0):
    """Write a table of tissue that has these heights [m] at steps of 10 mm along x."""
    rows = [
        f"{0.01 * column},{y},{height},{stiffness}\n"
        for column, height in enumerate(heights)
        for y in (-0.01, 0.01)
    ]
    path.write_text("x,y,z,k\n" + "".join(rows))
    return path


def test_the_surface_is_found_where_it_is_and_a_site_without_one_is_unknown(session, tmp_path):
    # Below the given surface, above it, out of reach below, and above where the search begins.
    heights = [-0.0001, 0.0003, -0.002, 0.002]
    table = phantom(tmp_path / "felt.csv", heights)
    running = session(
        driver(simulated__phantom=str(table)), STAGE, scan(), estimator(*FILTERS), MAPPER
    )
    sites = collect(running.node, PalpationSite, "/probe/palpation_site", ANNOUNCEMENTS)
    results = collect(running.node, SiteResults, "/probe/sites", LATCHED)
    running.activate(
        {"/probe/driver": 2, "/probe/robust_ekf": 2}, {"/probe/robust_ekf": 2, "/probe/mapper": 2}
    )
    answer = Scanning(running, goal(columns=4, dwell_time=0.5)).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    assert answer.result.message.startswith(
        "2 of 4 sites are palpated; no contact was found at 2, 3; 2 of 2 have an estimate"
    )
    assert list(answer.result.sites_without_estimate) == [2, 3]
    running.wait_until(lambda: len(sites) == 10, "the announcements")
    left = [site.leaving for site in sites if site.phase == PalpationSite.LIFTED]
    assert left[2:] == [PalpationSite.NO_CONTACT, PalpationSite.IN_CONTACT]
    running.wait_until(lambda: results and len(results[-1].results) == 4, "all results")
    found = results[-1].results
    for one, height in zip(found[:2], heights[:2], strict=True):
        assert one.verdict in (StiffnessMap.MEASURED, StiffnessMap.DISTURBED)
        # Within the way of a period, twice over: the machine that tests is busy.
        assert one.position.z == pytest.approx(height, abs=0.0002)
        assert one.stiffness == pytest.approx(450.0, rel=0.03)
    for one in found[2:]:
        assert one.verdict == StiffnessMap.CONTACT_NOT_FOUND
        assert one.stiffness != one.stiffness  # not a number


def test_the_tip_stops_at_the_force_limit_and_is_lifted(session, tmp_path):
    table = phantom(tmp_path / "felt.csv", [0.002, 0.002], stiffness=1300.0)
    running = session(driver(simulated__phantom=str(table)), STAGE, scan(contact_force_limit=0.5))
    sites = collect(running.node, PalpationSite, "/probe/palpation_site", ANNOUNCEMENTS)
    poses = collect(running.node, PoseStamped, "/stage/measured_cp", POSES)
    running.activate({"/probe/driver": 1})
    answer = Scanning(running, goal(columns=1)).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    assert "no contact was found at 0" in answer.result.message
    running.wait_until(lambda: len(sites) == 2, "the announcements")
    assert sites[-1].leaving == PalpationSite.FORCE_LIMIT
    running.wait_until(lambda: poses[-1].pose.position.z > 0.0028, "the probe to be lifted")
    # Lowered to half a millimetre it would press with 0.5 N or more: it stopped before.
    assert min(pose.pose.position.z for pose in poses) > 0.0005
