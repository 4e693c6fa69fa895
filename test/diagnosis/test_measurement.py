"""Measurements in fewer samples, and how they begin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.observation.coloured_noise import Coloured
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import OFTEN, Measurement
from tissue_probe.diagnosis.observation.noise import Noise
from tissue_probe.physics.composition import Composition

RANDOM = np.random.default_rng(5)
POSITION, FORCE = RANDOM.normal(size=(2, 1000))


@given(rate=st.floats(100.0, 20_000.0), seen=st.integers(0, 999))
def test_thinned_samples_are_some_of_those_measured_and_none_too_far_apart(rate, seen):
    used = np.arange(1000) != seen
    whole = Measurement(POSITION, FORCE, 1.0 / rate, noise=Noise(1.0), used=used)
    few = whole.thin_samples()
    assert few.sample_period <= max(OFTEN, whole.sample_period) * (1.0 + 1e-5)
    assert few.sample_period > 0.5 * OFTEN or few is whole
    kept = slice(None, None, round(few.sample_period * rate))
    np.testing.assert_array_equal(few.position, POSITION[kept])
    np.testing.assert_array_equal(few.force, FORCE[kept])
    np.testing.assert_array_equal(few.used, used[kept])
    assert (few.noise, few.at_rest) == (whole.noise, whole.at_rest)


@pytest.mark.parametrize(
    "whole",
    [
        Measurement(POSITION, FORCE, OFTEN, noise=Noise(1.0)),
        Measurement(POSITION, FORCE, OFTEN / 2, noise=Coloured(1.0, np.eye(2), 1.0)),
    ],
    ids=["slow", "filtered"],
)
def test_what_is_slow_or_filtered_keeps_all_samples(whole):
    assert whole.thin_samples() is whole


@given(
    phase=st.floats(0.0, 2.0 * np.pi),
    frequency=st.floats(1.0, 30.0),
    period=st.sampled_from([2e-4, 5e-4, 1e-3]),
)
def test_the_first_speed_is_that_of_the_motion(phase, frequency, period):
    at = 2.0 * np.pi * frequency
    position = np.sin(at * np.arange(100) * period + phase)
    first = Measurement(position, position, period, noise=Noise(1.0)).first_speed
    assert first == pytest.approx(at * np.cos(phase), abs=at * (at * 8 * period) ** 2)


def test_the_tip_begins_at_rest_or_with_the_coil():
    position = 1e-3 * np.sin(20.0 * np.pi * np.arange(2000) * 5e-4)
    for at_rest, speed in ((True, 0.0), (False, 0.02 * np.pi)):
        seen = Measurement(position, 300.0 * position, 5e-4, at_rest, noise=Noise(5e-3))
        problem = Problem(Composition(), [seen], Instrument())
        (begun,) = problem.begin(problem.nominal)
        assert begun.mean[1] == pytest.approx(speed, rel=0.01)


def test_noise_of_a_short_position_is_not_taken_for_motion_by_chance():
    # Of so few samples likeness of two white noises is often as large as that of a motion.
    time = np.arange(300) / 250.0
    depth = 1e-3 * np.sin(2.0 * np.pi * 3.0 * time)
    for seed in range(100):
        of_depth, of_force = np.random.default_rng(seed).normal(size=(2, time.size))
        read = Measurement(depth + 1e-5 * of_depth, 1e3 * depth + 0.1 * of_force, 4e-3)
        assert read.position_noise == pytest.approx(1e-5, rel=0.4)
