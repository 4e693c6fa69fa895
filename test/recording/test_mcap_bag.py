"""MCAP files of any make are read in full; what is damaged or oversized is told, never used."""

import logging
import random
import zlib
from io import BytesIO

import pytest
import zstandard
from lz4 import frame as lz4
from mcap.reader import NonSeekingReader
from mcap.records import Chunk, DataEnd, Footer, Header, Message, MessageIndex, Metadata
from mcap.writer import MCAP0_MAGIC

from benchmarks.mcap_variants import CHANNEL, SCHEMA, encoded, variants, write
from tissue_probe.recording.bags import unpacking
from tissue_probe.recording.bags.mcap_bag import McapBag
from tissue_probe.recording.bags.open_bag import open_bag
from tissue_probe.recording.bags.reader import read_recording
from tissue_probe.recording.bags.summary import summarize
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.writing.writer import McapWriter
from tissue_probe.signals import join


def read(path):
    bag = open_bag(path)
    return bag, list(bag.messages({topic.name for topic in bag.topics}))


def read_by_mcap(path):
    with path.open("rb") as file:
        return [
            (channel.topic, schema.name if schema else "", message.log_time, message.data)
            for schema, channel, message in NonSeekingReader(file).iter_messages(
                log_time_order=False
            )
        ]


def test_every_combination_of_features_is_read_as_by_a_reader_without_index(tmp_path, caplog):
    names = []
    for variant in variants():
        path = tmp_path / f"{variant.name}.mcap"
        path.write_bytes(write(variant))
        bag, messages = read(path)
        written = [record for record in variant.records if isinstance(record, Message)]
        assert [(m.topic, m.log_time, m.publish_time, m.data) for m in messages] == [
            ("example", m.log_time, m.publish_time, m.data) for m in written
        ], variant.name
        found = [(m.topic, m.typename, m.log_time, m.data) for m in messages]
        assert found == read_by_mcap(path), variant.name
        for topic in bag.topics:
            assert topic.message_encoding == ("a" if SCHEMA in variant.records else "text")
            assert topic.definition == ("\4\5\6" if SCHEMA in variant.records else "")
        noted = {r.name: r.metadata for r in variant.records if isinstance(r, Metadata)}
        assert bag.metadata == noted, variant.name
        assert not bag.truncated
        names.append(variant.name)
    assert len(set(names)) == 416
    assert not caplog.messages


def mcap(path, *records, ended=True):
    """Write records; with ``ended``, an end without checksums follows."""
    if ended:
        records = (*records, DataEnd(0), Footer(0, 0, 0))
    data = b"".join(encoded(record) for record in (Header("ros2", "test"), *records))
    path.write_bytes(MCAP0_MAGIC + data + (MCAP0_MAGIC if ended else b""))
    return path


def message(time, data=b"\1\2\3", channel=1):
    return Message(channel, time, data, time, 0)


def chunk(*records, packing="", data=None, size=None):
    content = b"".join(encoded(record) for record in records)
    pack = {"": bytes, "zstd": zstandard.compress, "lz4": lz4.compress}[packing]
    packed = pack(content) if data is None else data
    return Chunk(packing, packed, 9, 0, zlib.crc32(content), size or len(content))


def times(path):
    return [message.log_time for message in read(path)[1]]


def test_a_channel_that_only_the_chunk_describes_is_read_beside_one_outside(tmp_path):
    other = type(CHANNEL)(2, "other", "a", {}, 1)
    inside = chunk(other, message(1), message(2, channel=2))
    path = mcap(tmp_path / "run.mcap", SCHEMA, CHANNEL, inside)
    assert {m.topic for m in read(path)[1]} == {"example", "other"}


@pytest.mark.parametrize("index", [[(1, 0)], [(1, 10**6)], [(7, 7), (8, 8)], []])
def test_an_index_that_disagrees_with_the_data_misleads_nobody(index, tmp_path):
    inside = chunk(SCHEMA, CHANNEL, message(1), message(2))
    assert times(mcap(tmp_path / "run.mcap", inside, MessageIndex(1, index))) == [1, 2]


def test_messages_of_no_content_are_messages(tmp_path):
    assert times(mcap(tmp_path / "run.mcap", SCHEMA, CHANNEL, message(1, b""), message(2))) == [
        1,
        2,
    ]


