"""A known delay between force and position is taken out, causally, whatever the blocks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.alignment import Alignment

T = np.arange(4000) * 5e-4


def motion(time):
    return np.sin(2.0 * np.pi * 10.0 * time)


@given(delay=st.floats(-12.0, 12.0))
def test_the_same_instant_stands_in_both_channels(delay):
    late = 5e-4 * delay
    position, force = Alignment(delay).apply(motion(T), motion(T - late))
    np.testing.assert_allclose(position[20:], force[20:], atol=1e-6)


@given(delay=st.floats(-12.0, 12.0), cuts=st.lists(st.integers(1, 30), min_size=1))
def test_blocks_of_any_size_give_the_same(delay, cuts):
    position, force = motion(T[:300]), motion(T[:300] + 0.01)
    whole = Alignment(delay).apply(position, force)
    ends = np.clip(np.cumsum(cuts), 0, 300)
    piecewise = Alignment(delay)
    parts = [
        piecewise.apply(p, f)
        for p, f in zip(np.split(position, ends), np.split(force, ends), strict=True)
        if p.size
    ]
    for one, other in zip(whole, map(np.concatenate, zip(*parts, strict=True)), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("delay", [0.4, -0.4, 3.7, -3.7])
def test_nothing_of_what_is_to_come_is_used(delay):
    step = np.where(T < 1.0, 0.0, 1.0)
    for channel in Alignment(delay).apply(step, step):
        assert not channel[T < 1.0].any()


def test_without_a_delay_the_samples_are_untouched():
    position, force = Alignment(0.0).apply(T, -T)
    assert position is T
    np.testing.assert_array_equal(force, -T)
