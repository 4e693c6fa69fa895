"""The scan node: from site to site, and lifted whatever ends it."""

from __future__ import annotations

import re
import signal

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped

from conftest import (
    PATIENT,
    SCAN,
    STAGE,
    Scanning,
    activate,
    collect,
    driver,
    estimator,
    goal,
    samples_publisher,
    stage_on_tissue,
)
from tissue_probe.configuration import stock_configuration
from tissue_probe.nodes.conversions import from_time, samples_to_message
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED, POSES
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.physics.phantom import Phantom
from tissue_probe.signals import NANOSECONDS, SampleBlock
from tissue_probe_msgs.msg import PalpationSite, SiteResults, StiffnessMap


@pytest.fixture
def running(session):
    started = session(driver(), STAGE, SCAN)
    activate(started)
    return started


def test_every_site_is_approached_palpated_for_its_time_and_left(running):
    sites = collect(running.node, PalpationSite, "/probe/palpation_site", ANNOUNCEMENTS)
    scanning = Scanning(running, goal(rows=2, columns=2))
    answer = scanning.result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    assert answer.result.sites_visited == 4
    running.wait_until(lambda: len(sites) == 12, "the announcements")
    assert [site.phase for site in sites] == 4 * [
        PalpationSite.APPROACH,
        PalpationSite.DWELL,
        PalpationSite.LIFTED,
    ]
    # Serpentine: the way back along the second row.
    places = [(s.position.x, s.position.y) for s in sites if s.phase == PalpationSite.DWELL]
    assert places == [(0.0, 0.0), (0.01, 0.0), (0.01, 0.01), (0.0, 0.01)]
    stamps = [from_time(site.header.stamp) for site in sites]
    for begin, end in zip(stamps[1::3], stamps[2::3], strict=True):
        assert end - begin == 200_000_000
    assert scanning.feedback[-1].sites_visited == scanning.feedback[-1].sites_total == 4


def test_the_dwell_is_announced_before_it_begins(running):
    early = []

    def hear(message) -> None:
        if message.phase == PalpationSite.DWELL:
            now = running.node.get_clock().now().nanoseconds
            early.append(from_time(message.header.stamp) - now)

    running.node.create_subscription(PalpationSite, "/probe/palpation_site", hear, ANNOUNCEMENTS)
    answer = Scanning(running, goal()).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    running.wait_until(lambda: len(early) == 2, "both dwells")
    assert min(early) > 0


def test_dwells_are_told_in_the_time_of_the_samples_whatever_the_clock_says(session):
    """As after a step of the clock, or with a robot whose clock is another's."""
    running = session(STAGE, SCAN)
    sites = collect(running.node, PalpationSite, "/probe/palpation_site", ANNOUNCEMENTS)
    publisher = samples_publisher(running.node)
    an_hour_ago = running.node.get_clock().now().nanoseconds - 3600 * NANOSECONDS
    sent = []

    def publish() -> None:
        number = len(sent)
        stamp = an_hour_ago + 5_000_000 * number
        sent.append(SampleBlock(stamp, 10 * number, 0.0005, *np.zeros((3, 10))))
        publisher.publish(samples_to_message(sent[-1], "probe"))

    running.node.create_timer(0.005, publish)
    answer = Scanning(running, goal(columns=1)).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    running.wait_until(lambda: len(sites) == 3, "the announcements")
    for site in sites:
        assert sent[0].stamp <= from_time(site.header.stamp) <= sent[-1].end + NANOSECONDS


def test_the_probe_stays_down_until_late_samples_have_reached_the_end_of_the_dwell(session):
    """As from a driver whose machine is busy: a block of 5 ms comes every 20 ms."""
    running = session(STAGE, SCAN)
    sites = collect(running.node, PalpationSite, "/probe/palpation_site", ANNOUNCEMENTS)
    publisher = samples_publisher(running.node)
    began = running.node.get_clock().now().nanoseconds
    sent, reached_when_lifted = [], []

    def publish() -> None:
        number = len(sent)
        stamp = began + 5_000_000 * number
        sent.append(SampleBlock(stamp, 10 * number, 0.0005, *np.zeros((3, 10))))
        publisher.publish(samples_to_message(sent[-1], "probe"))

    def hear(pose: PoseStamped) -> None:
        dwelt = any(site.phase == PalpationSite.DWELL for site in sites)
        if dwelt and pose.pose.position.z > 0.0005 and not reached_when_lifted:
            reached_when_lifted.append(sent[-1].end)

    running.node.create_timer(0.02, publish)
    running.node.create_subscription(PoseStamped, "/stage/measured_cp", hear, POSES)
    answer = Scanning(running, goal(columns=1)).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    running.wait_until(lambda: len(sites) == 3 and reached_when_lifted, "the end")
    assert reached_when_lifted[0] >= from_time(sites[-1].header.stamp)
    dwell = from_time(sites[-1].header.stamp) - from_time(sites[1].header.stamp)
    assert dwell == 200_000_000


