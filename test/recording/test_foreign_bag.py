"""Bags of other recorders are read on the force's time, ROS 1 and 2 alike, clocks told of."""

import bags
import numpy as np
import pytest
from numpy.testing import assert_allclose
from rosbags.rosbag1 import Writer as Rosbag1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer
from rosbags.typesys import Stores, get_typestore

import tissue_probe as tp
from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.bags.bag import Topic
from tissue_probe.recording.bags.decoding import Decoder
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout

EPOCH = 1_700_000_000_000_000_000


def indentation(seconds):
    return 1e-3 * (1.0 - np.cos(2.0 * np.pi * 2.0 * seconds))


class Messages:
    """Messages of ROS 1 or 2, made by rosbags."""

    def __init__(self, ros1):
        self.store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
        self.types = self.store.types
        self.ros1 = ros1

    def bytes(self, message):
        write = self.store.serialize_ros1 if self.ros1 else self.store.serialize_cdr
        return bytes(write(message, message.__msgtype__))

    def header(self, stamp):
        number = (0,) if self.ros1 else ()
        time = self.types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9))
        return self.types["std_msgs/msg/Header"](*number, time, "tool")

    def vector(self, z, kind="Vector3"):
        return self.types[f"geometry_msgs/msg/{kind}"](0.1, 0.2, z)

    def wrench(self, stamp, force):
        both = self.types["geometry_msgs/msg/Wrench"](self.vector(force), self.vector(0.0))
        return self.types["geometry_msgs/msg/WrenchStamped"](self.header(stamp), both)

    def pressure(self, stamp):
        """A pressure that grows by 1000 Pa a second."""
        fluid = self.types["sensor_msgs/msg/FluidPressure"]
        return fluid(self.header(stamp), 1e-6 * (stamp - EPOCH), 0.0)

    def position(self, kind, stamp, value):
        point = self.vector(value, "Point")
        match kind:
            case "PoseStamped":
                turned = self.types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
                pose = self.types["geometry_msgs/msg/Pose"](point, turned)
                return self.types["geometry_msgs/msg/PoseStamped"](self.header(stamp), pose)
            case "PointStamped":
                return self.types["geometry_msgs/msg/PointStamped"](self.header(stamp), point)
            case "JointState":
                numbers = np.array([7.0, value])
                state = self.types["sensor_msgs/msg/JointState"]
                return state(self.header(stamp), ["a", "slide"], numbers, numbers, numbers)
            case _:
                return self.types["std_msgs/msg/Float64"](value)


@pytest.fixture
def write(tmp_path):
    """Write a bag: force at 1 kHz, position at 250 Hz, positive up; return its path."""

    def write(kind="PoseStamped", form="mcap", force_delay=0, position_delay=0, force_clock=0):
        ros1 = form == "bag"
        messages = Messages(ros1)
        path = tmp_path / f"run.{form}"
        entries = []
        for time in EPOCH + np.arange(0, 10**9, 10**6):
            force = messages.wrench(
                int(time) + force_clock, -450.0 * indentation((time - EPOCH) / 1e9)
            )
            entries.append(("/ft", int(time) + force_delay, force))
        for time in EPOCH + np.arange(-(10**7), 10**9, 4 * 10**6):
            height = 0.3 - indentation((time - EPOCH) / 1e9)
            entries.append(
                ("/place", int(time) + position_delay, messages.position(kind, int(time), height))
            )
        entries += [
            ("/air", int(time), messages.pressure(int(time)))
            for time in EPOCH + np.arange(-(10**7), 10**9, 2 * 10**7)
        ]
        plugin = StoragePlugin.SQLITE3 if form == "db3" else StoragePlugin.MCAP
        make = (
            Rosbag1Writer(path) if ros1 else Rosbag2Writer(path, version=9, storage_plugin=plugin)
        )
        with make as writer:
            connections = {}
            for topic, time, message in sorted(entries, key=lambda entry: entry[1]):
                name = message.__msgtype__
                if topic not in connections:
                    connections[topic] = writer.add_connection(
                        topic, name, typestore=messages.store
                    )
                writer.write(connections[topic], time, messages.bytes(message))
        return path

    return write


