"""Long recordings: columns are not copied without need, and how much is read is told."""

import tracemalloc

import numpy as np
import pyarrow
import pytest
from bags import force_channel, position_channel, write_bag
from pyarrow import parquet
from rosbags.rosbag1 import Writer as Rosbag1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.typesys import Stores, get_typestore

from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.bags.open_bag import open_bag
from tissue_probe.recording.bags.samples_bag import write_samples_bag
from tissue_probe.recording.layout import Layout
from tissue_probe.signals import SampleBlock

ROWS = 400_000
#: Three columns of float64, three times [bytes a row].
MOST = 3 * 8 * 3
TIME = np.arange(ROWS) * 5e-4
JITTER = np.random.default_rng(0).uniform(-5e-5, 5e-5, ROWS)
POSITION = 1e-3 * np.sin(62.8 * TIME)
FORCE = 450.0 * POSITION + 0.01 * np.sin(1e3 * TIME)
COUNTS = np.rint(POSITION / 1e-8).astype(np.int64)


@pytest.mark.parametrize(
    ("time", "position", "stated"),
    [
        (TIME, POSITION, {}),
        (TIME + JITTER, POSITION, {}),
        (TIME, COUNTS % 2**16, {"position_unit": "1e-8"}),
        (np.rint(TIME * 1e6).astype(np.int64), POSITION, {"time_unit": "us"}),
    ],
    ids=["even", "jittering", "counter", "whole microseconds"],
)
def test_columns_are_held_three_times_at_most(time, position, stated, tmp_path):
    path = tmp_path / "long.parquet"
    parquet.write_table(pyarrow.table({"t": time, "u": position, "F": FORCE}), path)
    read_any(path, Layout(**stated))  # what is loaded once is not of the file
    tracemalloc.start()
    recording, _ = read_any(path, Layout(**stated))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(recording) >= ROWS - 1
    assert peak < MOST * ROWS


def test_a_spline_by_pieces_is_that_through_all(tmp_path):
    path = tmp_path / "long.parquet"
    columns = {"t": TIME + JITTER, "u": 1e-3 * np.sin(62.8 * (TIME + JITTER)), "F": FORCE}
    parquet.write_table(pyarrow.table({name: v[:50_000] for name, v in columns.items()}), path)
    (block,) = read_any(path, Layout())[0].blocks
    times = TIME[0] + JITTER[0] + block.sample_period * np.arange(len(block))
    assert np.abs(block.position - 1e-3 * np.sin(62.8 * times))[5:-5].max() < 1e-9


def ros1_bag(path):
    store = get_typestore(Stores.ROS1_NOETIC)
    kind = "std_msgs/msg/Float64"
    with Rosbag1Writer(path) as writer:
        for topic in ("/ft", "/pose"):
            connection = writer.add_connection(topic, kind, typestore=store)
            for number in range(3000):
                message = store.types[kind](np.sin(0.01 * number))
                writer.write(connection, 10**9 * 1000 + number * 10**6,
                             store.serialize_ros1(message, kind))  # fmt: skip
    return path


def foreign(path, plugin):
    channels = {
        "/ft": force_channel(seconds=3.0, rate=1000.0),
        "/pose": position_channel(seconds=3.0, rate=1000.0),
    }
    return write_bag(path, channels, plugin)


def own(path):
    none = np.full(120_000, np.nan)
    block = SampleBlock(10**18, 0, 5e-4, POSITION[:120_000], FORCE[:120_000], none)
    write_samples_bag(path, block)
    return path


FOREIGN = Layout("/pose", "/ft", force_polarity="compression")


@pytest.mark.parametrize(
    ("make", "layout"),
    [
        (lambda folder: foreign(folder / "bag", StoragePlugin.MCAP), FOREIGN),
        (lambda folder: foreign(folder / "bag", StoragePlugin.SQLITE3), FOREIGN),
        (lambda folder: ros1_bag(folder / "run.bag"), FOREIGN),
        (lambda folder: own(folder / "run.mcap"), Layout()),
    ],
    ids=["MCAP", "SQLite", "ROS 1", "own"],
)
def test_it_is_told_how_much_of_a_bag_is_read(make, layout, tmp_path):
    shares = []
    read_any(make(tmp_path), layout, shares.append)
    assert len(shares) > 4
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert shares[-1] == 1.0
    assert max(np.diff(shares)) < 0.5


@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_messages_are_counted_as_they_come(plugin, tmp_path):
    bag = open_bag(foreign(tmp_path / "bag", plugin))
    for topics in (["/ft"], ["/ft", "/pose"], []):
        assert bag.count(topics) == sum(1 for _ in bag.messages(topics))
