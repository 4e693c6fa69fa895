"""What recorders and their death leave of a bag is read in full, told, or refused in a sentence."""

import shutil
import sqlite3
import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import zstandard
from bags import EPOCH, STORE, cdr, force_channel, pose, position_channel, wrench
from bags import write_bag as write
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Rosbag1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.bags import unpacking
from tissue_probe.recording.bags.open_bag import is_bag, open_bag
from tissue_probe.recording.bags.summary import summarize
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout

LAYOUT = Layout(position="/pose", force="/ft", force_polarity="compression")


def channels(seconds=1.0):
    return {
        "/ft": force_channel(seconds=seconds, rate=100.0),
        "/pose": position_channel(seconds=seconds, rate=50.0),
    }


def counts(path):
    return {topic.name: topic.messages for topic in summarize(path).topics}


EVERYTHING = {"/ft": 100, "/pose": 50}


@pytest.mark.parametrize("mode", [CompressionMode.MESSAGE, CompressionMode.FILE])
@pytest.mark.parametrize("plugin", list(StoragePlugin))
def test_bags_packed_by_message_or_file_are_read(mode, plugin, tmp_path):
    writer = Writer(tmp_path / "bag", version=9, storage_plugin=plugin)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection(
            "/ft", "geometry_msgs/msg/WrenchStamped", typestore=STORE
        )
        for number in range(20):
            writer.write(connection, EPOCH + number, cdr(wrench(EPOCH + number, float(number))))
    plain = cdr(wrench(EPOCH + 3, 3.0))
    assert list(open_bag(tmp_path / "bag").messages(["/ft"]))[3].data == plain
    (file,) = (each for each in (tmp_path / "bag").iterdir() if each.suffix != ".yaml")
    assert is_bag(file)
    assert list(open_bag(file).messages(["/ft"]))[3].data == plain


@pytest.mark.parametrize("mode", ["WAL", "DELETE"])
def test_what_a_killed_recorder_left_beside_an_sqlite_file_is_read(mode, tmp_path, caplog):
    bag = write(tmp_path / "bag", channels(), StoragePlugin.SQLITE3)
    (whole,) = bag.glob("*.db3")
    recording = tmp_path / "run.db3"
    shutil.copyfile(whole, recording)
    writer = sqlite3.connect(recording)
    writer.execute(f"PRAGMA journal_mode={mode}")
    writer.execute("PRAGMA cache_size=1")  # so that an open transaction reaches the file
    rows = writer.execute("SELECT topic_id, timestamp, data FROM messages").fetchall()
    writer.executemany("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)", rows)
    if mode == "WAL":
        writer.commit()
    left = tmp_path / "left"
    left.mkdir()
    for file in tmp_path.glob("run.db3*"):
        shutil.copyfile(file, left / file.name)
    before = {file.name: file.read_bytes() for file in left.iterdir()}
    assert len(before) > 1
    copies = 2 if mode == "WAL" else 1  # an open transaction is rolled back
    assert counts(left / "run.db3") == {name: copies * n for name, n in EVERYTHING.items()}
    assert summarize(left / "run.db3").truncated
    assert "was not closed by its recorder; read with run.db3-" in caplog.text
    assert {file.name: file.read_bytes() for file in left.iterdir()} == before
    writer.close()


