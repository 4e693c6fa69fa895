"""A scan that lowers the tip until the load cell feels the tissue."""

from __future__ import annotations

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, Point32, Polygon, PoseStamped, Vector3

from conftest import (
    PATIENT,
    STAGE,
    Acting,
    Scanning,
    collect,
    command,
    driver,
    estimator,
    goal,
)
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED, POSES
from tissue_probe.nodes.session import NodeProcess
from tissue_probe_msgs.action import Explore, ScanSites
from tissue_probe_msgs.msg import PalpationSite, SiteResults, StiffnessMap

FILTERS = ["robust_ekf"]
MAPPER = NodeProcess("mapper", "mapper", parameters={"estimators": FILTERS})
#: Whom the suite's nodes hear, and by whom they are heard.
HEARD = (
    {"/probe/driver": 2, "/probe/robust_ekf": 2},
    {"/probe/robust_ekf": 2, "/probe/mapper": 2},
)


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
    running.activate(*HEARD)
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


#: A surface that rises by a tenth along x, so that its normal is turned by 5.7 degrees.
SLOPE = 0.1
NORMAL = np.array([-SLOPE, 0.0, 1.0]) / np.hypot(1.0, SLOPE)


def tilted(path, bend: float = 0.0):
    """Write a tissue that rises along x, and is lower by ``bend`` [m] at the corners."""
    along = np.linspace(-0.01, 0.05, 31)
    x, y = (each.ravel() for each in np.meshgrid(along, along))
    z = SLOPE * x - bend * ((x - 0.015) ** 2 + (y - 0.015) ** 2) / 0.015**2 / 2.0
    np.savetxt(
        path,
        np.column_stack([x, y, z, np.full(x.size, 450.0)]),
        delimiter=",",
        header="x,y,z,k",
        comments="",
    )
    return path


def height_above(position, bend: float = 0.0) -> float:
    """Return how far a place is above that tissue [m]."""
    off = (position.x - 0.015) ** 2 + (position.y - 0.015) ** 2
    return position.z - SLOPE * position.x + bend * off / 0.015**2 / 2.0


def test_given_sites_on_a_tilted_surface_are_found_and_left_along_their_normals(session, tmp_path):
    table = tilted(tmp_path / "tilted.csv")
    running = session(
        driver(simulated__phantom=str(table)), STAGE, scan(), estimator(*FILTERS), MAPPER
    )
    results = collect(running.node, SiteResults, "/probe/sites", LATCHED)
    poses = collect(running.node, PoseStamped, "/stage/measured_cp", POSES)
    running.activate(*HEARD)
    # Given as too high and as too low; up and down the slope.
    places = [(0.02, 0.0, 0.0003), (0.005, 0.01, -0.0003), (0.025, 0.02, 0.0)]
    wanted = ScanSites.Goal(
        sites=[Point(x=x, y=y, z=SLOPE * x + off) for x, y, off in places],
        normals=[Vector3(x=NORMAL[0], z=NORMAL[2])] * 3,
        dwell_time=0.5,
    )
    answer = Acting(running, ScanSites, "scan_sites", wanted).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    running.wait_until(lambda: results and len(results[-1].results) == 3, "all results")
    for one, given in zip(results[-1].results, wanted.sites, strict=True):
        assert height_above(one.position) == pytest.approx(0.0, abs=0.0002)
        # Along the normal alone: what the given place is beside it stays.
        off = np.array([one.position.x - given.x, one.position.z - given.z])
        assert off @ [NORMAL[2], -NORMAL[0]] == pytest.approx(0.0, abs=0.00005)
        assert one.stiffness == pytest.approx(450.0, rel=0.03)
        above = np.array([one.position.x, one.position.y, one.position.z]) + 0.003 * NORMAL
        seen = np.array([(p.pose.position.x, p.pose.position.y, p.pose.position.z) for p in poses])
        assert np.linalg.norm(seen - above, axis=1).min() < 0.0003


@pytest.mark.slow
def test_an_exploration_with_a_foreign_robot_follows_a_surface_that_bends(session, tmp_path, robot):
    # 1.5 mm lower in the corners than in the middle of a plane that is given: contact is sought
    # within 0.5 mm of where the sites before have it.
    bend, namespace = 0.0015, "/dvrk/PSM1"
    table = tilted(tmp_path / "bent.csv", bend)
    running = session(
        driver(simulated__phantom=str(table), stage_pose=f"{namespace}/measured_cp"),
        scan(robot=namespace, lift_height=0.005),
        estimator(*FILTERS),
        MAPPER,
    )
    results = collect(running.node, SiteResults, "/probe/sites", LATCHED)
    running.activate(*HEARD)
    command(running, namespace, "enable", "ENABLED")
    corners = ((0.0, 0.0), (0.03, 0.0), (0.03, 0.03), (0.0, 0.03))
    wanted = Explore.Goal(
        area=Polygon(points=[Point32(x=x, y=y, z=SLOPE * x) for x, y in corners]),
        # From the middle, where the plane touches, outwards.
        first=[Point(x=0.015 + a, y=0.015 + b) for a, b in OUTWARDS],
        most_sites=12,
    )
    answer = Acting(running, Explore, "explore", wanted).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    assert answer.result.sites_unreachable == 0
    assert answer.result.sites_visited == 12 or answer.result.answered
    visited = answer.result.sites_visited
    running.wait_until(lambda: results and len(results[-1].results) == visited, "all results")
    heights = [height_above(one.position, bend) for one in results[-1].results]
    assert heights == pytest.approx([0.0] * visited, abs=0.0002)
    for one in results[-1].results:
        assert one.stiffness == pytest.approx(450.0, rel=0.03)
    depths = [one.position.z - SLOPE * one.position.x for one in results[-1].results]
    assert min(depths) < -0.0005  # deeper than contact is searched below the plane


#: From the middle outwards, in steps over which the surface falls less than contact is sought.
OUTWARDS = [
    (radius * np.cos(angle), radius * np.sin(angle))
    for radius, count in ((0.0, 1), (0.006, 4), (0.013, 4))
    for angle in 2.0 * np.pi * np.arange(count) / count
]