def test_of_samples_that_come_too_late_it_is_said_by_how_much(session):
    """As above, and who scans is less patient."""
    patience = {**PATIENT, "samples_timeout": 2.0}
    running = session(STAGE, NodeProcess("scan", "scan", parameters=patience))
    publisher = samples_publisher(running.node)
    began = running.node.get_clock().now().nanoseconds
    sent = []

    def publish() -> None:
        number = len(sent)
        stamp = began + 5_000_000 * number
        sent.append(SampleBlock(stamp, 10 * number, 0.0005, *np.zeros((3, 10))))
        publisher.publish(samples_to_message(sent[-1], "probe"))

    running.node.create_timer(0.02, publish)
    answer = Scanning(running, goal(columns=1, dwell_time=2.0)).result()
    assert answer.status == GoalStatus.STATUS_ABORTED
    told = re.search(r"are (\d+\.\d\d) s late, more than 2 s", answer.result.message)
    assert told, answer.result.message
    # Of 2 s a quarter has come, and two seconds were waited, in which another came.
    assert float(told[1]) > 0.75 * 2.0


def test_a_pause_of_the_scan_node_itself_is_no_silence_of_robot_and_driver(session):
    patience = {"poses_timeout": 2.0, "samples_timeout": 2.0, "settle_time": 0.3}
    running = session(driver(), STAGE, NodeProcess("scan", "scan", parameters=patience))
    activate(running)
    poses = collect(running.node, PoseStamped, "/stage/measured_cp", POSES)
    scanning = Scanning(running, goal(columns=1, dwell_time=6.0))
    scanning.wait_for(PalpationSite.DWELL)
    scan, count = running.processes["scan"], len(poses)
    scan.send_signal(signal.SIGSTOP)
    try:
        running.wait_until(lambda: len(poses) > count + 400, "four seconds")
    finally:
        scan.send_signal(signal.SIGCONT)
    answer = scanning.result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message


def test_a_scan_under_way_keeps_others_out_and_when_cancelled_lifts_the_probe(running):
    poses = collect(running.node, PoseStamped, "/stage/measured_cp", POSES)
    scanning = Scanning(running, goal(dwell_time=100.0))
    scanning.wait_for(PalpationSite.DWELL)
    assert not Scanning(running, goal()).handle.accepted
    scanning.handle.cancel_goal_async()
    answer = scanning.result()
    assert answer.status == GoalStatus.STATUS_CANCELED, answer.result.message
    assert "0 of 2 sites" in answer.result.message
    running.wait_until(lambda: poses[-1].pose.position.z > 0.0025, "the probe to be lifted")
    assert scanning.feedback[-1].site.phase == PalpationSite.LIFTED
    assert scanning.feedback[-1].site.leaving == PalpationSite.STOPPED


def test_a_dwell_is_left_when_enough_is_told_and_the_result_says_so(session):
    names = ["ekf", "robust_ekf"]
    running = session(
        driver(),
        STAGE,
        NodeProcess("scan", "scan", parameters={**PATIENT, "estimators": names}),
        *(estimator(name) for name in names),
        NodeProcess("mapper", "mapper", parameters={"estimators": names}),
    )
    sites = collect(running.node, PalpationSite, "/probe/palpation_site", ANNOUNCEMENTS)
    results = collect(running.node, SiteResults, "/probe/sites", LATCHED)
    running.activate(
        {"/probe/driver": 3, **{f"/probe/{name}": 2 for name in names}},
        {"/probe/mapper": 3, **{f"/probe/{name}": 2 for name in names}},
    )
    answer = Scanning(running, goal(dwell_time=20.0)).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    running.wait_until(lambda: len(sites) == 6, "the announcements")
    stamps = [from_time(site.header.stamp) for site in sites]
    for begin, end in zip(stamps[1::3], stamps[2::3], strict=True):
        # A period of 10 Hz, and the time of the filters' tests; busy estimators come later.
        assert 0.2 * NANOSECONDS <= end - begin < 15 * NANOSECONDS
    assert [site.leaving for site in sites[2::3]] == 2 * [PalpationSite.TOLD_ENOUGH]
    running.wait_until(
        lambda: [one.leaving for one in results[-1].results] == 2 * [PalpationSite.TOLD_ENOUGH],
        "the results",
    )
    phantom = Phantom.load(stock_configuration("phantom.yaml"))
    for one in results[-1].results:
        true = phantom.stiffness(one.position.x, one.position.y)
        assert one.stiffness == pytest.approx(true, rel=0.005)