def test_an_sqlite_bag_with_a_lost_page_is_told(tmp_path, caplog):
    bag = write(tmp_path / "bag", channels(5.0), StoragePlugin.SQLITE3)
    (file,) = bag.glob("*.db3")
    content = bytearray(file.read_bytes())
    content[len(content) // 2 // 4096 * 4096 :][:4096] = bytes(4096)
    middle = len(content) // 2 // 4096 * 4096
    content[middle : middle + 4096] = bytes(4096)
    file.write_bytes(content)
    with suppress(RecordingError):
        summarize(file)
        assert "is damaged, messages may be missing" in caplog.text


def test_files_that_the_metadata_do_not_list_are_read_and_told(tmp_path, caplog):
    bag = write(tmp_path / "bag", channels())
    more = write(tmp_path / "more", channels())
    shutil.copyfile(more / "more.mcap", bag / "bag_10.mcap")
    assert counts(bag) == {"/ft": 200, "/pose": 100}
    assert "does not list bag_10.mcap; read too" in caplog.text


def test_a_file_that_the_metadata_list_and_is_missing_is_told(tmp_path, caplog):
    bag = write(tmp_path / "bag", channels())
    text = (bag / "metadata.yaml").read_text()
    text = text.replace("relative_file_paths:\n", "relative_file_paths:\n  - bag_7.mcap\n")
    (bag / "metadata.yaml").write_text(text)
    assert counts(bag) == EVERYTHING
    assert "lists bag_7.mcap, missing there" in caplog.text


def test_file_ten_comes_after_file_nine(tmp_path):
    (tmp_path / "metadata.yaml").touch()
    for number in (10, 9):
        bag = write(tmp_path / f"of_{number}", channels(0.1 * number))
        shutil.move(bag / f"of_{number}.mcap", tmp_path / f"run_{number}.mcap")
        shutil.rmtree(bag)
    first = [message.topic for message in open_bag(tmp_path).messages(["/pose"])]
    assert len(first) == 45 + 50
    times = [message.log_time for message in open_bag(tmp_path).messages(["/ft"])]
    assert np.argmin(np.diff(times)) == 89


@pytest.mark.parametrize(
    "text", ["&a [*a, *a]", "- [", "{a: " * 5000, "rosbag2_bagfile_information: 3"]
)
def test_metadata_that_make_no_sense_are_not_used(text, tmp_path, caplog):
    bag = write(tmp_path / "bag", channels())
    (bag / "metadata.yaml").write_text(text)
    assert counts(bag) == EVERYTHING
    assert "metadata.yaml is not understood, and not used" in caplog.text


def bag_of(path, entries):
    """Write (topic, type, definition, message) by the library of MCAP."""
    with path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile="ros2")
        channels = {}
        for number, (topic, kind, definition, data) in enumerate(entries):
            if (topic, kind, definition) not in channels:
                schema = writer.register_schema(kind, "ros2msg", definition.encode())
                channels[topic, kind, definition] = writer.register_channel(topic, "cdr", schema)
            time = EPOCH + number * 10**7
            writer.add_message(channels[topic, kind, definition], time, data, time)
        writer.finish()
    return path


def definition_of(message):
    return STORE.generate_msgdef(message.__msgtype__, ros_version=2)[0]


def readings(values, frame="tool"):
    kind = "geometry_msgs/msg/WrenchStamped"
    made = [wrench(EPOCH + n * 10**7, value, frame) for n, value in enumerate(values)]
    return [("/ft", kind, definition_of(made[0]), cdr(message)) for message in made]


def places(count):
    made = [pose(EPOCH + n * 10**7, 1e-3 * n) for n in range(count)]
    kind = "geometry_msgs/msg/PoseStamped"
    return [("/pose", kind, definition_of(made[0]), cdr(message)) for message in made]


def test_two_sensors_on_one_topic_are_refused_until_one_is_chosen(tmp_path):
    both = [
        entry
        for pair in zip(readings(range(50), "left"), readings(range(50, 100), "right"), strict=True)
        for entry in pair
    ]
    path = bag_of(tmp_path / "run.mcap", both + places(50))
    with pytest.raises(RecordingError, match=r"left and right; choose one, such as /ft@left"):
        read_any(path, LAYOUT)
    for field in ("/ft@right", "/ft.wrench.force.z@right"):
        recording, notes = read_any(path, Layout("/pose", field, force_polarity="compression"))
        assert recording.force[:50].tolist() == list(range(50, 100))
        assert "/ft.wrench.force.z@right" in notes[0]
    with pytest.raises(RecordingError, match="no message of middle on /ft; there is left"):
        read_any(path, Layout("/pose", "/ft@middle", force_polarity="compression"))


