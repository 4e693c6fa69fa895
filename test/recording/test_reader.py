"""What was recorded is read back exactly, also from what a dead recorder left."""

import logging
import math
import re
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from mcap.writer import CompressionType, IndexType, Writer
from numpy.testing import assert_array_equal
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tissue_probe.recording.bags.reader import iterate_raw, read_estimates, read_map, read_recording
from tissue_probe.recording.bags.summary import SamplesSummary, TopicSummary, summarize
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import (
    LAST_STAMP,
    EstimatorModel,
    PalpationSite,
    Phase,
    SampleBlock,
    join,
)

any_float = st.floats(width=64)


def same(block, other):
    assert (block.stamp, block.sequence) == (other.stamp, other.sequence)
    assert block.sample_period == other.sample_period
    for name in ("position", "force", "command"):
        assert_array_equal(getattr(block, name), getattr(other, name))


@st.composite
def sample_blocks(draw):
    """Blocks as a probe may send them: gaps, repeats and steps back, NaN and infinities."""
    blocks, sequence, stamp = [], 0, draw(st.integers(0, LAST_STAMP - 10**9))
    for _ in range(draw(st.integers(1, 6))):
        size = draw(st.integers(1, 5))
        columns = [draw(arrays(np.float64, size, elements=any_float)) for _ in range(3)]
        blocks.append(SampleBlock(stamp, sequence, 5e-4, *columns))
        sequence = max(0, sequence + size + draw(st.sampled_from([0, 0, 3, -4])))
        stamp = stamp + size * 500_000 + draw(st.sampled_from([0, 0, 0, 1000]))
    return blocks


@given(blocks=sample_blocks())
@settings(max_examples=50, deadline=None)
def test_samples_are_read_as_they_were_written(blocks, messages, record):
    entries = [
        ("/samples", messages.SAMPLES, time, messages.samples(block))
        for time, block in enumerate(blocks)
    ]
    with tempfile.TemporaryDirectory() as folder:
        recording = read_recording(record(Path(folder, "run.mcap"), entries, chunk=2))
    for block, expected in zip(recording.blocks, join(blocks), strict=True):
        same(block, expected)


def test_blocks_that_continue_are_joined_and_metadata_is_read(run, blocks):
    recording = read_recording(run)
    (block,) = recording.blocks
    assert_array_equal(block.position, np.concatenate([each.position for each in blocks]))
    assert recording.metadata == {"parameters": {"excitation": "sine 10 Hz"}}


def test_samples_in_big_endian_are_read_too(tmp_path, messages, record, blocks):
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(messages.definitions[messages.SAMPLES], messages.SAMPLES))
    message = store.deserialize_cdr(messages.samples(blocks[0]), messages.SAMPLES)
    data = bytes(store.serialize_cdr(message, messages.SAMPLES, little_endian=False))
    file = record(tmp_path / "run.mcap", [("/samples", messages.SAMPLES, 0, data)])
    same(read_recording(file).blocks[0], blocks[0])


def test_sites_are_those_of_the_same_probe(tmp_path, messages, record, blocks):
    ours = PalpationSite(5, 3, (0.1, 0.2, 0.3), Phase.DWELL)
    others = PalpationSite(6, 4, (0.0, 0.0, 0.0), Phase.LIFTED)
    entries = [
        ("/left/samples", messages.SAMPLES, 0, messages.samples(blocks[0])),
        ("/left/palpation_site", messages.SITE, 1, messages.site(ours)),
        ("/right/palpation_site", messages.SITE, 2, messages.site(others)),
    ]
    assert read_recording(record(tmp_path / "run.mcap", entries)).sites == (ours,)


def test_several_topics_of_samples_ask_for_a_choice(tmp_path, messages, record, blocks):
    entries = [
        (topic, messages.SAMPLES, 0, messages.samples(block))
        for topic, block in zip(("/left", "/right"), blocks, strict=False)
    ]
    file = record(tmp_path / "run.mcap", entries)
    with pytest.raises(RecordingError, match="/left, /right"):
        read_recording(file)
    same(read_recording(file, "/right").blocks[0], blocks[1])
    with pytest.raises(RecordingError, match=r"/middle.*/left, /right"):
        read_recording(file, "/middle")


