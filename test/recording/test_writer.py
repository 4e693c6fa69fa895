"""What the writer leaves on disk is read without our code, and survives the writer."""

import errno
import json
import signal
import subprocess
import sys
import time
from itertools import islice
from threading import Thread

import pytest
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosReliability
from rosbags.rosbag2 import Reader

from tissue_probe.recording.bags.reader import iterate_raw, read_recording
from tissue_probe.recording.bags.summary import summarize
from tissue_probe.recording.writing.writer import McapWriter

QOS = """- history: keep_last
  depth: 10
  reliability: reliable
  durability: volatile
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: automatic
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false
"""
METADATA = {"parameters": {"rate": "2000 Hz"}, "excitation": {"kind": "sine", "e\u0301": "\u03b2"}}


@pytest.fixture
def file(tmp_path):
    return tmp_path / "run.mcap"


def written(file, messages, blocks):
    with McapWriter(file, METADATA) as writer:
        definition = messages.definitions[messages.SAMPLES]
        channel = writer.add_topic("/probe/samples", messages.SAMPLES, definition, QOS)
        for block in blocks:
            writer.write(channel, block.stamp + 7, block.stamp, messages.samples(block))
    return file


def test_plain_mcap_reads_messages_schema_and_channel(file, messages, blocks):
    with written(file, messages, blocks).open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        read = list(reader.iter_messages())
        assert reader.get_header().profile == "ros2"
    schema, channel, first = read[0]
    assert (schema.name, schema.encoding) == (messages.SAMPLES, "ros2msg")
    assert schema.data.decode() == messages.definitions[messages.SAMPLES]
    assert (channel.topic, channel.message_encoding) == ("/probe/samples", "cdr")
    assert channel.metadata["offered_qos_profiles"] == QOS
    assert (first.log_time, first.publish_time) == (blocks[0].stamp + 7, blocks[0].stamp)
    assert [message.data for _, _, message in read] == [messages.samples(b) for b in blocks]


def test_metadata_is_found_through_the_summary(file, messages, blocks):
    with written(file, messages, blocks).open("rb") as stream:
        reader = make_reader(stream)
        indexed = [entry.name for entry in reader.get_summary().metadata_indexes]
        assert indexed == list(METADATA)
        assert {record.name: record.metadata for record in reader.iter_metadata()} == METADATA


def test_checksums_hold_and_chunks_are_compressed(file, messages, blocks):
    with written(file, messages, blocks).open("rb") as stream:
        records = list(StreamReader(stream, emit_chunks=True, validate_crcs=True).records)
    chunks = [record for record in records if isinstance(record, Chunk)]
    assert chunks
    assert all(chunk.compression == "zstd" and chunk.uncompressed_crc for chunk in chunks)


def test_plain_rosbags_reads_the_lone_file(file, messages, blocks):
    with AnyReader([written(file, messages, blocks)]) as reader:
        (connection,) = reader.connections
        assert connection.ext.offered_qos_profiles[0].reliability == QosReliability.RELIABLE
        for block, (_, log_time, data) in zip(blocks, reader.messages(), strict=True):
            message = reader.deserialize(data, messages.SAMPLES)
            assert log_time == block.stamp + 7
            assert message.sequence == block.sequence
            assert message.force.tolist() == block.force.tolist()


def test_the_type_hash_is_that_of_ros(file, share):
    header = (share / "std_msgs" / "msg" / "Header.msg").read_text()
    definition = f"{header}\n{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
    with McapWriter(file, {}) as writer:
        writer.add_topic("/header", "std_msgs/msg/Header", definition, "")
    with file.open("rb") as stream:
        (channel,) = make_reader(stream).get_summary().channels.values()
    # as rosidl of ROS 2 Jazzy computed it (share/std_msgs/msg/Header.json)
    assert channel.metadata["topic_type_hash"] == (
        "RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"
    )


def test_topics_of_one_type_share_its_schema(file, messages):
    with McapWriter(file, {}) as writer:
        for topic in ("/a", "/b"):
            writer.add_topic(topic, messages.FLOAT, messages.definitions[messages.FLOAT], "")
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert len(summary.channels) == 2
    assert len(summary.schemas) == 1


def test_an_existing_file_is_refused_and_kept(file):
    file.write_text("precious")
    with pytest.raises(FileExistsError, match="never overwritten") as raised:
        McapWriter(file, {})
    assert str(file) in str(raised.value)
    assert file.read_text() == "precious"


def test_closing_twice_does_nothing_and_writing_after_it_is_refused(file, messages):
    writer = McapWriter(file, {})
    channel = writer.add_topic("/a", messages.FLOAT, messages.definitions[messages.FLOAT], "")
    writer.close()
    size = file.stat().st_size
    writer.close()
    assert file.stat().st_size == size
    with pytest.raises(ValueError, match="is closed"):
        writer.write(channel, 0, 0, messages.cdr(messages.FLOAT, 1.0))