def test_messages_without_content_are_left_out_and_told(tmp_path):
    entries = readings(range(50))
    entries[10] = (*entries[10][:3], b"")
    recording, notes = read_any(bag_of(tmp_path / "run.mcap", entries + places(50)), LAYOUT)
    assert "1 messages of /ft have no content, and are left out" in notes
    assert len(recording) == 50
    assert np.flatnonzero(~np.isfinite(recording.force)).tolist() == [10]


def test_two_definitions_of_one_type_on_one_topic_are_each_decoded_by_its_own(tmp_path):
    kind = "my_msgs/msg/Force"
    used = definition_of(wrench(0, 0.0)).partition("wrench\n")[2]
    old = "std_msgs/Header header\nfloat64 data\n" + used
    new = "std_msgs/Header header\nfloat32 gain\nfloat64 data\n" + used
    stores = {text: get_typestore(Stores.EMPTY) for text in (old, new)}
    for text, store in stores.items():
        store.register(get_types_from_msg(text, kind))
    entries = []
    for number in range(60):
        text, values = (old, [float(number)]) if number < 30 else (new, [2.0, float(number)])
        store = stores[text]
        time = store.types["builtin_interfaces/msg/Time"](*divmod(EPOCH + number * 10**7, 10**9))
        head = store.types["std_msgs/msg/Header"](time, "tool")
        data = bytes(store.serialize_cdr(store.types[kind](head, *values), kind))
        entries.append(("/f", kind, text, data))
    layout = Layout("/pose", "/f.data", force_polarity="compression")
    recording, _ = read_any(bag_of(tmp_path / "run.mcap", entries + places(60)), layout)
    assert recording.force.tolist() == list(range(60))


def test_one_type_name_may_mean_different_things_on_two_topics(tmp_path):
    kind = "geometry_msgs/msg/PoseStamped"
    other = ("/other", kind, "uint8 x\n", b"\0\1\0\0\5")
    entries = [other, *readings(range(50)), *places(50)]
    recording, _ = read_any(bag_of(tmp_path / "run.mcap", entries), LAYOUT)
    assert recording.position[2] == pytest.approx(2e-3)


ROS1 = get_typestore(Stores.ROS1_NOETIC)


