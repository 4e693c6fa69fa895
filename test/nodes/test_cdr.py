"""The bytes are those that rclpy reads and writes."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, WrenchStamped
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Float64, Header

from tissue_probe.mapping.fusion import Estimate
from tissue_probe.nodes import cdr
from tissue_probe.nodes.conversions import (
    estimate_from_message,
    samples_from_message,
    samples_to_message,
)
from tissue_probe.signals import (
    LAST_SEQUENCE,
    LAST_STAMP,
    LONGEST_PERIOD,
    MOST_SAMPLES,
    SHORTEST_PERIOD,
    TEXT,
    FloatArray,
    SampleBlock,
    Status,
    TissueEstimates,
)
from tissue_probe_msgs.msg import ProbeSamples, TissueEstimate

any_float = st.floats(width=64)
stamps = st.integers(0, LAST_STAMP - 10**9)
sequences = st.integers(0, LAST_SEQUENCE - 40)
names = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=20)
sample_arrays = npst.arrays(float, st.tuples(st.just(3), st.integers(1, 40)), elements=any_float)


def blocks_agree(ours: SampleBlock, theirs: SampleBlock) -> bool:
    same = (ours.stamp, ours.sequence, ours.sample_period) == (
        theirs.stamp,
        theirs.sequence,
        theirs.sample_period,
    )
    return same and all(
        np.array_equal(getattr(ours, name), getattr(theirs, name), equal_nan=True)
        for name in ("position", "force", "command")
    )


@given(stamp=stamps, sequence=sequences, frame_id=names, samples=sample_arrays)
def test_samples_that_we_write_are_what_rclpy_reads(stamp, sequence, frame_id, samples: FloatArray):
    block = SampleBlock(stamp, sequence, 0.0005, *samples)
    message = deserialize_message(cdr.samples_to_cdr(block, frame_id), ProbeSamples)
    assert message.header.frame_id == frame_id
    assert blocks_agree(samples_from_message(message), block)


@given(stamp=stamps, sequence=sequences, frame_id=names, samples=sample_arrays)
def test_samples_that_rclpy_writes_are_what_we_read(stamp, sequence, frame_id, samples: FloatArray):
    block = SampleBlock(stamp, sequence, 0.0005, *samples)
    back, name = cdr.samples_from_cdr(serialize_message(samples_to_message(block, frame_id)))
    assert name == frame_id
    assert blocks_agree(back, block)


@given(length=st.integers(0, 100))
def test_samples_that_are_cut_off_are_refused(length):
    data = cdr.samples_to_cdr(SampleBlock(1, 7, 0.0005, *np.ones((3, 4))), "probe")
    with pytest.raises(ValueError, match=r"cut off|encoded"):
        cdr.samples_from_cdr(data[: min(length, len(data) - 8)])


def test_samples_without_values_are_refused():
    with pytest.raises(ValueError, match="at least one"):
        cdr.samples_from_cdr(serialize_message(ProbeSamples(sample_period=0.0005)))


@pytest.mark.parametrize("read", [cdr.samples_from_cdr, cdr.estimate_from_cdr])
def test_big_endian_bytes_are_refused(read):
    with pytest.raises(ValueError, match="little-endian"):
        read(b"\x00\x00" + bytes(300))


@given(
    stamp=stamps,
    sequence=sequences,
    estimator=names,
    model=names,
    frame_id=names,
    values=st.lists(any_float, min_size=10, max_size=10),
    status=st.sampled_from(list(Status)),
)
def test_the_last_estimate_is_what_rclpy_reads_and_what_we_read(
    stamp, sequence, estimator, model, frame_id, values, status
):
    estimates = TissueEstimates(
        estimator,
        np.array([0, stamp]),
        np.array([0, sequence]),
        *(np.array([0.0, value]) for value in values),
        np.array([0, status], dtype=np.uint8),
        np.array(["another", model], dtype=TEXT),
    )
    data = cdr.last_estimate_to_cdr(estimates, frame_id)
    message = deserialize_message(data, TissueEstimate)
    assert message.header.frame_id == frame_id
    back = estimate_from_message(message)
    assert back.estimator == estimator
    for ours, theirs in zip(back.arrays(), estimates[1:].arrays(), strict=True):
        assert np.array_equal(ours, theirs, equal_nan=True)
    name, found_status, found, number = cdr.estimate_from_cdr(serialize_message(message))
    assert (name, found_status, number) == (estimator, status, sequence)
    expected = [getattr(back, field)[0] for field in Estimate._fields]
    assert np.array_equal(found, expected, equal_nan=True)


@given(length=st.integers(0, 100))
def test_an_estimate_that_is_cut_off_is_refused(length):
    data = serialize_message(TissueEstimate(estimator="ekf"))
    with pytest.raises(ValueError, match=r"cut off|encoded"):
        cdr.estimate_from_cdr(data[:length])


@given(value=any_float)
def test_a_number_is_what_rclpy_writes(value):
    assert cdr.float64_to_cdr(value) == serialize_message(Float64(data=value))


@given(stamp=stamps, value=any_float, frame_id=names)
def test_single_samples_that_we_write_are_what_rclpy_reads(stamp, value, frame_id):
    header = Header(stamp=Time(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id=frame_id)
    pose, wrench = PoseStamped(header=header), WrenchStamped(header=header)
    pose.pose.position.z = wrench.wrench.force.z = value
    for ours, theirs in (
        (cdr.pose_to_cdr(stamp, value, frame_id), pose),
        (cdr.wrench_to_cdr(stamp, value, frame_id), wrench),
    ):
        assert len(ours) == len(serialize_message(theirs))
        # By their texts, in which no number is equal to itself.
        assert repr(deserialize_message(ours, type(theirs))) == repr(theirs)


def read_or_refused(data: bytes) -> SampleBlock | None:
    """A block that lies within the bounds, or none if it was refused with a sentence."""
    said = ""
    try:
        block, _ = cdr.samples_from_cdr(data)
    except ValueError as error:
        said = str(error)
    if said:
        assert len(said.split()) > 3
        return None
    assert SHORTEST_PERIOD <= block.sample_period <= LONGEST_PERIOD
    assert 1 <= len(block) <= MOST_SAMPLES
    assert len(block.force) == len(block.command) == len(block)
    assert 0 <= block.stamp <= block.end <= LAST_STAMP
    assert block.stamps[-1] < 2**63
    assert block.sequence >= 0
    assert np.arange(block.sequence, block.sequence + len(block)).dtype == np.int64
    return block


any_period = st.one_of(any_float, st.sampled_from([0.0, 5e-4, 1e9, 1e300, 5e-324, 2.0, 1e-6]))


@given(
    seconds=st.integers(-(2**31), 2**31 - 1),
    nanoseconds=st.integers(0, 2**32 - 1),
    sequence=st.integers(0, 2**64 - 1),
    period=any_period,
    lengths=st.one_of(
        st.integers(0, 30).map(lambda n: (n, n, n)), st.tuples(*[st.integers(0, 30)] * 3)
    ),
)
@example(seconds=0, nanoseconds=0, sequence=0, period=1e300, lengths=(1, 1, 1))
@example(seconds=0, nanoseconds=0, sequence=0, period=1e9, lengths=(1, 1, 1))
@example(seconds=2**31 - 1, nanoseconds=0, sequence=0, period=5e-4, lengths=(10, 10, 10))
@example(seconds=0, nanoseconds=0, sequence=2**63, period=5e-4, lengths=(10, 10, 10))
def test_samples_of_any_values_are_sound_or_refused(
    seconds, nanoseconds, sequence, period, lengths
):
    position, force, command = ([0.0] * length for length in lengths)
    message = ProbeSamples(
        header=Header(stamp=Time(sec=seconds, nanosec=nanoseconds)),
        sequence=sequence,
        sample_period=period,
        position=position,
        force=force,
        command=command,
    )
    block = read_or_refused(serialize_message(message))
    with contextlib.suppress(ValueError):
        assert blocks_agree(samples_from_message(message), block)
        return
    assert block is None


@given(data=st.binary(max_size=200))
def test_any_bytes_are_sound_samples_or_refused(data):
    read_or_refused(data)
    read_or_refused(cdr.LITTLE_ENDIAN + b"\0\0" + data)


@given(at=st.integers(0, 170), wrong=st.binary(min_size=1, max_size=8))
def test_damaged_samples_are_sound_or_refused(at, wrong):
    data = cdr.samples_to_cdr(SampleBlock(10**18, 7, 0.0005, *np.ones((3, 4))), "probe")
    read_or_refused(data[:at] + wrong + data[at + len(wrong) :])


def test_a_message_of_too_many_samples_is_refused():
    block = SampleBlock(0, 0, 0.0005, *np.zeros((3, MOST_SAMPLES + 1)))
    with pytest.raises(ValueError, match="one message holds up to"):
        cdr.samples_from_cdr(cdr.samples_to_cdr(block, "probe"))


@given(data=st.binary(max_size=200))
def test_any_bytes_are_an_estimate_with_a_stamp_or_refused(data):
    with contextlib.suppress(ValueError):
        *_, found, _ = cdr.estimate_from_cdr(cdr.LITTLE_ENDIAN + b"\0\0" + data)
        assert 0 <= found.stamp <= LAST_STAMP