def test_threads_write_to_one_file_without_losing_a_message(file, messages):
    data = messages.cdr(messages.FLOAT, 1.0)
    with McapWriter(file, {}) as writer:

        def produce(topic):
            definition = messages.definitions[messages.FLOAT]
            channel = writer.add_topic(topic, messages.FLOAT, definition, "")
            for number in range(500):
                writer.write(channel, number, number, data)
                if number % 50 == 0:
                    writer.flush()

        threads = [Thread(target=produce, args=(f"/{number}",)) for number in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert [topic.messages for topic in summarize(file).topics] == 4 * [500]


def test_metadata_is_on_disk_before_the_first_message(file):
    with McapWriter(file, METADATA), file.open("rb") as stream:
        _, *records = islice(StreamReader(stream).records, 1 + len(METADATA))
    assert {record.name: record.metadata for record in records} == METADATA


def test_a_lone_message_reaches_the_disk_by_itself(file, messages):
    with McapWriter(file, {}) as writer:
        definition = messages.definitions[messages.FLOAT]
        channel = writer.add_topic("/a", messages.FLOAT, definition, "")
        writer.write(channel, 1, 1, messages.cdr(messages.FLOAT, 1.0))
        deadline = time.monotonic() + 60.0
        while not summarize(file).topics and time.monotonic() < deadline:
            pass
        assert [topic.messages for topic in summarize(file).topics] == [1]


RECORDER = """
import sys, time
from tissue_probe.recording.writing.writer import McapWriter
path, definition, data = sys.argv[1], open(sys.argv[2]).read(), open(sys.argv[3], "rb").read()
writer = McapWriter(path, {"parameters": {"rate": "2000 Hz"}})
channel = writer.add_topic("/a", "std_msgs/msg/Float64", definition, "")
while True:
    now = time.time_ns()
    writer.write(channel, now, now, data)
    print(now, flush=True)
    time.sleep(0.005)
"""


def test_a_killed_recorder_loses_at_most_the_last_second(file, tmp_path, messages):
    (tmp_path / "definition").write_text(messages.definitions[messages.FLOAT])
    (tmp_path / "data").write_bytes(messages.cdr(messages.FLOAT, 1.0))
    command = [sys.executable, "-c", RECORDER, file, tmp_path / "definition", tmp_path / "data"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as recorder:
        first = int(recorder.stdout.readline())
        written_times = [first]
        while written_times[-1] < first + 1.2e9:
            written_times.append(int(recorder.stdout.readline()))
        recorder.send_signal(signal.SIGKILL)
        written_times += [int(line) for line in recorder.stdout if line.endswith("\n")]

    read = [message.log_time for message in iterate_raw(file, ["/a"])]
    assert read == written_times[: len(read)]
    assert written_times[-1] - read[-1] <= 1e9
    summary = summarize(file)
    assert summary.truncated
    assert summary.metadata == {"parameters": {"rate": "2000 Hz"}}


# The limit on a file's size stands for a full disk: it fails the same system call, for real.
FULL_DISK = """
import json, random, resource, sys, time
from tissue_probe.recording.writing.writer import McapWriter
path, limit, definition = sys.argv[1], int(sys.argv[2]), open(sys.argv[3]).read()
flushing = sys.argv[4] == "flushing"
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
errors, flushed = [], 0
noise = random.Random(0)
try:
    with McapWriter(path, {"parameters": {"rate": "2000 Hz"}}) as writer:
        channel = writer.add_topic("/a", "std_msgs/msg/Float64", definition, "")
        for number in range(200):
            writer.write(channel, number, number, b"\\0\\1\\0\\0" + noise.randbytes(8))
            if flushing:
                writer.flush()
                flushed = number + 1
            else:
                time.sleep(0.01)
except OSError as error:
    errors.append([error.errno, str(error)])
try:
    writer.close()
    writer.close()
except NameError:  # not even created
    pass
except OSError as error:
    errors.append([error.errno, str(error)])
print(json.dumps({"errors": errors, "flushed": flushed}))
"""


def fill_disk(file, limit, messages, how="flushing"):
    definition = file.with_suffix(".definition")
    definition.write_text(messages.definitions[messages.FLOAT])
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, file, str(limit), definition, how],
        capture_output=True,
        text=True,
        timeout=30,
    )
    assert done.stderr == ""
    return json.loads(done.stdout)


@pytest.fixture
def sizes(tmp_path, messages):
    """Bytes written without any limit: in all, and before the summary."""
    file = tmp_path / "unlimited.mcap"
    assert fill_disk(file, 10**9, messages)["errors"] == []
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    last = max(summary.chunk_indexes, key=lambda index: index.chunk_start_offset)
    before = last.chunk_start_offset + last.chunk_length + last.message_index_length
    return file.stat().st_size, before


@pytest.mark.parametrize("part", ["head", "topic", "messages", "summary", "last byte"])
def test_a_full_disk_raises_once_and_keeps_what_was_flushed(part, sizes, file, messages):
    whole, before_summary = sizes
    limit = {
        "head": 20,
        "topic": 200,
        "messages": before_summary // 2,
        "summary": (whole + before_summary) // 2,
        "last byte": whole - 1,
    }[part]
    outcome = fill_disk(file, limit, messages)

    ((number, text),) = outcome["errors"]
    assert number == errno.EFBIG
    assert str(file) in text
    assert "stay readable" in text
    if part in ("messages", "summary", "last byte"):
        assert outcome["flushed"] > 0
        read = [message.log_time for message in iterate_raw(file, ["/a"])]
        assert read[: outcome["flushed"]] == list(range(outcome["flushed"]))


def test_a_disk_that_fills_between_two_calls_is_told_by_the_next(file, messages):
    ((number, text),) = fill_disk(file, 1000, messages, how="waiting")["errors"]
    assert number == errno.EFBIG
    assert "stay readable" in text


def test_what_was_written_is_what_is_read(file, messages, blocks):
    recording = read_recording(written(file, messages, blocks))
    assert len(recording) == sum(len(block) for block in blocks)
    with Reader(file) as reader:
        assert reader.message_count == len(blocks)
