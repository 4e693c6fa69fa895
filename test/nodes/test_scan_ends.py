"""Whatever ends a scan, the probe is lifted before anyone is told."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import String

from conftest import PATIENCE, PATIENT, SCAN, STAGE, Scanning, activate, collect, driver, goal
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED, POSES
from tissue_probe.nodes.session import NodeProcess
from tissue_probe_msgs.msg import PalpationSite

#: Height at which the probe is off the tissue: the scan lifts to 3 mm.
UP = 0.0027


class Lifting:
    """When the stage showed the probe down and up, and when LIFTED was said, as they were sent."""

    def __init__(self, running) -> None:
        self._running = running
        self._down: list[int] = []
        self._up: list[int] = []
        self._told: list[int] = []
        node = running.node
        node.create_subscription(PoseStamped, "/stage/measured_cp", self._on_pose, POSES)
        node.create_subscription(
            PalpationSite, "/probe/palpation_site", self._on_site, ANNOUNCEMENTS
        )

    def _on_pose(self, pose, info) -> None:
        height = pose.pose.position.z
        if height < 0.0025:
            self._down.append(info["source_timestamp"])
            self._up.clear()
        elif height > UP:
            self._up.append(info["source_timestamp"])

    def _on_site(self, site, info) -> None:
        if site.phase == PalpationSite.LIFTED:
            self._told.append(info["source_timestamp"])

    def wait_until_down(self) -> None:
        """Wait until a pose of the probe in the tissue has come: the subscription may be late."""
        self._running.wait_until(lambda: self._down, "the probe to be down")

    def wait(self) -> None:
        """Wait until the probe was down, came up, and that was told; in this order."""
        self._running.wait_until(lambda: self._down and self._up, "the probe to be lifted")
        self._running.wait_until(lambda: self._told, "LIFTED to be said")
        assert self._told[-1] > self._up[0]


@pytest.mark.parametrize("ending", [signal.SIGTERM, signal.SIGINT])
def test_a_scan_node_that_is_told_to_end_lifts_the_probe_first(session, ending):
    running = session(driver(), STAGE, SCAN)
    activate(running)
    lifting = Lifting(running)
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    scanning = Scanning(running, goal(dwell_time=100.0))
    result = scanning.handle.get_result_async()
    scanning.wait_for(PalpationSite.DWELL)
    lifting.wait_until_down()
    process = running.processes.pop("scan")
    process.send_signal(ending)
    lifting.wait()
    running.wait_until(result.done, "the result")
    assert result.result().status == GoalStatus.STATUS_ABORTED
    assert "told to end" in result.result().result.message
    assert process.wait(PATIENCE) == 0
    running.wait_until(lambda: bool(faults), "what the driver says")
    assert faults[-1].data == ""


@pytest.mark.parametrize("where", ["descent", "dwell"])
def test_a_fault_that_nobody_foresaw_lifts_the_probe_and_is_told(session, where):
    running = session(driver(), STAGE)
    activate(running)
    lifting = Lifting(running)
    arguments = ["-r", "__ns:=/probe", "-p", f"samples_timeout:={PATIENT['samples_timeout']}"]
    process = subprocess.Popen(
        [sys.executable, str(Path(__file__).parent / "faulty_scan.py"), "--ros-args", *arguments],
        env={**os.environ, "SCAN_FAILS": where},
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        answer = Scanning(running, goal()).result()
        assert answer.status == GoalStatus.STATUS_ABORTED
        assert "a fault that nobody foresaw" in answer.result.message
        assert answer.result.sites_visited == 0
        lifting.wait()
        # It goes on: the next scan is palpated.
        again = Scanning(running, goal(columns=1)).result()
        assert again.status == GoalStatus.STATUS_SUCCEEDED, again.result.message
    finally:
        process.kill()
        process.wait()


def test_a_pose_that_is_no_number_is_left_out_and_hides_none_before_it(session):
    """The robot is the test's own: it is at once where it is sent to, and sends poses in pairs."""
    running = session(driver(), SCAN)
    activate(running)
    poses = running.node.create_publisher(PoseStamped, "/stage/measured_cp", POSES)
    right, wrong = PoseStamped(), PoseStamped()
    right.pose.position.z, wrong.pose.position.z = 0.01, float("nan")

    def follow(setpoint: PoseStamped) -> None:
        right.pose = setpoint.pose

    def show() -> None:
        poses.publish(right)
        poses.publish(wrong)

    running.node.create_subscription(PoseStamped, "/stage/servo_cp", follow, POSES)
    running.node.create_timer(0.01, show)
    answer = Scanning(running, goal()).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
    assert answer.result.sites_visited == 2


#: So that a test can meet the robot on its way.
SLOW = {"samples_timeout": 10.0, "speed": 0.005}


@pytest.mark.parametrize("phase", ["approach", "dwell", "lift"])
def test_a_robot_that_falls_silent_ends_the_scan_and_the_site_does_not_count(session, phase):
    watching = driver(limits__palpation_timeout=2.0)
    running = session(watching, STAGE, NodeProcess("scan", "scan", parameters=SLOW))
    activate(running)
    poses = collect(running.node, PoseStamped, "/stage/measured_cp", POSES)
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    scanning = Scanning(running, goal(dwell_time=0.1 if phase == "lift" else 100.0))
    if phase == "approach":
        running.wait_until(lambda: poses and 0.004 < poses[-1].pose.position.z < 0.009, "the way")
    else:
        scanning.wait_for(PalpationSite.DWELL)
    if phase == "lift":
        running.wait_until(lambda: poses[-1].pose.position.z == 0.0, "contact")
        running.wait_until(lambda: poses[-1].pose.position.z > 0.0005, "the lift")
    stage = running.processes["stage"]
    stage.send_signal(signal.SIGSTOP)
    try:
        answer = scanning.result()
        assert answer.status == GoalStatus.STATUS_ABORTED
        assert "the robot /stage fell silent" in answer.result.message
        assert "not known to be lifted" in answer.result.message
        assert answer.result.sites_visited == 0
        # A probe that may rest in the tissue does not shake there.
        running.wait_until(lambda: faults[-1].data != "", "the fault")
        assert "without having lifted the probe" in faults[-1].data
    finally:
        stage.send_signal(signal.SIGCONT)
    running.wait_until(lambda: poses[-1].pose.position.z > UP, "the robot to do what it was told")


def test_a_robot_that_dies_ends_the_scan(session):
    running = session(driver(), STAGE, NodeProcess("scan", "scan", parameters=SLOW))
    activate(running)
    scanning = Scanning(running, goal(dwell_time=100.0))
    scanning.wait_for(PalpationSite.DWELL)
    running.processes["stage"].kill()
    running.processes.pop("stage").wait()
    answer = scanning.result()
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert "the robot /stage fell silent" in answer.result.message
    assert answer.result.sites_visited == 0
