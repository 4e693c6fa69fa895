"""Sites that are given, and sites that are chosen on the way: the same machine as a grid's."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, Point32, Polygon, PoseStamped, Vector3
from std_srvs.srv import SetBool

from conftest import (
    PATIENCE,
    PATIENT,
    STAGE,
    Acting,
    ask,
    collect,
    command,
    driver,
    estimator,
    foreign_process,
    session_of_a_module,
)
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED, POSES
from tissue_probe.nodes.session import NodeProcess, Session
from tissue_probe.recording.bags.reader import read_recording
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import Phase
from tissue_probe_msgs.action import Explore, ScanSites
from tissue_probe_msgs.msg import PalpationSite, SiteResults

SCANNING = {**PATIENT, "estimators": ["ekf"]}


def area(x: float = 0.03, y: float = 0.03, slope: float = 0.0) -> Polygon:
    corners = ((0.0, 0.0), (x, 0.0), (x, y), (0.0, y))
    return Polygon(points=[Point32(x=a, y=b, z=slope * a) for a, b in corners])


def suite(session, robot: str = "/stage", **scan):
    """Start the suite with one filter, on our stage or another robot."""
    running = session(
        driver(**({} if robot == "/stage" else {"stage_pose": f"{robot}/measured_cp"})),
        *([STAGE] if robot == "/stage" else []),
        NodeProcess("scan", "scan", parameters={**SCANNING, "robot": robot, **scan}),
        estimator("ekf"),
        NodeProcess("mapper", "mapper", parameters={"estimators": ["ekf"]}),
    )
    running.activate({"/probe/driver": 2, "/probe/ekf": 2}, {"/probe/ekf": 2, "/probe/mapper": 2})
    return running


def test_given_sites_are_palpated_in_their_order_and_left_along_their_normals(session):
    running = suite(session)
    sites = collect(running.node, PalpationSite, "/probe/palpation_site", ANNOUNCEMENTS)
    results = collect(running.node, SiteResults, "/probe/sites", LATCHED)
    poses = collect(running.node, PoseStamped, "/stage/measured_cp", POSES)
    places = [(0.012, 0.003), (0.004, 0.007), (0.0101, 0.0009)]
    wanted = ScanSites.Goal(
        sites=[Point(x=x, y=y) for x, y in places],
        normals=[Vector3(z=2.0), Vector3(x=0.3, z=0.4), Vector3(z=1.0)],
        dwell_time=1.0,
    )
    answer = Acting(running, ScanSites, "scan_sites", wanted).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    assert answer.result.message == "all 3 sites are palpated; 3 of 3 have an estimate"
    running.wait_until(lambda: len(sites) == 9, "the announcements")
    assert [(s.position.x, s.position.y) for s in sites[1::3]] == places
    running.wait_until(lambda: len(results[-1].results) == 3, "the results")
    tilted = results[-1].results[1].normal
    assert (tilted.x, tilted.y, tilted.z) == pytest.approx((0.6, 0.0, 0.8))
    # 3 mm along (0.6, 0, 0.8) from the second site.
    above = np.array([0.004 + 0.0018, 0.007, 0.0024])
    measured = np.array([(p.pose.position.x, p.pose.position.y, p.pose.position.z) for p in poses])
    assert np.linalg.norm(measured - above, axis=1).min() < 0.0005


@pytest.fixture(scope="module")
def waiting() -> Iterator[Session]:
    """A scan node that is given no goal that it takes."""
    with session_of_a_module(NodeProcess("scan", "scan", parameters=SCANNING)) as running:
        yield running


@pytest.mark.parametrize(
    ("goal", "told"),
    [
        (ScanSites.Goal(dwell_time=1.0), "0 sites are given"),
        (
            ScanSites.Goal(sites=[Point()] * 2, normals=[Vector3(z=1.0)], dwell_time=1.0),
            "1 normals are given for 2 sites",
        ),
        (
            ScanSites.Goal(sites=[Point()], normals=[Vector3(z=-1.0)], dwell_time=1.0),
            "do not point up",
        ),
        (ScanSites.Goal(sites=[Point(x=float("nan"))], dwell_time=1.0), "no place"),
        (Explore.Goal(area=area(), dwell_time=1.0), "give most_sites or most_time"),
        (Explore.Goal(most_sites=5), "three corners or more"),
        (Explore.Goal(area=area(), most_sites=5, contrast=0.5), "contrast is 0.5"),
        (Explore.Goal(area=area(), most_sites=5, first=[Point(x=1.0)]), "outside the area"),
        (
            Explore.Goal(area=area(), no_go=[area(0.01, 0.01)], most_sites=5, first=[Point()]),
            "where no site may be",
        ),
        (Explore.Goal(area=area(), most_sites=5, bag="/nowhere.mcap"), "there is no bag"),
    ],
)
def test_a_goal_that_makes_no_sense_is_refused_in_a_sentence(waiting, goal, told):
    kind, name = (ScanSites, "scan_sites") if hasattr(goal, "sites") else (Explore, "explore")
    assert not Acting(waiting, kind, name, goal).handle.accepted
    waiting.wait_until(lambda: told in waiting.whole_log("scan"), "the log")


@pytest.mark.crowded
@pytest.mark.slow
def test_an_exploration_keeps_to_area_zone_plane_and_budget_and_tells_what_is_open(session):
    running = suite(session)
    zone = Polygon(points=[Point32(x=x, y=y) for x, y in ((0.0, 0.0), (0.01, 0.0), (0.0, 0.01))])
    wanted = Explore.Goal(area=area(slope=-1e-4), no_go=[zone], most_sites=12)
    acting = Acting(running, Explore, "explore", wanted)
    answer = acting.result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    told = answer.result
    assert told.sites_visited <= 12
    assert told.sites_visited == 12 or told.answered
    assert told.answer in told.message
    assert told.answered or told.open
    assert any(feedback.answer and feedback.open for feedback in acting.feedback)
    for site in acting.dwells():
        x, y, z = site.position.x, site.position.y, site.position.z
        assert -1e-6 <= x <= 0.030001
        assert -1e-6 <= y <= 0.030001
        assert x + y > 0.0099
        assert z == pytest.approx(-1e-4 * x, abs=1e-8)
        assert site.normal.x == pytest.approx(1e-4, rel=0.01)


def test_an_exploration_is_paused_between_sites_goes_on_and_is_cancelled(session):
    running = suite(session)
    wanted = Explore.Goal(area=area(), most_sites=100, probability=0.99999)
    acting = Acting(running, Explore, "explore", wanted)
    running.wait_until(lambda: acting.dwells(), "the first dwell")

    def pause(on: bool) -> None:
        answer = ask(running, SetBool, "/probe/scan/pause", SetBool.Request(data=on))
        assert answer.success, answer.message

    pause(True)
    running.wait_until(lambda: acting.feedback[-1].site.phase == PalpationSite.LIFTED, "the lift")
    poses = collect(running.node, PoseStamped, "/stage/measured_cp", POSES)
    running.wait_until(lambda: len(poses) > 100, "a second of poses")
    visited = acting.feedback[-1].sites_visited
    assert min(pose.pose.position.z for pose in poses) > 0.0025
    pause(False)
    running.wait_until(lambda: acting.feedback[-1].sites_visited > visited, "another site")
    acting.handle.cancel_goal_async()
    answer = acting.result()
    assert answer.status == GoalStatus.STATUS_CANCELED, answer.result.message
    assert answer.result.sites_visited >= visited + 1
    running.wait_until(lambda: poses[-1].pose.position.z > 0.0025, "the probe to be lifted")


def test_a_pause_without_a_scan_is_refused(waiting):
    answer = ask(waiting, SetBool, "/probe/scan/pause", SetBool.Request(data=True))
    assert not answer.success
    assert answer.message == "no scan is under way"


@pytest.fixture
def short_robot(monkeypatch):
    """Start a foreign robot that comes no farther than x = 20 mm."""
    monkeypatch.setenv("REACH", "0.02")
    with foreign_process("foreign_robot.py") as process:
        yield process


@pytest.mark.slow
def test_a_foreign_robot_that_cannot_reach_a_site_gets_another_one(session, short_robot):
    robot = "/dvrk/PSM1"
    running = suite(session, robot, motion_timeout=0.5)
    command(running, robot, "enable", "ENABLED")
    wanted = Explore.Goal(area=area(), most_sites=9)
    answer = Acting(running, Explore, "explore", wanted).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    assert answer.result.sites_unreachable > 0
    assert answer.result.sites_visited == 9 or answer.result.answered
    told = json.loads(short_robot.communicate("stop\n", timeout=PATIENCE)[0])
    assert told["turned"] == 0
    # Of every site that was begun the lift was told, whether it was reached or not.
    assert told["phases"].count(PalpationSite.DWELL) == answer.result.sites_visited
    begun = answer.result.sites_visited + answer.result.sites_unreachable
    assert told["phases"].count(PalpationSite.LIFTED) == begun


def test_an_exploration_goes_on_from_a_bag(session, bag):
    """What was palpated before counts: no first sites are palpated again."""
    running = session(
        driver(),
        STAGE,
        NodeProcess("scan", "scan", parameters=SCANNING),
        estimator("ekf"),
        NodeProcess("mapper", "mapper", parameters={"estimators": ["ekf"]}),
        NodeProcess("recorder", "recorder", parameters={"output": str(bag)}),
    )
    running.activate({"/probe/driver": 3, "/probe/ekf": 3}, {"/probe/ekf": 2, "/probe/mapper": 2})
    along = (0.005, 0.015, 0.025)
    places = [Point(x=x, y=y) for y in along for x in along]
    before = Acting(running, ScanSites, "scan_sites", ScanSites.Goal(sites=places, dwell_time=1.0))
    assert before.result().result.sites_visited == 9
    running.wait_until(lambda: len(dwells_in(bag)) == 9, "the recording", PATIENCE)
    wanted = Explore.Goal(area=area(), most_sites=1, bag=str(bag))
    acting = Acting(running, Explore, "explore", wanted)
    answer = acting.result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    # A spread of nine sites is not begun with, and one site alone would tell nothing.
    assert answer.result.sites_visited == 1 or answer.result.answered
    assert answer.result.answer != "not known yet"


def dwells_in(bag) -> list:
    try:
        return [s for s in read_recording(bag).sites if s.phase == Phase.LIFTED]
    except (RecordingError, OSError):
        return []