def ros1_bag(path, packing=None, count=50):
    writer = Rosbag1Writer(path)
    if packing:
        writer.set_compression(packing)
    kind = "geometry_msgs/msg/PointStamped"
    types = ROS1.types
    with writer:
        connection = writer.add_connection("/place", kind, typestore=ROS1)
        for number in [*range(count // 2, count), *range(count // 2)]:
            stamp = types["builtin_interfaces/msg/Time"](number, 0)
            message = types[kind](
                types["std_msgs/msg/Header"](0, stamp, "a"),
                types["geometry_msgs/msg/Point"](0.0, 0.0, float(number)),
            )
            writer.write(connection, number * 10**9, ROS1.serialize_ros1(message, kind))
    return path


@pytest.mark.parametrize("packing", [None, *Rosbag1Writer.CompressionFormat])
def test_ros1_bags_are_read_in_the_order_stored(packing, tmp_path):
    bag = open_bag(ros1_bag(tmp_path / "run.bag", packing))
    times = [message.log_time // 10**9 for message in bag.messages(["/place"])]
    assert times == [*range(25, 50), *range(25)]


def test_a_ros1_chunk_that_would_fill_the_memory_is_refused(tmp_path, monkeypatch):
    path = ros1_bag(tmp_path / "run.bag", Rosbag1Writer.CompressionFormat.BZ2, 2000)
    monkeypatch.setattr(unpacking, "LARGEST_UNPACKED", 2**12)
    with pytest.raises(RecordingError, match=r"run.bag is not read: a chunk of it unpacks to more"):
        list(open_bag(path).messages(["/place"]))
    monkeypatch.setattr(unpacking, "TOTAL", 2**12)
    monkeypatch.setattr(unpacking, "LARGEST_RATIO", 1)
    with pytest.raises(RecordingError, match=r"run.bag is not read: it unpacks to more than"):
        open_bag(path)


def test_a_file_that_would_fill_the_disk_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(unpacking, "TOTAL", 2**20)
    path = tmp_path / "run.mcap.zstd"
    path.write_bytes(zstandard.compress(bytes(2**22)))
    with pytest.raises(RecordingError, match=r"run.mcap.zstd is not read: it unpacks to more"):
        open_bag(path)


def test_a_message_that_would_fill_the_memory_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(unpacking, "LARGEST_UNPACKED", 2**20)
    entries = [("/ft", "std_msgs/msg/Float64", "float64 data\n", zstandard.compress(bytes(2**22)))]
    path = bag_of(tmp_path / "run.mcap", entries)
    with pytest.raises(RecordingError, match=r"run.mcap is not read: a message of it unpacks to"):
        list(open_bag(path).messages(["/ft"]))


class Originals(dict):
    """Bytes of bags by the ending of their names."""

    def __repr__(self):
        return "Originals()"


@pytest.fixture(scope="module")
def originals(tmp_path_factory):
    """One small bag of each kind."""
    folder = tmp_path_factory.mktemp("originals")
    found = Originals()
    for plugin, ending in ((StoragePlugin.MCAP, "mcap"), (StoragePlugin.SQLITE3, "db3")):
        bag = write(folder / ending, channels(0.3), plugin)
        found[ending] = (bag / f"{ending}.{ending}").read_bytes()
    for packing in Rosbag1Writer.CompressionFormat:
        path = ros1_bag(folder / f"{packing.name}.bag", packing)
        found[f"{packing.name}.bag"] = path.read_bytes()
    found["plain.bag"] = ros1_bag(folder / "plain.bag").read_bytes()
    found["mcap.zstd"] = zstandard.compress(found["mcap"])
    return found


@st.composite
def damage(draw):
    """Return a function from a whole file to a damaged one."""
    kind = draw(st.sampled_from(["bytes", "cut", "random", "swap"]))
    numbers = draw(st.lists(st.floats(0.0, 1.0, exclude_max=True), min_size=2, max_size=6))
    values = draw(st.binary(min_size=6, max_size=6))
    rubbish = draw(st.binary(max_size=200))

    def damaged(whole):
        places = [int(number * len(whole)) for number in numbers]
        if kind == "cut":
            return whole[: places[0]]
        if kind == "random":
            return whole[: min(places[0], 20)] + rubbish
        if kind == "swap":
            first, second = sorted(places[:2])
            return whole[:first] + whole[second:] + whole[first:second]
        changed = bytearray(whole)
        for place, value in zip(places, values, strict=False):
            changed[place] = value
        return bytes(changed)

    return damaged


ENDINGS = ["mcap", "db3", "BZ2.bag", "LZ4.bag", "plain.bag", "mcap.zstd"]


def refusal(path, layout):
    """Read all that a bag has; return why it is refused, or None."""
    try:
        bag = open_bag(path)
        names = {topic.name for topic in bag.topics}
        assert sum(1 for _ in bag.messages(names)) < 1000
        read_any(path, layout)
    except RecordingError as error:
        return str(error)
    return None


@pytest.mark.parametrize("ending", ENDINGS)
@given(damage=damage())
@settings(max_examples=60)
def test_no_damage_ends_in_anything_but_a_sentence_that_names_the_file(ending, damage, originals):
    ros1 = Layout("/place", "/place", force_polarity="tension")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"damaged.{ending}")
        path.write_bytes(damage(originals[ending]))
        said = refusal(path, ros1 if ending.endswith("bag") else LAYOUT)
    if said is not None:
        assert "\n" not in said
        assert str(path) in said


def test_a_folder_whose_recorder_was_killed_before_it_wrote_metadata_is_read(tmp_path, caplog):
    write(tmp_path / "bag", channels())
    (tmp_path / "bag" / "metadata.yaml").unlink()
    assert counts(tmp_path / "bag") == EVERYTHING
    assert "has no metadata.yaml" in caplog.text
    (file,) = (tmp_path / "bag").iterdir()
    shutil.copy(file, tmp_path / "bag" / "other.mcap")
    with pytest.raises(RecordingError, match=r"without metadata\.yaml; give one of its files"):
        open_bag(tmp_path / "bag")
