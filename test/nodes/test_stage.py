"""The simulated stage goes where it is told, within its workspace."""

from __future__ import annotations

import pytest
from geometry_msgs.msg import PoseStamped

from conftest import collect, fails_with
from tissue_probe.nodes.qos import POSES
from tissue_probe.nodes.session import NodeProcess


def test_the_stage_refuses_a_setpoint_below_its_workspace(session):
    running = session(NodeProcess("stage", "stage", "/stage", {"lowest": -0.002, "z": 0.001}))
    poses = collect(running.node, PoseStamped, "/stage/measured_cp", POSES)
    setpoints = running.node.create_publisher(PoseStamped, "/stage/servo_cp", POSES)
    running.wait_until(lambda: setpoints.get_subscription_count() == 1, "the stage")

    def ask_for(x: float, z: float) -> None:
        setpoint = PoseStamped()
        setpoint.pose.position.x, setpoint.pose.position.z = x, z
        setpoints.publish(setpoint)

    ask_for(0.01, -0.0021)
    running.wait_until(lambda: "refused" in running.whole_log("stage"), "the log")
    assert "z = -2.10 mm is refused: the workspace ends at -2.00 mm" in running.whole_log("stage")
    # What comes after is followed, so what was refused is seen not to have been.
    ask_for(0.0, -0.0019)
    running.wait_until(lambda: poses[-1].pose.position.z == pytest.approx(-0.0019), "the motion")
    assert {pose.pose.position.x for pose in poses} == {0.0}
    assert min(pose.pose.position.z for pose in poses) >= -0.0019 - 1e-12


def test_a_stage_that_would_begin_below_its_workspace_is_refused():
    told = fails_with(NodeProcess("stage", "stage", "/stage", {"z": -0.01}))
    assert "z is -0.01 m, below the workspace: give -0.003 up" in told
