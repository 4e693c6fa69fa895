"""Contact of a vibrating tip, felt as a change of the mean force over a period."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.mapping.touch import Touch
from tissue_probe.signals import SampleBlock

PERIOD = 0.0005  # s, of the samples
MASS = 0.04  # kg, of the tip


def feed(touch, time, force, frequency=10.0):
    """Give samples in blocks of ten until contact is felt; return when that was."""
    position = 0.001 * np.sin(2.0 * np.pi * frequency * time)
    inertia = -MASS * (2.0 * np.pi * frequency) ** 2 * position
    noise = 0.005 * np.random.default_rng(0).standard_normal(time.size)
    for first in range(0, time.size, 10):
        part = slice(first, first + 10)
        measured = inertia[part] + force(time[part], position[part]) + noise[part]
        block = SampleBlock(0, first, PERIOD, position[part], measured, np.zeros_like(measured))
        touch.add_samples(block)
        if touch.is_felt:
            return float(time[part][-1])
    return None


@settings(max_examples=20, deadline=None)
@given(st.floats(5.0, 40.0), st.floats(-0.5, 0.5))
def test_in_free_air_nothing_is_felt_whatever_the_cell_shows_without_load(frequency, zero):
    touch = Touch(0.02)
    time = np.arange(4000) * PERIOD
    assert feed(touch, time, lambda t, u: np.full(t.size, zero), frequency) is None
    assert touch.period == pytest.approx(1.0 / frequency, abs=0.3 / frequency)


@settings(max_examples=20, deadline=None)
@given(st.floats(200.0, 2000.0), st.floats(0.4, 0.6), st.booleans())
def test_tissue_is_felt_before_the_tip_is_far_in_it(stiffness, when, holds):
    speed = 0.001  # m/s: a tenth of a millimetre in a period

    def tissue(time, position):
        depth = speed * (time - when)
        pressed = stiffness * (depth + position)
        return np.where(depth >= 0.0, pressed if holds else np.maximum(pressed, 0.0), 0.0)

    felt = feed(Touch(0.02), np.arange(4000) * PERIOD, tissue)
    assert felt is not None
    assert 0.0 <= speed * (felt - when) <= 0.0002


def test_the_largest_change_of_the_force_is_told():
    touch = Touch(100.0)
    time = np.arange(2000) * PERIOD
    feed(touch, time, lambda t, u: 0.3 + np.where(t > 0.5, 4.0, 0.0))
    # The step, and the tip's inertia at the height of its motion.
    assert touch.most == pytest.approx(4.0 + MASS * (2.0 * np.pi * 10.0) ** 2 * 0.001, abs=0.05)