@given(
    rows=st.lists(
        st.tuples(
            st.sampled_from(["ekf", "ukf"]),
            st.lists(any_float, min_size=10, max_size=10),
            st.integers(0, 3),
        ),
        min_size=1,
        max_size=6,
    )
)
@settings(max_examples=30, deadline=None)
def test_estimates_are_read_as_they_were_written(rows, messages, record):
    entries = [
        (f"/{name}", messages.ESTIMATE, time, messages.estimate(time, 10 * time, name, values, s))
        for time, (name, values, s) in enumerate(rows)
    ]
    with tempfile.TemporaryDirectory() as folder:
        read = read_estimates(record(Path(folder, "run.mcap"), entries))

    assert set(read) == {name for name, _, _ in rows}
    for name, estimates in read.items():
        mine = [(time, values, s) for time, (n, values, s) in enumerate(rows) if n == name]
        stamp, sequence, *columns, status, model = estimates.arrays()
        assert stamp.tolist() == [time for time, _, _ in mine]
        assert sequence.tolist() == [10 * time for time, _, _ in mine]
        assert_array_equal(np.transpose(columns), [values for _, values, _ in mine])
        assert status.tolist() == [s for _, _, s in mine]
        assert status.dtype == np.uint8
        assert set(model) == {"a model"}


def test_the_models_of_the_estimators_beside_the_samples_are_read(tmp_path, messages, record):
    plain = EstimatorModel(0, 0, "ekf", "kelvin_voigt")
    other = EstimatorModel(9, 90, "ekf", "maxwell 0123", "a.yaml", "rig: α\n", ("own.py",))
    block = SampleBlock(0, 0, 5e-4, *np.zeros((3, 4)))
    entries = [
        ("/probe/samples", messages.SAMPLES, 0, messages.samples(block)),
        ("/probe/ekf/model", messages.MODEL, 1, messages.model(plain)),
        ("/beside/ekf/model", messages.MODEL, 2, messages.model(other)),
        ("/probe/ekf/model", messages.MODEL, 3, messages.model(other)),
    ]
    recording = read_recording(record(tmp_path / "run.mcap", entries))
    assert recording.models == (plain, other)


def test_estimates_of_one_name_from_two_probes_are_not_mixed(tmp_path, messages, record):
    data = messages.estimate(0, 0, "ekf", 10 * [0.0], 0)
    entries = [(topic, messages.ESTIMATE, 0, data) for topic in ("/left", "/right")]
    with pytest.raises(RecordingError, match="'ekf' on two topics"):
        read_estimates(record(tmp_path / "run.mcap", entries))


def test_the_last_map_is_read(tmp_path, messages, record):
    first, last = np.full((2, 3), np.nan), np.arange(6.0).reshape(2, 3)
    entries = [
        ("/map", messages.MAP, time, messages.map(time, values))
        for time, values in enumerate([first, last], start=1)
    ]
    read = read_map(record(tmp_path / "run.mcap", entries))
    assert (read.stamp, read.origin, read.spacing) == (2, (0.1, 0.2, 0.3), 2e-3)
    for values in (read.stiffness, read.damping, read.covariance_trace, read.stiffness_stddev):
        assert_array_equal(values, last)
    assert_array_equal(read.verdict, [[0, 1, 2], [3, 4, 5]])
    assert_array_equal(read.dwell_begin, [[0, 1, 2], [3, 4, 5]])


def test_without_a_map_there_is_none(run):
    assert read_map(run) is None


def test_a_file_cut_off_anywhere_gives_what_came_before(run, blocks, tmp_path, caplog):
    whole = run.read_bytes()
    cut = tmp_path / "cut.mcap"
    caplog.set_level(logging.ERROR)
    lengths = []
    for size in range(8, len(whole) - 8, 211):
        cut.write_bytes(whole[:size])
        try:
            (block,) = read_recording(cut).blocks
        except RecordingError:  # cut before the first complete chunk
            assert not lengths
            continue
        same(block, join(blocks)[0][: len(block)])
        assert len(block) % 100 == 0  # ten blocks of ten samples a chunk
        lengths.append(len(block))
    assert lengths == sorted(lengths)
    assert set(lengths) == {100, 200, 300, 400, 500, 600}