def read(path, position="/place", force="/ft", **stated):
    stated = {"force_polarity": "tension", "position_polarity": "out"} | stated
    return read_any(path, Layout(position=position, force=force, **stated))


@pytest.mark.parametrize("form", ["mcap", "db3", "bag"])
@pytest.mark.parametrize(
    ("kind", "field"),
    [
        ("PoseStamped", ""),
        ("PoseStamped", ".pose.position.z"),
        ("PointStamped", ""),
        ("JointState", ".position[1]"),
        ("JointState", ".position[slide]"),
        ("Float64", ""),
    ],
)
def test_force_and_position_are_brought_to_the_times_of_the_force(form, kind, field, write):
    recording, notes = read(write(kind, form), position="/place" + field)
    (block,) = recording.blocks
    seconds = (block.stamps - EPOCH) / 1e9
    assert_allclose(seconds, np.arange(1000) * 1e-3, atol=1e-9)
    assert_allclose(block.force, 450.0 * indentation(seconds), atol=1e-12)
    inside = seconds <= 0.99
    assert_allclose(block.position[inside], indentation(seconds[inside]) - 0.3, atol=1e-8)
    assert "/ft.wrench.force.z at 1000 Hz" in notes[0]
    assert "at 250 Hz, brought to the times of the force" in notes[0]


@pytest.mark.parametrize("form", ["mcap", "bag"])
def test_a_further_channel_is_at_its_own_times(form, write):
    recording, _ = read(write(form=form), input2="/air")
    (block,) = recording.blocks
    heard = recording.input2.at(block.stamp, np.arange(900) * 1e-3)
    assert_allclose(heard, np.arange(900.0), atol=1e-6)
    assert recording.input2.name == "/air.fluid_pressure"


def test_a_further_channel_without_stamps_goes_by_no_stamps_of_others(write):
    path = write("Float64")
    with pytest.raises(RecordingError, match="read all by the recorder's clock"):
        read(path, force="/air.fluid_pressure", position="/air.variance", input2="/place")


def test_units_are_those_stated(write):
    path = write()
    metres, _ = read(path)
    millimetres, _ = read(path, position_unit="mm", force_unit="mN")
    assert_allclose(millimetres.position, 1e-3 * metres.position)
    assert_allclose(millimetres.force, 1e-3 * metres.force)


def test_delays_that_differ_are_told(write):
    _, (_, note) = read(write(force_delay=2_000_000, position_delay=17_000_000))
    assert "/ft.wrench.force.z was recorded 2 ms after its stamps" in note
    assert "/place.pose.position.z 17 ms" in note
    assert "15 ms apart" in note


def test_equal_delays_are_no_matter(write):
    day = 86_400 * 10**9  # as under simulated time
    _, notes = read(write(force_delay=day, position_delay=day))
    assert len(notes) == 1


def test_stamps_of_clocks_far_apart_give_way_to_the_times_of_recording(write):
    _, notes = read(write(force_clock=-3_600 * 10**9))
    assert "are 3600 s apart: both signals are taken at the times they were recorded" in (notes[1])


def test_without_stamps_the_times_of_recording_count(write):
    _, (_, note) = read(write("Float64"))
    assert "has no stamps: both signals are taken at the times they were recorded" in note


def test_a_first_stamp_of_zero_is_a_stamp(write):
    recording, notes = read(write(force_clock=-EPOCH))
    assert "has no stamps" not in " ".join(notes)
    assert recording.blocks[0].stamp == EPOCH  # the recorder's, since the position is not simulated


