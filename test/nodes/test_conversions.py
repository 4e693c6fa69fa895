"""Every message gives back what was put into it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from rclpy.serialization import deserialize_message, serialize_message

from tissue_probe.nodes import conversions
from tissue_probe.signals import (
    FARTHEST_PLACE,
    LAST_SEQUENCE,
    LAST_STAMP,
    FloatArray,
    Leaving,
    PalpationSite,
    Phase,
    SampleBlock,
    Status,
)
from tissue_probe_msgs.msg import PalpationSite as PalpationSiteMessage
from tissue_probe_msgs.msg import TissueEstimate

any_float = st.floats(width=64)
stamps = st.integers(0, LAST_STAMP - 10**9)


def sent(message):
    """The message as it comes out of the wire at the other end."""
    return deserialize_message(serialize_message(message), type(message))


@given(
    stamp=stamps,
    sequence=st.integers(0, LAST_SEQUENCE - 40),
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
    site=st.integers(0, 2**32 - 1),
    position=st.tuples(*[st.floats(-FARTHEST_PLACE, FARTHEST_PLACE)] * 3),
    phase=st.sampled_from(list(Phase)),
    leaving=st.sampled_from(list(Leaving)),
)
def test_a_site_comes_back(stamp, site, position, phase, leaving):
    announcement = PalpationSite(stamp, site, position, phase, leaving)
    message = sent(conversions.site_to_message(announcement, "stage"))
    assert conversions.site_from_message(message) == announcement


def test_a_phase_that_does_not_exist_is_refused():
    with pytest.raises(ValueError, match="99"):
        conversions.site_from_message(PalpationSiteMessage(phase=99))


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -1e300, 2 * FARTHEST_PLACE])
def test_a_place_that_no_robot_reaches_is_refused(wrong):
    site, pose = PalpationSiteMessage(), PoseStamped()
    site.position.y = pose.pose.position.y = wrong
    for convert, message in (
        (conversions.site_from_message, site),
        (conversions.place_from_message, pose),
    ):
        with pytest.raises(ValueError, match="no place within"):
            convert(message)


@pytest.mark.parametrize("seconds", [-1, 2**31 - 1])
def test_a_stamp_of_a_site_that_leaves_no_time_is_refused(seconds):
    site = PalpationSiteMessage()
    site.header.stamp.sec = seconds
    with pytest.raises(ValueError, match="no time from 0"):
        conversions.site_from_message(site)


def test_the_messages_constants_are_those_of_the_package():
    for status in Status:
        assert getattr(TissueEstimate, status.name) == status
    for phase in Phase:
        assert getattr(PalpationSiteMessage, phase.name) == phase
