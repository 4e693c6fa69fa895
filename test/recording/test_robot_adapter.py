"""Frames, directions and units of a robot; a bag of its topics by the node's parameter file."""

from __future__ import annotations

import math
from types import SimpleNamespace as Message

import numpy as np
import pytest
from bags import EPOCH, STORE, TYPES, header
from rosbags.rosbag2 import StoragePlugin, Writer
from scipy.spatial.transform import Rotation

from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout
from tissue_probe.recording.robot.adapter import Adapter
from tissue_probe.recording.robot.pressing import Pressing
from tissue_probe.recording.robot.settings import RobotDescription
from tissue_probe.settings import SettingsError

PRESSED, FORCE = 2e-3, 3.0
PLACE = np.array([0.4, -0.2, 0.3])
TOOL = Rotation.from_euler("xyz", [2.7, 0.3, -0.8])
SENSOR = Rotation.from_euler("xyz", [0.4, -1.1, 2.0])
INTO = np.array([0.6, 0.0, -0.8])


def pressed(axis_frame: str, force_axes: str, polarity: str) -> tuple[float, float]:
    """Press along INTO by PRESSED with FORCE and some across; return what comes of it."""
    axis = TOOL.inv().apply(INTO) if axis_frame == "tool" else INTO
    across = np.cross(INTO, [0.3, 1.0, 0.2])
    on_tissue = FORCE * INTO + across
    told = on_tissue if polarity == "compression" else -on_tissue
    in_axes = TOOL.inv().apply(told) if force_axes == "tool" else told
    pressing = Pressing(
        RobotDescription(
            axis=list(axis),
            axis_frame=axis_frame,
            force_axes=force_axes,
            force_rotation=list(SENSOR.as_quat()),
            force_polarity=polarity,
            zero=list(PLACE),
        )
    )
    place = PLACE + PRESSED * INTO + 1e-3 * across
    (u, *direction), _ = pressing.pose(tuple(place), tuple(TOOL.as_quat()))
    force = pressing.force(tuple(SENSOR.inv().apply(in_axes)))
    return u, float(np.dot(direction, force))


@pytest.mark.parametrize("axis_frame", ["tool", "base"])
@pytest.mark.parametrize("force_axes", ["tool", "base"])
@pytest.mark.parametrize("polarity", ["compression", "tension"])
def test_displacement_and_force_are_those_along_the_axis_in_whatever_frames(
    axis_frame, force_axes, polarity
):
    u, force = pressed(axis_frame, force_axes, polarity)
    assert u == pytest.approx(PRESSED, rel=1e-9)
    assert force == pytest.approx(FORCE, rel=1e-9)


def test_a_turn_of_the_tool_about_the_zero_is_no_displacement():
    pressing = Pressing(RobotDescription(force_polarity="compression"))
    for angle in (0.0, 0.2, 0.4):
        (u, *_), _ = pressing.pose(tuple(PLACE), (math.sin(angle), 0.0, 0.0, math.cos(angle)))
        assert u == pytest.approx(0.0, abs=1e-12)


def test_an_orientation_counts_only_where_it_is_needed():
    none = (0.0, 0.0, 0.0, 0.0)
    fixed = {"axis_frame": "base", "force_axes": "base", "force_polarity": "compression"}
    Pressing(RobotDescription(**fixed)).pose(tuple(PLACE), none)
    with pytest.raises(ValueError, match="a quaternion has length 1"):
        Pressing(RobotDescription(force_polarity="compression")).pose(tuple(PLACE), none)


def test_the_polarity_must_be_stated():
    with pytest.raises(SettingsError, match="press on something by hand"):
        Pressing(RobotDescription())


