"""The sensor node on an arm that shares no code with us: identify, compensate, zero anew."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, WrenchStamped
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from conftest import Acting, ask, collect, fails_with, foreign_process, tell
from tissue_probe.nodes.qos import PER_SAMPLE
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.sensor.compensation import parse
from tissue_probe_msgs.action import IdentifySensor

MASS, NOISE, PUSH = 0.8, 0.1, 3.0


def sensor(**parameters: object) -> NodeProcess:
    topics = {"pose": "/arm/pose", "wrench": "/arm/wrench"}
    return NodeProcess("sensor", "sensor", parameters={**topics, **parameters})


@pytest.fixture
def arm() -> Iterator:
    with foreign_process("foreign_sensor.py") as process:
        yield process


def forces(messages: list) -> np.ndarray:
    return np.array([[m.wrench.force.x, m.wrench.force.y, m.wrench.force.z] for m in messages])


def told(running, sentence: str) -> None:
    heard = collect(running.node, DiagnosticArray, "/diagnostics")
    running.wait_until(
        lambda: any(sentence in s.message for array in heard for s in array.status), sentence
    )


@pytest.mark.crowded
def test_it_identifies_then_publishes_the_wrench_that_is_left(session, arm):
    running = session(sensor())
    told(running, "there is no model: identify the sensor")
    acting = Acting(running, IdentifySensor, "identify_sensor", IdentifySensor.Goal(seconds=14.0))
    running.wait_until(lambda: acting.feedback and acting.feedback[-1].seconds > 3.0, "feedback")
    poses = collect(running.node, PoseStamped, "/arm/pose", PER_SAMPLE)
    tell(arm, "silent")  # a hole, with which the first look has too little
    running.wait_until(lambda: len(poses) > 500, "poses of the hole")
    tell(arm, "well")
    answer = acting.result()
    found = answer.result
    assert answer.status == GoalStatus.STATUS_SUCCEEDED, found.message
    assert found.verdict == "adequate", found.missing_effects
    numbers = {number.name: number for number in found.numbers}
    assert abs(numbers["mass"].value - MASS) < 4.0 * numbers["mass"].deviation
    assert acting.feedback[-1].seconds > 5.0
    assert parse(found.model).load[0] == pytest.approx(numbers["mass"].value)
    left = collect(running.node, WrenchStamped, "/probe/compensated", PER_SAMPLE)
    running.wait_until(lambda: len(left) > 500, "compensated wrenches")
    free = forces(left[:500])
    assert np.sqrt(np.mean(free**2)) < 1.5 * NOISE
    assert np.abs(free.mean(axis=0)).max() < 0.05
    zero = ask(running, Trigger, "/probe/sensor/re_zero")
    assert zero.success, zero.message
    tell(arm, "push")
    before = len(left)
    running.wait_until(lambda: len(left) > before + 500, "wrenches of the push")
    assert forces(left[-50:])[:, 2].mean() == pytest.approx(PUSH, abs=0.1)
    tell(arm, "back")
    between = left[-1].header.stamp.sec - 1800
    running.wait_until(
        lambda: left[-400].header.stamp.sec < between, "wrenches by a clock that was set back"
    )
    zero = ask(running, Trigger, "/probe/sensor/re_zero")
    assert zero.success, zero.message
    tell(arm, "nan")
    told(running, "/arm/wrench is not finite; left out")
    tell(arm, "silent")
    told(running, "nothing of use comes on /arm/wrench")


@pytest.mark.crowded
def test_an_identification_ends_in_a_sentence_where_the_wrench_stops_or_it_is_cancelled(
    session, arm
):
    running = session(sensor())
    wanted = IdentifySensor.Goal(seconds=100.0)
    acting = Acting(running, IdentifySensor, "identify_sensor", wanted)
    running.wait_until(lambda: bool(acting.feedback), "feedback")
    cancel = acting.handle.cancel_goal_async()
    running.wait_until(cancel.done, "the cancel")
    assert acting.result().status == GoalStatus.STATUS_CANCELED
    acting = Acting(running, IdentifySensor, "identify_sensor", wanted)
    running.wait_until(lambda: bool(acting.feedback), "feedback")
    tell(arm, "silent")
    answer = acting.result()
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert "nothing of use comes on /arm/wrench" in answer.result.message
    tell(arm, "boot")
    told(running, "there is no model")
    answer = Acting(running, IdentifySensor, "identify_sensor", wanted).result()
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert "their stamps do not overlap: use one clock" in answer.result.message


def test_a_joint_without_a_position_is_told_and_nothing_ends(session):
    running = session(sensor(joints=["elbow"]))
    publisher = running.node.create_publisher(JointState, "/joint_states", PER_SAMPLE)
    heard = collect(running.node, DiagnosticArray, "/diagnostics")

    def is_told() -> bool:
        message = JointState(name=["elbow"])
        message.header.stamp.sec = 1
        publisher.publish(message)
        sentence = "/joint_states has a joint without a position; left out"
        return any(sentence in s.message for array in heard for s in array.status)

    running.wait_until(is_told, "the sentence")
    count = len(heard)
    running.wait_until(lambda: len(heard) > count, "its diagnostics after that")


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"model": "nowhere.yaml"}, "nowhere.yaml: No such file"),
        ({"joints": ["a", "b", "c", "d"]}, "joints names 4: give 3 at most"),
        ({"late": 2.0}, "late"),
    ],
)
def test_wrong_parameters_end_it_in_a_sentence(given, sentence):
    assert sentence in fails_with(sensor(**given))
