"""Every message gives back what was put into it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from rclpy.serialization import deserialize_message, serialize_message

from tissue_probe.nodes import conversions
from tissue_probe.signals import (
    FloatArray,
    PalpationSite,
    Phase,
    SampleBlock,
    Status,
    TissueEstimates,
)
from tissue_probe_msgs.msg import PalpationSite as PalpationSiteMessage
from tissue_probe_msgs.msg import ProbeSamples, TissueEstimate

any_float = st.floats(width=64)
stamps = st.integers(0, 2**31 * 10**9 - 1)


def sent(message):
    """The message as it comes out of the wire at the other end."""
    return deserialize_message(serialize_message(message), type(message))


@given(
    stamp=stamps,
    sequence=st.integers(0, 2**63 - 1),
    samples=npst.arrays(float, st.tuples(st.just(3), st.integers(1, 40)), elements=any_float),
)
def test_samples_come_back_bit_for_bit(stamp, sequence, samples: FloatArray):
    block = SampleBlock(stamp, sequence, 0.0005, *samples)
    message = sent(conversions.samples_to_message(block, "probe"))
    back = conversions.samples_from_message(message)
    assert message.header.frame_id == "probe"
    assert (back.stamp, back.sequence, back.sample_period) == (stamp, sequence, 0.0005)
    for name in ("position", "force", "command"):
        assert np.array_equal(getattr(back, name), getattr(block, name), equal_nan=True)


@given(
    stamp=stamps,
    frame_id=st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=20),
    samples=npst.arrays(float, st.tuples(st.just(3), st.integers(1, 40)), elements=any_float),
)
def test_serialized_samples_are_read_as_rclpy_reads_them(stamp, frame_id, samples: FloatArray):
    block = SampleBlock(stamp, 7, 0.0005, *samples)
    data = serialize_message(conversions.samples_to_message(block, frame_id))
    back, name = conversions.samples_from_cdr(data)
    theirs = conversions.samples_from_message(deserialize_message(data, ProbeSamples))
    assert name == frame_id
    assert (back.stamp, back.sequence, back.sample_period) == (
        theirs.stamp,
        theirs.sequence,
        theirs.sample_period,
    )
    for array in ("position", "force", "command"):
        assert np.array_equal(getattr(back, array), getattr(theirs, array), equal_nan=True)


@given(length=st.integers(0, 100))
def test_serialized_samples_that_are_cut_off_are_refused(length):
    block = SampleBlock(1, 7, 0.0005, *np.ones((3, 4)))
    data = serialize_message(conversions.samples_to_message(block, "probe"))
    with pytest.raises(ValueError, match=r"cut off|encoded"):
        conversions.samples_from_cdr(data[: min(length, len(data) - 8)])


def test_serialized_samples_without_values_are_refused():
    with pytest.raises(ValueError, match="at least one"):
        conversions.samples_from_cdr(serialize_message(ProbeSamples(sample_period=0.0005)))


@given(
    stamp=stamps,
    sequence=st.integers(0, 2**63 - 1),
    values=st.lists(any_float, min_size=10, max_size=10),
    status=st.sampled_from(list(Status)),
)
def test_the_last_estimate_comes_back(stamp, sequence, values, status):
    rows = [np.array([0.0, value]) for value in values]
    estimates = TissueEstimates(
        "ukf",
        np.array([0, stamp]),
        np.array([0, sequence]),
        *rows,
        np.array([0, status], dtype=np.uint8),
    )
    back = conversions.estimate_from_message(
        sent(conversions.last_estimate_to_message(estimates, "probe"))
    )
    assert back.estimator == "ukf"
    for ours, theirs in zip(back.arrays(), estimates[1:].arrays(), strict=True):
        assert np.array_equal(ours, theirs, equal_nan=True)


@given(
    stamp=stamps,
    site=st.integers(0, 2**32 - 1),
    position=st.tuples(*[st.floats(allow_nan=False)] * 3),
    phase=st.sampled_from(list(Phase)),
)
def test_a_site_comes_back(stamp, site, position, phase):
    announcement = PalpationSite(stamp, site, position, phase)
    message = sent(conversions.site_to_message(announcement, "stage"))
    assert conversions.site_from_message(message) == announcement


def test_a_phase_that_does_not_exist_is_refused():
    with pytest.raises(ValueError, match="99"):
        conversions.site_from_message(PalpationSiteMessage(phase=99))


def test_the_messages_constants_are_those_of_the_package():
    for status in Status:
        assert getattr(TissueEstimate, status.name) == status
    for phase in Phase:
        assert getattr(PalpationSiteMessage, phase.name) == phase
