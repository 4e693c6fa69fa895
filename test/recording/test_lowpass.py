"""Filtering all channels alike: what is slow passes, what is fast goes, nothing comes late."""

import numpy as np
import pytest

from tissue_probe.recording.clocks.lowpass import filter_block
from tissue_probe.signals import SampleBlock

PERIOD = 1e-3
TIME = PERIOD * np.arange(4000)
INSIDE = slice(50, -50)


def block(position, force=None):
    force = position if force is None else force
    return SampleBlock(0, 0, PERIOD, position, force, np.full(position.size, np.nan))


def test_a_slow_motion_passes_as_it_is_and_is_not_late():
    slow = np.sin(2 * np.pi * 5.0 * TIME)
    filtered = filter_block(block(slow, 3 * slow), 100.0)
    np.testing.assert_allclose(filtered.position[INSIDE], slow[::4][INSIDE], atol=1e-4)
    np.testing.assert_allclose(filtered.force, 3 * filtered.position, atol=1e-12)


def test_what_is_faster_goes():
    fast = np.sin(2 * np.pi * 300.0 * TIME)
    assert np.abs(filter_block(block(fast), 100.0).position[INSIDE]).max() < 1e-3


def test_samples_are_thinned_out_to_what_the_filter_leaves():
    filtered = filter_block(block(TIME), 40.0)
    assert filtered.sample_period == pytest.approx(10 * PERIOD)
    assert len(filtered) == filtered.command.size == 400


@pytest.mark.parametrize("frequency", [-1.0, 0.0, 0.2, 401.0])
def test_a_frequency_that_the_samples_do_not_bear_is_refused(frequency):
    with pytest.raises(ValueError, match=r"from 0\.25 to 400 Hz"):
        filter_block(block(TIME), frequency)


def test_too_few_samples_are_refused():
    with pytest.raises(ValueError, match="99 samples are too few"):
        filter_block(block(TIME[:99]), 100.0)