def test_without_estimators_a_dwell_takes_its_longest_time_and_says_so(running):
    sites = collect(running.node, PalpationSite, "/probe/palpation_site", ANNOUNCEMENTS)
    answer = Scanning(running, goal(columns=1)).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    running.wait_until(lambda: len(sites) == 3, "the announcements")
    assert sites[-1].leaving == PalpationSite.LONGEST


def test_a_driver_that_dies_stops_the_scan_and_the_map_keeps_what_it_has(session):
    running = session(
        driver(),
        STAGE,
        NodeProcess("scan", "scan", parameters={**PATIENT, "samples_timeout": 2.0}),
        estimator("ekf"),
        NodeProcess("mapper", "mapper", parameters={"estimators": ["ekf"]}),
    )
    maps = collect(running.node, StiffnessMap, "/probe/stiffness_map", LATCHED)
    poses = collect(running.node, PoseStamped, "/stage/measured_cp", POSES)
    running.activate({"/probe/driver": 2, "/probe/ekf": 1}, {"/probe/ekf": 2, "/probe/mapper": 2})
    scanning = Scanning(running, goal(dwell_time=5.0))
    running.wait_until(lambda: maps and maps[-1].stiffness[0] > 0.0, "the first cell")
    running.processes["driver"].kill()
    running.processes.pop("driver").wait()
    answer = scanning.result()
    assert answer.status == GoalStatus.STATUS_ABORTED, answer.result.message
    assert "no samples for 2 s on /probe/samples" in answer.result.message
    running.wait_until(lambda: poses[-1].pose.position.z > 0.0025, "the probe to be lifted")
    assert maps[-1].stiffness[0] == pytest.approx(450.0, rel=0.05)


def test_a_robot_that_says_nothing_stops_the_scan(session):
    running = session(driver(), NodeProcess("scan", "scan"))
    activate(running)
    answer = Scanning(running, goal()).result()
    assert answer.status == GoalStatus.STATUS_ABORTED, answer.result.message
    assert "/stage/measured_cp" in answer.result.message


def test_a_robot_that_does_not_arrive_stops_the_scan(session):
    running = session(
        driver(),
        NodeProcess("stage", "stage", "/stage", {"speed": 1e-6}),
        NodeProcess("scan", "scan", parameters={"motion_timeout": 0.5, **PATIENT}),
    )
    activate(running)
    answer = Scanning(running, goal()).result()
    assert answer.status == GoalStatus.STATUS_ABORTED, answer.result.message
    assert "did not reach" in answer.result.message


def test_a_scan_without_samples_is_stopped_at_once(session):
    running = session(STAGE, NodeProcess("scan", "scan"))
    answer = Scanning(running, goal()).result()
    assert answer.status == GoalStatus.STATUS_ABORTED, answer.result.message
    assert "is the driver running and active?" in answer.result.message


def test_a_scan_that_makes_no_sense_is_refused(session):
    running = session(STAGE, SCAN)
    for wrong in (
        goal(rows=0),
        goal(dwell_time=0.0),
        goal(dwell_time=float("nan")),
        goal(rows=1000, columns=1000),
    ):
        assert not Scanning(running, wrong).handle.accepted, wrong
    running.wait_until(lambda: "the scan is refused" in running.whole_log("scan"), "the log")


def test_the_stage_stays_where_it_is_for_a_setpoint_that_is_no_number(session):
    running = session(stage_on_tissue(x=0.02))
    poses = collect(running.node, PoseStamped, "/stage/measured_cp", POSES)
    setpoints = running.node.create_publisher(PoseStamped, "/stage/servo_cp", POSES)
    running.wait_until(lambda: setpoints.get_subscription_count() == 1, "the stage")
    wrong = PoseStamped()
    wrong.pose.position.x = float("nan")
    setpoints.publish(wrong)
    running.wait_until(lambda: "no place within" in running.whole_log("stage"), "the log")
    count = len(poses)
    running.wait_until(lambda: len(poses) > count + 10, "more poses")
    assert poses[-1].pose.position.x == 0.02