def test_a_file_cut_off_between_the_indexes_of_a_chunk_keeps_all_its_topics(
    tmp_path, messages, record
):
    data = messages.cdr(messages.FLOAT, 1.0)
    entries = [(f"/{time % 3}", messages.FLOAT, time, data) for time in range(30)]
    whole = record(tmp_path / "run.mcap", entries, chunk=30).read_bytes()
    cut = tmp_path / "cut.mcap"
    complete = 0
    for size in range(len(whole) // 4, len(whole), 7):
        cut.write_bytes(whole[:size])
        counts = {topic.messages for topic in summarize(cut).topics}
        assert counts in (set(), {10})
        complete += counts == {10}
    assert complete > 30


@given(
    places=st.lists(st.integers(8), min_size=1, max_size=3),
    values=st.lists(st.integers(0, 255), min_size=3, max_size=3),
)
@settings(
    max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_a_damaged_file_never_gives_wrong_samples(places, values, run, blocks, tmp_path, caplog):
    damaged = bytearray(run.read_bytes())
    for place, value in zip(places, values, strict=False):
        damaged[8 + place % (len(damaged) - 8)] = value
    (tmp_path / "damaged.mcap").write_bytes(damaged)
    caplog.set_level(logging.ERROR)
    try:
        read = read_recording(tmp_path / "damaged.mcap").blocks
    except RecordingError:
        return
    (original,) = join(blocks)
    for block in read:
        same(block, original[block.sequence : block.sequence + len(block)])


def test_a_file_cut_off_is_warned_of_with_what_was_read(run, caplog):
    whole = run.read_bytes()
    run.write_bytes(whole[: len(whole) // 2])
    read_recording(run)
    (warning,) = caplog.messages
    assert re.search(
        r"run.mcap was not closed .* \d complete chunks and the part of the next", warning
    )


def test_zeros_after_a_power_failure_end_the_file(run, blocks):
    whole = run.read_bytes()
    half = len(whole) // 2
    run.write_bytes(whole[:half] + bytes(len(whole) - half))
    samples = len(read_recording(run))
    run.write_bytes(whole[:half])
    assert 0 < len(read_recording(run)) == samples


def test_a_damaged_chunk_is_left_out_with_a_warning(run, blocks, caplog):
    damaged = bytearray(run.read_bytes())
    third = [match.start() for match in re.finditer(b"zstd", damaged)][2]
    damaged[third + 200] ^= 0xFF
    run.write_bytes(damaged)
    first, second = read_recording(run).blocks
    assert (len(first), second.sequence, len(second)) == (200, 300, 300)
    assert "damaged chunk" in caplog.text


@pytest.mark.parametrize("chunked", [True, False])
@pytest.mark.parametrize("indexed", [True, False])
@pytest.mark.parametrize("compression", list(CompressionType))
def test_mcap_files_of_any_make_are_read(
    chunked, indexed, compression, tmp_path, messages, blocks, caplog
):
    file = tmp_path / "run.mcap"
    with file.open("wb") as stream:
        writer = Writer(
            stream,
            chunk_size=2000,
            compression=compression,
            index_types=IndexType.ALL if indexed else IndexType.NONE,
            repeat_channels=indexed,
            repeat_schemas=indexed,
            use_statistics=indexed,
            use_chunking=chunked,
        )
        writer.start(profile="ros2")
        definition = messages.definitions[messages.SAMPLES].encode()
        schema = writer.register_schema(messages.SAMPLES, "ros2msg", definition)
        channel = writer.register_channel("/samples", "cdr", schema)
        for block in blocks:
            writer.add_message(channel, block.stamp, messages.samples(block), block.stamp)
        writer.finish()
    (block,) = read_recording(file).blocks
    same(block, join(blocks)[0])
    assert not caplog.messages


@pytest.mark.parametrize("storage", list(StoragePlugin))
@pytest.mark.parametrize("what", ["file", "folder"])
def test_bags_written_by_rosbags_are_read(storage, what, tmp_path, messages, blocks):
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(messages.definitions[messages.SAMPLES], messages.SAMPLES))
    folder = tmp_path / "bag"
    with Rosbag2Writer(folder, version=9, storage_plugin=storage) as writer:
        connection = writer.add_connection("/samples", messages.SAMPLES, typestore=store)
        for block in blocks:
            writer.write(connection, block.stamp, messages.samples(block))
    (file,) = (file for file in folder.iterdir() if file.suffix in (".mcap", ".db3"))
    (block,) = read_recording(file if what == "file" else folder).blocks
    same(block, join(blocks)[0])


def test_the_files_of_a_folder_are_read_as_one_bag(tmp_path, messages, record, blocks):
    entries = [
        ("/samples", messages.SAMPLES, block.stamp, messages.samples(block)) for block in blocks
    ]
    record(tmp_path / "run_0.mcap", entries[1::2], {"first": {}})
    record(tmp_path / "run_1.mcap", entries[::2], {"second": {}})
    (tmp_path / "metadata.yaml").touch()
    recording = read_recording(tmp_path)
    (block,) = recording.blocks
    same(block, join(blocks)[0])
    assert set(recording.metadata) == {"first", "second"}
    assert not summarize(tmp_path).truncated

    cut = tmp_path / "run_1.mcap"
    cut.write_bytes(cut.read_bytes()[:-10])
    assert summarize(tmp_path).truncated


def test_raw_messages_come_in_the_order_of_their_log_times(tmp_path, messages, record):
    times = np.random.default_rng(0).permutation(100).tolist()
    data = {time: messages.cdr(messages.FLOAT, float(time)) for time in times}
    entries = [(f"/{time % 3}", messages.FLOAT, time, data[time]) for time in times]
    file = record(tmp_path / "run.mcap", entries, chunk=7)
    read = list(iterate_raw(file, ["/0", "/2"]))
    assert [(m.topic, m.typename, m.log_time, m.publish_time, m.data) for m in read] == [
        (f"/{time % 3}", messages.FLOAT, time, time, data[time])
        for time in range(100)
        if time % 3 != 1
    ]


def test_raw_messages_of_a_file_cut_off_end_with_its_last_complete_chunk(run, blocks):
    run.write_bytes(run.read_bytes()[:-3000])
    times = [message.log_time for message in iterate_raw(run, ["/probe/samples"])]
    assert 0 < len(times) < 60
    assert times == [block.stamp for block in blocks[: len(times)]]


def test_a_topic_that_is_not_there_is_refused_before_the_first_message(run):
    with pytest.raises(RecordingError, match="/nothing; it has /probe/samples"):
        iterate_raw(run, ["/probe/samples", "/nothing"])


def test_a_summary_counts_messages_losses_and_sites(tmp_path, messages, record, blocks):
    sites = [
        PalpationSite(1, 7, (0.0, 0.0, 0.0), Phase.APPROACH),
        PalpationSite(2, 7, (0.0, 0.0, 0.0), Phase.DWELL),
        PalpationSite(3, 8, (0.0, 0.0, 0.0), Phase.DWELL),
    ]
    kept = [*blocks[:2], blocks[5], *blocks[7:9], blocks[0]]  # 30 + 10 lost, then activated anew
    entries = [
        ("/samples", messages.SAMPLES, 10**9 * time, messages.samples(block))
        for time, block in enumerate(kept, start=1)
    ]
    entries += [("/site", messages.SITE, 10**9, messages.site(site)) for site in sites]
    summary = summarize(record(tmp_path / "run.mcap", entries, {"a": {"b": "c"}}))
    assert summary.topics == (
        TopicSummary("/samples", messages.SAMPLES, 6),
        TopicSummary("/site", messages.SITE, 3),
    )
    assert (summary.start, summary.duration) == (10**9, 5.0)
    assert summary.samples == (SamplesSummary("/samples", recorded=60, lost=40, first=0),)
    assert summary.sites == (7, 8)
    assert summary.metadata == {"a": {"b": "c"}}
    assert not summary.truncated


def test_a_summary_of_a_file_cut_off_says_so(run):
    run.write_bytes(run.read_bytes()[:-3000])
    summary = summarize(run)
    assert summary.truncated
    assert 0 < summary.topics[0].messages < 60


def test_a_bag_without_messages_has_a_summary(tmp_path, record):
    summary = summarize(record(tmp_path / "run.mcap", []))
    assert (summary.topics, summary.start, summary.duration) == ((), None, 0.0)


def refusal(path):
    with pytest.raises(RecordingError) as raised:
        read_recording(path)
    assert str(path) in str(raised.value)
    return str(raised.value)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is empty"),
        (b"t,u,F\n0,0,0\n", "is not an MCAP file"),
        (b"#ROSBAG V2.0\n", "rosbag reindex"),
        (b"SQLite format 3\0" + bytes(100), "is damaged"),
        (b"\x89MCAP0\r\n", "nothing that follows can be read"),
    ],
)
def test_a_file_that_is_no_bag_is_refused_with_what_it_is(content, said, tmp_path):
    (tmp_path / "run.db3").write_bytes(content)
    assert said in refusal(tmp_path / "run.db3")


def test_a_file_that_is_not_there_is_said_so(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_recording(tmp_path / "run.mcap")


def test_a_folder_without_a_bag_is_refused(tmp_path):
    assert "without a bag" in refusal(tmp_path)


def test_a_folder_of_separate_runs_is_refused_with_their_names(run):
    (run.parent / "second.mcap").write_bytes(run.read_bytes())
    assert "run.mcap, second.mcap" in refusal(run.parent)


def test_a_bag_without_samples_is_refused_with_what_it_has(tmp_path, messages, record):
    data = messages.cdr(messages.FLOAT, 1.0)
    said = refusal(record(tmp_path / "run.mcap", [("/force", messages.FLOAT, 0, data)]))
    assert "ProbeSamples" in said
    assert "/force (std_msgs/msg/Float64)" in said


def test_a_topic_of_samples_without_a_message_is_refused(tmp_path, messages):
    empty = write_mcap(tmp_path / "run.mcap", messages, "ros2", "cdr", [])
    assert "nothing was published on /samples" in refusal(empty)


def write_mcap(file, messages, profile, encoding, data, definition=None):
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile=profile)
        text = messages.definitions[messages.SAMPLES] if definition is None else definition
        schema = writer.register_schema(messages.SAMPLES, "ros2msg", text.encode())
        channel = writer.register_channel("/samples", encoding, schema)
        for each in data:
            writer.add_message(channel, 0, each, 0)
        writer.finish()
    return file


def test_samples_in_another_encoding_are_refused(tmp_path, messages):
    file = write_mcap(tmp_path / "run.mcap", messages, "", "json", [b"{}"])
    with pytest.raises(RecordingError, match="/samples is recorded as 'json'"):
        read_recording(file)


def test_samples_of_another_version_are_refused_with_the_field(tmp_path, messages):
    definition = messages.definitions[messages.SAMPLES].replace(" force ", " load ")
    data = [messages.samples(SampleBlock(0, 0, 1.0, [0.0], [0.0], [0.0]))]
    file = write_mcap(tmp_path / "run.mcap", messages, "ros2", "cdr", data, definition)
    with pytest.raises(RecordingError, match="'force'"):
        read_recording(file)


@pytest.mark.parametrize("definition", ["", "not a definition"])
def test_samples_without_a_definition_are_refused(definition, tmp_path, messages):
    file = write_mcap(tmp_path / "run.mcap", messages, "ros2", "cdr", [b"\0\1\0\0"], definition)
    with pytest.raises(RecordingError, match=r"/samples|ProbeSamples"):
        read_recording(file)


def test_a_damaged_message_is_refused_with_where_it_is(tmp_path, messages, record, blocks):
    data = messages.samples(blocks[0])
    for wrong in (data[:-8], b"", data + bytes(8)):
        file = tmp_path / f"{len(wrong)}.mcap"
        record(file, [("/samples", messages.SAMPLES, 17, wrong)])
        with pytest.raises(RecordingError, match="/samples logged at 17 ns"):
            read_recording(file)


def test_malformed_messages_are_left_out_as_live_and_told(
    tmp_path, messages, record, blocks, caplog
):
    endless = messages.cdr(
        messages.SAMPLES,
        *(messages.header(blocks[0].stamp), 0, 1e300),
        *(blocks[0].position, blocks[0].force, blocks[0].command),
    )
    site = PalpationSite(blocks[0].stamp, 0, (0.0, 0.0, 0.0), Phase.DWELL)
    nowhere = replace(site, position=(math.nan, 0.0, 0.0))
    entries = [
        ("/probe/samples", messages.SAMPLES, 1, messages.samples(blocks[0])),
        ("/probe/samples", messages.SAMPLES, 2, endless),
        ("/probe/samples", messages.SAMPLES, 3, messages.samples(blocks[1])[:-8]),
        ("/probe/samples", messages.SAMPLES, 4, messages.samples(blocks[1])),
        ("/probe/palpation_site", messages.SITE, 5, messages.site(nowhere)),
        ("/probe/palpation_site", messages.SITE, 6, messages.site(site)),
    ]
    found = read_recording(record(tmp_path / "run.mcap", entries))
    (block,) = found.blocks
    same(block, join(blocks[:2])[0])
    assert found.sites == (site,)
    assert "2 malformed messages are left out" in caplog.text
    assert "sample_period is 1e+300 s" in caplog.text


def bags(folder):
    return [path.parent for path in sorted(folder.rglob("metadata.yaml"))]


def test_foreign_bags_have_as_many_messages_as_their_metadata_says(foreign_bags):
    for bag in bags(foreign_bags):
        said = re.search(r"^  message_count: (\d+)", (bag / "metadata.yaml").read_text(), re.M)
        counted = sum(topic.messages for topic in summarize(bag).topics)
        assert counted == int(said[1]), bag


def test_foreign_bags_are_refused_for_having_no_samples_not_for_their_format(foreign_bags):
    for bag in bags(foreign_bags):
        with pytest.raises(RecordingError, match="no topic of type"):
            read_recording(bag)


def test_a_foreign_mcap_file_has_the_messages_of_its_sqlite_twin(foreign_bags):
    twins = [foreign_bags / "rosbags-rs" / name for name in ("test_bag_mcap", "test_bag_sqlite3")]
    topics = {topic.name for topic in summarize(twins[0]).topics}
    mcap, sqlite = (
        sorted((message.topic, message.typename) for message in iterate_raw(bag, topics))
        for bag in twins
    )
    assert len(mcap) == 188
    assert mcap == sqlite
