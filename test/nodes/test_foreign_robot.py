"""Scan and map on a robot that shares no code with us: CRTK over Eclipse Cyclone DDS."""

from __future__ import annotations

import json

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from lifecycle_msgs.msg import Transition

from conftest import (
    PATIENCE,
    PATIENT,
    Scanning,
    activate,
    change_state,
    collect,
    command,
    deactivate,
    driver,
    estimator,
    goal,
    say,
)
from crtk_msgs.msg import OperatingState
from tissue_probe.nodes.qos import LATCHED, POSES
from tissue_probe.nodes.session import NodeProcess
from tissue_probe_msgs.action import ScanGrid
from tissue_probe_msgs.msg import StiffnessMap

ROBOT = "/dvrk/PSM1"


def states_of(running, namespace: str) -> list[OperatingState]:
    return collect(running.node, OperatingState, f"{namespace}/operating_state", LATCHED)


def scan(running) -> ScanGrid.Result:
    return Scanning(running, goal(dwell_time=0.5)).result()


@pytest.fixture
def best_effort(monkeypatch) -> None:
    """The robot that is started next publishes its poses best effort."""
    monkeypatch.setenv("BEST_EFFORT", "1")


def test_a_foreign_robot_is_heard_that_publishes_its_poses_best_effort(session, best_effort, robot):
    running = session(
        driver(stage_pose=f"{ROBOT}/measured_cp"),
        NodeProcess("scan", "scan", parameters={**PATIENT, "robot": ROBOT, "samples_timeout": 3.0}),
    )
    activate(running)
    command(running, ROBOT, "enable", "ENABLED")
    done = scan(running)
    assert done.status == GoalStatus.STATUS_SUCCEEDED, done.result.message


def test_a_foreign_robot_carries_the_probe_over_the_phantom_and_the_map_is_right(session, robot):
    running = session(
        driver(stage_pose=f"{ROBOT}/measured_cp"),
        NodeProcess("scan", "scan", parameters={**PATIENT, "robot": ROBOT, "samples_timeout": 3.0}),
        estimator("robust_ekf", restart_at_site=False),
        NodeProcess("mapper", "mapper", parameters={"estimators": ["robust_ekf"]}),
    )
    maps = collect(running.node, StiffnessMap, "/probe/stiffness_map", LATCHED)
    states = states_of(running, ROBOT)
    running.activate({"/probe/driver": 2, "/probe/robust_ekf": 1})

    running.wait_until(lambda: bool(states), "the robot's state")
    assert states[-1].state == "DISABLED"
    refused = scan(running)
    assert refused.status == GoalStatus.STATUS_ABORTED
    assert "/dvrk/PSM1 is DISABLED: it moves only when it is ENABLED" in refused.result.message

    command(running, ROBOT, "enable", "ENABLED")
    done = scan(running)
    assert done.status == GoalStatus.STATUS_SUCCEEDED, done.result.message
    running.wait_until(
        lambda: maps and np.isfinite(maps[-1].stiffness[:2]).all(), "both cells of the map"
    )
    assert maps[-1].stiffness[:2] == pytest.approx([450.0, 450.0], rel=0.1)

    answer, _ = robot.communicate("stop\n", timeout=PATIENCE)
    told = json.loads(answer)
    assert set(told["commands"]) == {"enable"}
    assert told["setpoints"] > 100
    assert told["turned"] == 0, "the scan turned the robot's tool"
    assert np.all(np.diff(told["stamps"]) > 0)
    assert min(told["depth"]) == 0.0
    # What it did not ask for, that the scan shows to be alive, does not keep it from hearing.
    assert told["phases"] == 2 * [0, 1, 2]


def test_the_driver_is_a_crtk_device_too(session):
    running = session(driver())
    states = states_of(running, "/probe")
    running.wait_until(lambda: bool(states), "the driver's state")
    assert (states[-1].state, states[-1].is_busy) == ("DISABLED", False)
    refused = "it knows enable, once configured"
    say(running, "/probe", "enable", lambda: refused in running.whole_log("driver"))
    activate(running)
    running.wait_until(lambda: states[-1].state == "ENABLED", "the driver to be active")
    assert states[-1].is_busy
    deactivate(running)
    running.wait_until(lambda: states[-1].state == "DISABLED", "the driver to be inactive")


def test_the_driver_is_enabled_and_disabled_by_state_command(session):
    running = session(driver())
    assert change_state(running, Transition.TRANSITION_CONFIGURE)
    command(running, "/probe", "enable", "ENABLED")
    command(running, "/probe", "disable", "DISABLED")


def test_a_fault_is_a_crtk_fault(session):
    running = session(driver(limits__travel_limit=1e-4))
    states = states_of(running, "/probe")
    activate(running)
    running.wait_until(lambda: any(state.state == "FAULT" for state in states), "the fault")


def test_the_stage_moves_only_while_it_is_enabled(session):
    running = session(NodeProcess("stage", "stage", "/stage"))
    poses = collect(running.node, PoseStamped, "/stage/measured_cp", POSES)
    setpoints = running.node.create_publisher(PoseStamped, "/stage/servo_cp", POSES)
    running.wait_until(lambda: setpoints.get_subscription_count() == 1, "the stage")

    def ask_for(x: float) -> int:
        setpoint = PoseStamped()
        setpoint.pose.position.x = x
        setpoints.publish(setpoint)
        return len(poses)

    command(running, "/stage", "pause", "PAUSED")
    count = ask_for(0.01)
    running.wait_until(lambda: len(poses) > count + 30, "poses")
    assert poses[-1].pose.position.x == 0.0
    command(running, "/stage", "resume", "ENABLED")
    ask_for(0.01)
    running.wait_until(lambda: poses[-1].pose.position.x == pytest.approx(0.01), "the motion")
    say(running, "/stage", "home", lambda: "'home' is no command" in running.whole_log("stage"))
