"""Bags of a force and a position as other recorders make them, with clocks that go wrong."""

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

EPOCH = 1_700_000_000_000_000_000
STORE = get_typestore(Stores.ROS2_JAZZY)
TYPES = STORE.types
STIFFNESS, DAMPING = 300.0, 4.0


def u(seconds):
    """Two sines, of a millimetre together, in metres."""
    return 5e-4 * (np.sin(2 * np.pi * 2.0 * seconds) + np.sin(2 * np.pi * 3.1 * seconds))


def force(seconds):
    """The force of Kelvin-Voigt tissue under u, in newtons."""
    speed = (
        5e-4
        * 2
        * np.pi
        * (2.0 * np.cos(2 * np.pi * 2.0 * seconds) + 3.1 * np.cos(2 * np.pi * 3.1 * seconds))
    )
    return STIFFNESS * u(seconds) + DAMPING * speed


def wrench(stamp, value, frame="tool"):
    zero = TYPES["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    both = TYPES["geometry_msgs/msg/Wrench"](
        TYPES["geometry_msgs/msg/Vector3"](0.1, 0.2, value), zero
    )
    return TYPES["geometry_msgs/msg/WrenchStamped"](header(stamp, frame), both)


def pose(stamp, value, frame="base"):
    turned = TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    point = TYPES["geometry_msgs/msg/Point"](0.1, 0.2, value)
    both = TYPES["geometry_msgs/msg/Pose"](point, turned)
    return TYPES["geometry_msgs/msg/PoseStamped"](header(stamp, frame), both)


def header(stamp, frame):
    time = TYPES["builtin_interfaces/msg/Time"](*divmod(int(stamp), 10**9))
    return TYPES["std_msgs/msg/Header"](time, frame)


def cdr(message):
    return bytes(STORE.serialize_cdr(message, message.__msgtype__))


def channel(make, values, rate, seconds=6.0, begin=0.0, delay=200_000):
    """Return (log time, stamp, message) of each sample: what ``clocks`` then change."""
    times = begin + np.arange(0.0, seconds, 1.0 / rate)
    logged = EPOCH + np.rint(times * 1e9).astype(np.int64)
    return logged + delay, logged.copy(), [(make, float(value)) for value in values(times)]


def force_channel(rate=500.0, **options):
    return channel(wrench, force, rate, **options)


def position_channel(rate=250.0, **options):
    return channel(pose, u, rate, begin=0.0013, **options)


def write_bag(path, topics, plugin=StoragePlugin.MCAP):
    """Write channels by topic, in the order of their true times, whatever their clocks say."""
    entries = []
    for topic, (logged, stamps, messages) in topics.items():
        true = np.linspace(0.0, 1.0, len(messages))
        entries += [(*row, topic) for row in zip(true, logged, stamps, messages, strict=True)]
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        connections = {}
        for _, log_time, stamp, (make, value), topic in sorted(entries, key=lambda row: row[0]):
            message = make(stamp, value)
            if topic not in connections:
                connections[topic] = writer.add_connection(
                    topic, message.__msgtype__, typestore=STORE
                )
            writer.write(connections[topic], int(log_time), cdr(message))
    return path


def fitted(recording):
    """Return stiffness and damping by least squares over all blocks."""
    rows, forces = [], []
    for block in recording.blocks:
        known = np.isfinite(block.position) & np.isfinite(block.force)
        position = np.where(known, block.position, 0.0)
        speed = np.gradient(position, block.sample_period)
        inner = known & np.roll(known, 3) & np.roll(known, -3)
        inner[:4] = inner[-4:] = False
        rows.append(np.column_stack([position[inner], speed[inner], np.ones(inner.sum())]))
        forces.append(block.force[inner])
    (k, beta, _), *_ = np.linalg.lstsq(np.concatenate(rows), np.concatenate(forces))
    return k, beta