def test_messages_come_as_stored_when_the_recorder_s_clock_stepped_back(tmp_path):
    stored = [5, 6, 2, 3, 4]
    path = mcap(tmp_path / "run.mcap", SCHEMA, CHANNEL, *map(message, stored))
    assert times(path) == stored


def test_messages_of_a_topic_without_description_are_told(tmp_path, caplog):
    path = mcap(tmp_path / "run.mcap", SCHEMA, CHANNEL, message(1), message(2, channel=5))
    assert times(path) == [1]
    assert "leaving out 1 messages of topics that it does not describe" in caplog.text


def test_fewer_messages_than_the_summary_says_are_told(run, caplog):
    whole = run.read_bytes()
    read_recording(run)
    assert not caplog.messages
    # Without data checksum and with one chunk's opcode unknown, nothing else tells.
    begin = whole.index(b"zstd") - 41
    assert whole[begin] == 6
    data_end = whole.rindex(b"\x0f\x04\0\0\0\0\0\0\0")
    damaged = bytearray(whole)
    damaged[begin] = 0x90
    damaged[data_end + 9 : data_end + 13] = bytes(4)
    run.write_bytes(damaged)
    read_recording(run)
    assert "has 50 messages, but its summary says 60" in caplog.text


def outcome(path, caplog):
    """Return samples, metadata, and whether anything was told; None if the file was refused."""
    caplog.clear()
    try:
        recording = read_recording(path)
    except RecordingError:
        return None
    return recording.blocks, recording.metadata, bool(caplog.messages)


def test_corrupted_recordings_are_told_and_give_no_wrong_samples(run, blocks, tmp_path, caplog):
    whole = run.read_bytes()
    (original,) = join(blocks)
    metadata = read_recording(run).metadata
    generator = random.Random(0)
    path = tmp_path / "damaged.mcap"
    for _ in range(100):
        damaged = bytearray(whole)
        for _ in range(generator.choice([1, 1, 1, 4])):
            damaged[generator.randrange(8, len(whole))] = generator.randrange(256)
        path.write_bytes(damaged)
        found = outcome(path, caplog)
        if found is None:
            continue
        read_blocks, read_metadata, told = found
        for block in read_blocks:
            same = original[block.sequence : block.sequence + len(block)]
            assert (block.force == same.force).all()
            assert (block.position == same.position).all()
        whole_again = sum(map(len, read_blocks)) == len(original) and read_metadata == metadata
        assert told or whole_again


def test_changed_parameters_are_told_by_the_checksum_of_the_data(tmp_path, caplog):
    path = tmp_path / "run.mcap"
    with McapWriter(path, {"driver": {"tip_mass": "0.04"}}):
        pass
    path.write_bytes(path.read_bytes().replace(b"0.04", b"0.05"))
    assert McapBag(path).metadata == {"driver": {"tip_mass": "0.05"}}
    assert "its data do not have the checksum that they carry" in caplog.text


def test_a_damaged_summary_is_told_and_not_used(run, blocks, caplog):
    whole = run.read_bytes()
    place = whole.rindex(b"/probe/samples")
    run.write_bytes(whole[:place] + b"/prune/samples" + whole[place + 14 :])
    assert len(read_recording(run)) == 10 * len(blocks)
    assert "its summary does not have the checksum that it carries" in caplog.text


def test_a_file_damaged_in_its_middle_is_not_said_to_be_cut_off(run, caplog):
    whole = bytearray(run.read_bytes())
    third = [place for place in range(len(whole)) if whole[place : place + 4] == b"zstd"][2]
    whole[third - 37] = 0xFF  # the length of the chunk
    run.write_bytes(whole)
    assert 0 < len(read_recording(run)) < 600
    assert "is damaged at byte" in caplog.text


@pytest.fixture
def small_bounds(monkeypatch):
    """Bounds that a test reaches in milliseconds."""
    monkeypatch.setattr(unpacking, "LARGEST_UNPACKED", 2**20)
    monkeypatch.setattr(unpacking, "TOTAL", 4 * 2**20)