def joint_state(stamp: int, names, positions) -> Message:
    at = Message(sec=stamp // 10**9, nanosec=stamp % 10**9)
    return Message(header=Message(stamp=at, frame_id=""), name=names, position=positions)


def wrench(stamp: int, z: float, frame: str = "ft") -> Message:
    at = Message(sec=stamp // 10**9, nanosec=stamp % 10**9)
    force = Message(x=0.1, y=0.0, z=z)
    return Message(header=Message(stamp=at, frame_id=frame), wrench=Message(force=force))


def test_a_joint_is_a_travel_among_joints_of_others():
    adapter = Adapter(
        RobotDescription(
            joint="slide",
            joint_travel=-0.5,
            position_rate=100.0,
            force_polarity="compression",
            zero=[1.0],
        )
    )
    for number in range(20):
        stamp = EPOCH + number * 10_000_000
        adapter.take_position(joint_state(stamp, ["finger"], [9.0]))
        adapter.take_position(joint_state(stamp, ["elbow", "slide"], [7.0, 1.0 + 0.001 * number]))
        adapter.take_force(wrench(stamp, 2.0 + number))
    (block,) = adapter.samples()
    numbers = (block.stamps - EPOCH) / 10_000_000
    np.testing.assert_allclose(block.position, -0.5e-3 * numbers, atol=1e-12)
    np.testing.assert_allclose(block.force, 2.0 + numbers, atol=1e-9)
    assert not adapter.position.faults
    assert adapter.joints == {"finger", "elbow", "slide"}


def test_messages_of_no_use_are_left_out_and_named():
    adapter = Adapter(RobotDescription(force_polarity="compression", force_frame="ft"))
    adapter.take_force(wrench(EPOCH, math.inf))
    adapter.take_force(wrench(EPOCH, 1.0, frame="camera"))
    adapter.take_force(wrench(0, 1.0))
    faults = adapter.force.faults
    assert faults["other frames"].sentence.endswith("in frame 'camera', not in 'ft': left out")
    assert faults["unusable"].count == 2
    assert "has no stamps" in faults["unusable"].sentence


@pytest.fixture
def robot_bag(tmp_path):
    """Two seconds of a pose and a wrench, and the parameters of the node for them."""
    path = tmp_path / "run"
    turned = TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    zero = TYPES["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        kinds = {"/robot/measured_cp": "PoseStamped", "/robot/measured_cf": "WrenchStamped"}
        opened = {
            topic: writer.add_connection(topic, f"geometry_msgs/msg/{kind}", typestore=STORE)
            for topic, kind in kinds.items()
        }
        for number in range(800):
            stamp = EPOCH + number * 2_500_000
            u = 1e-3 * math.sin(number / 20.0)
            point = TYPES["geometry_msgs/msg/Point"](0.0, 0.0, u)
            pose = TYPES["geometry_msgs/msg/Pose"](point, turned)
            force = TYPES["geometry_msgs/msg/Vector3"](0.1, 0.2, 300.0 * u)
            felt = TYPES["geometry_msgs/msg/Wrench"](force, zero)
            for topic, content in (("/robot/measured_cp", pose), ("/robot/measured_cf", felt)):
                kind = f"geometry_msgs/msg/{kinds[topic]}"
                message = TYPES[kind](header(stamp, "base"), content)
                writer.write(opened[topic], stamp, bytes(STORE.serialize_cdr(message, kind)))
    settings = tmp_path / "robot.yaml"
    settings.write_text(
        "/probe/adapter:\n  ros__parameters:\n    position_rate: 400.0\n    force_rate: 400.0\n"
        "    force_polarity: compression\n    frame_id: probe\n"
    )
    return path, settings


def test_a_bag_is_read_by_the_parameter_file_of_the_node(robot_bag):
    path, settings = robot_bag
    recording, notes = read_any(path, Layout(adapter=str(settings)))
    (block,) = recording.blocks
    assert block.sample_period == 0.0025
    assert len(block) == 797
    np.testing.assert_allclose(block.force, 300.0 * (block.position), atol=1e-9)
    assert "797 samples in 1 run, of /robot/measured_cp and /robot/measured_cf" in notes[0]


def test_a_file_that_is_none_and_a_topic_that_is_missing_are_told(robot_bag, tmp_path):
    path, settings = robot_bag
    other = tmp_path / "other.yaml"
    other.write_text("a: 1\n")
    with pytest.raises(RecordingError, match="no parameters of the node adapter"):
        read_any(path, Layout(adapter=str(other)))
    settings.write_text(settings.read_text() + "    force: /ft\n")
    with pytest.raises(RecordingError, match="has no topic /ft; its topics are"):
        read_any(path, Layout(adapter=str(settings)))
    settings.write_text(settings.read_text().replace("400.0", "4.0"))
    with pytest.raises(RecordingError, match="give a number from 10 to 4000"):
        read_any(path, Layout(adapter=str(settings)))
