"""Noise of 1/f beside white noise: its weights make it white, and fits are told its level."""

from __future__ import annotations

import numpy as np
import pytest
from hidden import EXACT, TOLERANT, challenge, first_of, measurement
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.challenge.instrument import pink_noise
from tissue_probe.diagnosis.observation.flicker import Evening
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
from tissue_probe.diagnosis.ranking.rules import significant
from tissue_probe.diagnosis.residuals.all_tests import residual_tests
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS

#: Of all cosines the same power.
WHITE = np.ones(())


@pytest.mark.parametrize("level", [0.2, 1.0, 3.0])
def test_white_and_flicker_noise_together_come_out_white(level):
    random, count = np.random.default_rng(1), 4000
    noise = [random.normal(size=count) + level * pink_noise(count, random) for _ in range(60)]
    white = Evening.of(count, level, WHITE).even(np.transpose(noise))
    for first, stop in ((1, 11), (11, 101), (101, 1001), (1001, 4000)):
        power = np.mean(white[first:stop] ** 2)
        assert abs(power - 1.0) < 5.0 * np.sqrt(2.0 / (60 * (stop - first))) + 0.05, (first, power)


@given(st.integers(2, 3000), st.floats(0.0, 1e3))
def test_weights_lie_between_nothing_and_one_and_rise_with_frequency(count, level):
    weights = np.atleast_1d(Evening.of(count, level, WHITE).weights)
    assert np.all((weights > 0.0) & (weights <= 1.0))
    assert np.all(np.diff(weights) >= 0.0)


def test_without_flicker_noise_the_sum_of_squares_is_kept():
    columns = np.random.default_rng(2).normal(size=(500, 3))
    same = Evening.of(500, 0.0, WHITE).cosines(columns)
    assert np.allclose(same.T @ same, columns.T @ columns)


def test_slow_noise_of_the_stated_level_leaves_a_residual_of_one_and_no_drift():
    """On the tolerant rig the challenge adds 1 mN of it to 5 mN of white noise."""
    measured = measurement(challenge(21, rig="tolerant", excitation="msine60").recording)
    base = fit_base(Composition(), [measured], TOLERANT)
    assert abs(base.ratio - 1.0) < 0.05
    drifts = [EFFECTS[name] for name in ("force_drift", "tissue_motion", "stiffness_step")]
    assert not any(significant(base, fit, base) for fit in fit_candidates(base, drifts, TOLERANT))


@pytest.mark.parametrize("seed", first_of(range(490000, 490004), 1))
def test_a_right_model_passes_every_test_of_its_residual_where_slow_noise_is_known(seed):
    measured = measurement(challenge(seed, rig="tolerant", excitation="chirp60").recording)
    base = fit_base(Composition(), [measured], TOLERANT)
    record = (measured.position, measured.sample_period, measured.noise.own)
    assert all(test.passed for test in residual_tests(base.evened[0], *record))
    assert not all(test.passed for test in residual_tests(base.residuals[0], *record))


def test_a_rig_that_is_known_exactly_has_none():
    assert EXACT.flicker_noise == 0.0
    assert TOLERANT.flicker_noise > 0.0