@pytest.mark.parametrize("packing", ["zstd", "lz4"])
@pytest.mark.parametrize("said", ["truly", "too little"])
def test_a_chunk_that_would_fill_the_memory_is_refused(packing, said, small_bounds, tmp_path):
    content = bytes(2**22)
    pack = zstandard.compress if packing == "zstd" else lz4.compress
    size = len(content) if said == "truly" else 2**20 + 1
    bomb = chunk(packing=packing, data=pack(content), size=size)
    path = mcap(tmp_path / "bomb.mcap", bomb)
    with pytest.raises(RecordingError, match=r"bomb.mcap is not read: .* more than 1 MiB"):
        open_bag(path)


def test_many_chunks_that_unpack_to_too_much_together_are_refused(small_bounds, tmp_path):
    one = chunk(SCHEMA, CHANNEL, message(1, bytes(2**19)), packing="zstd")
    path = mcap(tmp_path / "bomb.mcap", *[one] * 20)
    with pytest.raises(RecordingError, match=r"bomb.mcap is not read: it unpacks to more than 4"):
        open_bag(path)


def test_a_chunk_that_lies_about_its_size_is_left_out(tmp_path, caplog):
    caplog.set_level(logging.WARNING)
    good = chunk(SCHEMA, CHANNEL, message(1), packing="zstd")
    for size in (1, 2**60):
        lying = chunk(SCHEMA, CHANNEL, message(2), packing="zstd", size=size)
        assert times(mcap(tmp_path / "run.mcap", good, lying)) == [1]
        assert "skipping the damaged chunk" in caplog.text


@pytest.mark.parametrize("packing", ["", "zstd", "lz4"])
def test_of_a_chunk_that_the_cut_goes_through_its_beginning_is_read(packing, tmp_path):
    noise = random.Random(0)
    stored = [message(time, noise.randbytes(1000)) for time in range(1, 1001)]
    inside = chunk(SCHEMA, CHANNEL, *stored, packing=packing)
    whole = mcap(tmp_path / "whole.mcap", inside, ended=False).read_bytes()
    path, found = tmp_path / "cut.mcap", []
    for part in (0.0, 0.1, 0.5, 0.9):
        path.write_bytes(whole[: 200 + round(part * (len(whole) - 200))])
        try:
            bag, messages = read(path)
        except RecordingError:  # nothing of it was unpacked
            found.append(0)
            continue
        assert bag.truncated
        assert [(m.log_time, m.data) for m in messages] == [
            (m.log_time, m.data) for m in stored[: len(messages)]
        ]
        found.append(len(messages))
    assert found[0] == 0
    assert found == sorted(found)
    assert found[2] > 350
    assert found[3] > 750


def test_zeros_behind_the_cut_make_no_message(tmp_path):
    inside = chunk(SCHEMA, CHANNEL, *(message(time, bytes([7]) * 100) for time in range(1, 11)))
    whole = mcap(tmp_path / "run.mcap", inside, ended=False).read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[:-170] + bytes(100))
    assert times(path) == list(range(1, 9))


def test_a_chunk_whose_beginning_would_fill_the_memory_is_refused(small_bounds, tmp_path):
    bomb = chunk(packing="zstd", data=zstandard.compress(bytes(2**26)), size=2**26)
    path = tmp_path / "bomb.mcap"
    path.write_bytes(mcap(path, bomb, ended=False).read_bytes()[:-1])
    with pytest.raises(RecordingError, match=r"bomb.mcap is not read: .* more than 1 MiB"):
        open_bag(path)


@pytest.mark.parametrize("content", [b"", random.Random(0).randbytes(5000), bytes(5000)])
def test_a_file_of_which_nothing_can_be_read_is_refused(tmp_path, content):
    path = tmp_path / "run.mcap"
    path.write_bytes(MCAP0_MAGIC + content)
    with pytest.raises(RecordingError, match=r"run.mcap begins as .* nothing .* can be read"):
        open_bag(path)


def test_a_killed_recording_is_read_by_mcap_s_reader_without_index(run, blocks):
    """What the README says to use without this suite."""
    whole = run.read_bytes()
    cut = BytesIO(whole[: len(whole) * 2 // 3])
    found = 0
    with pytest.raises(Exception, match=r"^"):  # noqa: PT012
        for _ in NonSeekingReader(cut).iter_messages(log_time_order=False):
            found += 1
    run.write_bytes(cut.getvalue())
    assert 0 < found <= summarize(run).topics[0].messages
