"""The bytes are those that rclpy reads and writes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Float64

from tissue_probe.mapping.fusion import Estimate
from tissue_probe.nodes import cdr
from tissue_probe.nodes.conversions import (
    estimate_from_message,
    samples_from_message,
    samples_to_message,
)
from tissue_probe.signals import FloatArray, SampleBlock, Status, TissueEstimates
from tissue_probe_msgs.msg import ProbeSamples, TissueEstimate

any_float = st.floats(width=64)
stamps = st.integers(0, 2**31 * 10**9 - 1)
sequences = st.integers(0, 2**63 - 1)
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
    frame_id=names,
    values=st.lists(any_float, min_size=10, max_size=10),
    status=st.sampled_from(list(Status)),
)
def test_the_last_estimate_is_what_rclpy_reads_and_what_we_read(
    stamp, sequence, estimator, frame_id, values, status
):
    estimates = TissueEstimates(
        estimator,
        np.array([0, stamp]),
        np.array([0, sequence]),
        *(np.array([0.0, value]) for value in values),
        np.array([0, status], dtype=np.uint8),
    )
    data = cdr.last_estimate_to_cdr(estimates, frame_id)
    message = deserialize_message(data, TissueEstimate)
    assert message.header.frame_id == frame_id
    back = estimate_from_message(message)
    assert back.estimator == estimator
    for ours, theirs in zip(back.arrays(), estimates[1:].arrays(), strict=True):
        assert np.array_equal(ours, theirs, equal_nan=True)
    name, found_status, found = cdr.estimate_from_cdr(serialize_message(message))
    assert (name, found_status) == (estimator, status)
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
