"""What a robot of somebody else publishes is heard by what it offers, or refused by its name."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Pose, PoseStamped
from lifecycle_msgs.msg import Transition
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from std_msgs.msg import Bool, String

from conftest import PATIENT, Scanning, activate, change_state, collect, driver, goal
from tissue_probe.nodes.hearing import Hearing
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.qos import LATCHED, POSES
from tissue_probe.nodes.session import NodeProcess
from tissue_probe_msgs.msg import ProbeSamples

RELIABLE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
#: Kept waiting by a busy machine, the robot of a test may be later than a theatre could allow.
SCAN_ON_UR = NodeProcess("scan", "scan", parameters={**PATIENT, "robot": "/ur"})
#: Where the robot is missing, nobody is waited for in vain for longer than this [s].
HASTY_SCAN = NodeProcess(
    "scan", "scan", parameters={**PATIENT, "robot": "/ur", "samples_timeout": 3.0}
)


@contextmanager
def robot(qos: QoSProfile, kind: type = PoseStamped) -> Iterator[None]:
    """A robot at /ur that is where it was told to be, and publishes its poses with a quality."""
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("robot", namespace="/ur", context=context)
    poses = node.create_publisher(kind, "measured_cp", qos)
    told = PoseStamped()
    told.pose.position.z, told.pose.orientation.w = 0.003, 1.0
    setpoints = [told]
    node.create_subscription(PoseStamped, "servo_cp", setpoints.append, qos_profile_sensor_data)
    node.create_subscription(ProbeSamples, "/probe/samples", lambda block: None, POSES)
    node.create_timer(
        0.01, lambda: poses.publish(setpoints[-1] if kind is PoseStamped else setpoints[-1].pose)
    )
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin)
    thread.start()
    try:
        yield
    finally:
        executor.shutdown()
        thread.join()
        node.destroy_node()
        rclpy.shutdown(context=context)


@pytest.mark.parametrize(
    "qos", [qos_profile_sensor_data, RELIABLE], ids=["best effort", "reliable"]
)
def test_a_robot_is_heard_by_scan_and_driver_with_the_quality_that_it_offers(session, qos):
    with robot(qos):
        running = session(driver(stage_pose="/ur/measured_cp"), SCAN_ON_UR)
        samples = collect(running.node, ProbeSamples, "/probe/samples")
        activate(running)
        answer = Scanning(running, goal()).result()
        assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message
        assert answer.result.sites_visited == 2
        # Above the tissue the load cell shows noise alone, by what the driver heard of the robot.
        largest = [max(map(abs, block.force)) for block in samples]
        assert min(largest) < 0.05 < 0.2 < max(largest)


def test_a_robot_that_comes_back_with_another_quality_is_heard_anew(session):
    running = session(driver(stage_pose="/ur/measured_cp"), SCAN_ON_UR)
    activate(running)
    for qos in (RELIABLE, qos_profile_sensor_data, RELIABLE):
        with robot(qos):
            answer = Scanning(running, goal()).result()
            assert answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.message


def test_poses_of_another_type_are_named_by_scan_and_driver(session):
    with robot(RELIABLE, Pose):
        running = session(driver(stage_pose="/ur/measured_cp"), HASTY_SCAN)
        assert change_state(running, Transition.TRANSITION_CONFIGURE)
        running.wait_for_subscribers({"/probe/driver": 2})  # it has found the scan and the robot
        assert not change_state(running, Transition.TRANSITION_ACTIVATE)
        wrong = (
            "/ur/measured_cp: /ur/robot publishes it as geometry_msgs/msg/Pose, not as "
            "geometry_msgs/msg/PoseStamped"
        )
        running.wait_until(lambda: wrong in running.whole_log("driver"), "the driver's reason")
        answer = Scanning(running, goal()).result()
        assert answer.status == GoalStatus.STATUS_ABORTED
        assert f"the robot /ur is not heard on {wrong}" in answer.result.message


def test_a_robot_that_is_not_there_is_told_as_that(session):
    running = session(driver(), HASTY_SCAN)
    activate(running)
    answer = Scanning(running, goal()).result()
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert "not heard on /ur/measured_cp: no node publishes it" in answer.result.message


def test_poses_that_are_no_places_are_told_as_that(session):
    running = session(driver(), HASTY_SCAN)
    activate(running)
    poses = running.node.create_publisher(PoseStamped, "/ur/measured_cp", POSES)
    wrong = PoseStamped()
    wrong.pose.position.x = float("nan")
    running.node.create_timer(0.01, lambda: poses.publish(wrong))
    answer = Scanning(running, goal()).result()
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert "a pose of the robot /ur is left out" in answer.result.message


def test_an_emergency_stop_that_is_published_best_effort_stops_the_coil(session):
    running = session(driver())
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    activate(running)
    stop = running.node.create_publisher(Bool, "/probe/emergency_stop", qos_profile_sensor_data)
    running.node.create_timer(0.05, lambda: stop.publish(Bool(data=True)))
    running.wait_until(lambda: faults and faults[-1].data, "the fault")
    assert "true came on the topic emergency_stop" in faults[-1].data


def test_reliable_delivery_is_asked_for_again_once_it_is_offered_by_all(graph):
    inbox = Inbox(graph.node)
    heard: list = []
    hearing: Hearing = inbox.subscribe(Bool, "/word", POSES, lambda word, _: heard.append(word))

    def asks_for() -> ReliabilityPolicy:
        inbox.empty()
        return hearing.subscription.qos_profile.reliability

    best_effort = graph.node.create_publisher(Bool, "/word", qos_profile_sensor_data)
    graph.wait_until(lambda: asks_for() == ReliabilityPolicy.BEST_EFFORT)
    reliable = graph.node.create_publisher(Bool, "/word", RELIABLE)
    for publisher in (best_effort, reliable):
        graph.wait_until(lambda who=publisher: who.get_subscription_count() == 1)
        before = len(heard)
        publisher.publish(Bool(data=True))
        graph.wait_until(lambda count=before: inbox.empty() and len(heard) > count)
    graph.node.destroy_publisher(best_effort)
    graph.wait_until(lambda: asks_for() == ReliabilityPolicy.RELIABLE)
    inbox.destroy()


def test_who_keeps_nothing_is_heard_by_who_wants_what_is_kept_and_nothing_comes_twice(graph):
    inbox = Inbox(graph.node)
    heard: list = []
    inbox.subscribe(String, "/word", LATCHED, lambda word, _: heard.append(word.data))

    def hears(word: str) -> bool:
        inbox.empty()
        return word in heard

    kept = graph.node.create_publisher(String, "/word", LATCHED)
    kept.publish(String(data="kept"))
    graph.wait_until(lambda: hears("kept"))
    passing = graph.node.create_publisher(String, "/word", RELIABLE)

    def says() -> bool:
        passing.publish(String(data="passing"))
        return hears("passing")

    graph.wait_until(says)
    graph.node.destroy_publisher(passing)
    graph.wait_until(lambda: graph.node.count_publishers("/word") == 1)
    kept.publish(String(data="later"))
    graph.wait_until(lambda: hears("later"))
    assert heard.count("kept") == 1
    inbox.destroy()
