"""Two scan nodes on one robot: neither palpates, and each names the other."""

from __future__ import annotations

from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped

from conftest import SCAN, STAGE, Scanning, activate, driver, goal
from tissue_probe.nodes.qos import POSES
from tissue_probe.nodes.session import NodeProcess


def test_a_scan_is_refused_while_another_scan_node_could_move_its_robot(session):
    running = session(driver(), STAGE, SCAN)
    activate(running)
    other = session(NodeProcess("scan", "second", "/other", {"robot": "/stage"}))
    setpoints = "/stage/servo_cp"
    running.wait_until(lambda: running.node.count_publishers(setpoints) == 2, "both scan nodes")
    answer = Scanning(running, goal()).result()
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert "/other/second could palpate with the robot /stage too" in answer.result.message
    assert answer.result.sites_visited == 0
    other.processes["second"].terminate()
    other.processes.pop("second").wait()
    running.wait_until(lambda: running.node.count_publishers(setpoints) == 1, "its end")
    # A console that could move the robot is no scan node.
    running.node.create_publisher(PoseStamped, setpoints, POSES)
    answer = Scanning(running, goal()).result()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