def test_what_has_to_be_stated_is_asked_for(write):
    path = write()
    with pytest.raises(RecordingError) as raised:
        read_any(path, Layout())
    assert "state `force` /TOPIC.FIELD (there is /ft.wrench.force.z)" in str(raised.value)
    assert "`position` /TOPIC.FIELD (there is /place.pose.position.z)" in str(raised.value)
    assert "`force_polarity` (compression or tension" in str(raised.value)


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({"force": "/fx"}, "has no topic /fx; give one of /place, /air, /ft"),
        ({"force": "/ft.force"}, "/ft has no number at force; there are header, wrench"),
        ({"force": "/ft.wrench"}, "/ft has no number at wrench; there are force, torque"),
        ({"force_unit": "stone"}, "unit 'stone' is not known"),
    ],
)
def test_what_is_not_there_is_refused_with_what_there_is(stated, said, write):
    with pytest.raises(ValueError) as raised:  # noqa: PT011
        read(write(), **stated)
    assert said in str(raised.value)


def test_topics_that_never_overlap_are_refused(write):
    with pytest.raises(RecordingError, match="never recorded at the same time"):
        read(write("Float64", position_delay=10**12))


def test_a_recording_of_the_suite_takes_no_statements(run, blocks):
    recording, _ = read_any(run, Layout())
    assert len(recording) == 10 * len(blocks)
    with pytest.raises(RecordingError, match="leave out the options"):
        read_any(run, Layout(force_polarity="tension"))


@pytest.mark.parametrize("name", ["test_bag_mcap", "test_bag_sqlite3"])
def test_wrenches_of_foreign_recorders_are_read(name, foreign_bags):
    stated = {"force": "/test/geometry_msgs/wrench_stamped", "force_polarity": "compression"}
    layout = Layout(position="/test/geometry_msgs/point_stamped", **stated)
    recording, _ = read_any(foreign_bags / "rosbags-rs" / name, layout)
    assert recording.force[0] == 2.0


def test_a_foreign_ros1_bag_is_read(foreign_bags):
    layout = Layout(
        force="/imu/data.linear_acceleration.z",
        position="/jackal_velocity_controller/odom.pose.pose.position.x",
        force_polarity="compression",
    )
    recording, _ = read_any(foreign_bags / "ros1" / "test2.bag", layout)
    assert 9.0 < np.median(recording.force) < 11.0


@pytest.mark.parametrize("typename", ["WrenchStamped", ""])
def test_a_type_without_a_package_is_refused_in_a_sentence(typename):
    with pytest.raises(RecordingError, match=r"x\.mcap: /ft has the type .* names no package"):
        Decoder(Topic("/ft", typename, "", "ros2msg", "cdr"), "x.mcap")


def test_a_force_at_uneven_times_keeps_its_samples_and_its_noise_stays_white(tmp_path):
    random = np.random.default_rng(0)
    times = np.arange(0.01, 6.0, 2e-3)
    times += 3e-4 * np.clip(random.standard_normal(times.size), -2.0, 2.0)
    stamps = EPOCH + np.rint(1e9 * times).astype(np.int64)
    noisy = bags.force((stamps - EPOCH) / 1e9) + 5e-3 * random.standard_normal(times.size)
    felt = stamps + 200_000, stamps, [(bags.wrench, float(value)) for value in noisy]
    moved = bags.position_channel(rate=500.0, seconds=6.2)
    path = bags.write_bag(tmp_path / "uneven", {"/ft": felt, "/place": moved})
    stated = {"force_polarity": "compression", "position_polarity": "into"}
    recording, _ = read(path, **stated)
    known = np.isfinite(recording.own.position)
    assert_allclose(recording.own.force[known], noisy[known])
    run = tp.read(path, position="/place", force="/ft", **stated)
    answer = tp.diagnose(run, rig="rigid_probe", constants={"tip_mass": 0.0}).to_dict()
    assert answer["verdict"] == "adequate"
    assert answer["noise_floor"] == pytest.approx(5e-3, rel=0.05)
    values = answer["ladder"][0]["parameters"]
    assert values["stiffness"]["value"] == pytest.approx(bags.STIFFNESS, rel=2e-3)
    assert values["damping"]["value"] == pytest.approx(bags.DAMPING, rel=5e-2)
