"""Whatever comes in, an estimate is a number with a covariance that deserves the name."""

import dataclasses

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from measured import START

from benchmarks.estimators_simulator import Experiment
from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.signals import SampleBlock

EXTREME = [0.0, -0.0, 1e-300, 1e-3, -1.0, 1e6, -1e12, 1e160, 1e300, np.nan, np.inf, -np.inf]


@st.composite
def streams(draw):
    """Return blocks of one stream: sines, spikes, saturation, stuck values, gaps, bad samples."""
    period = draw(st.sampled_from([1e-4, 5e-4, 2e-3]))
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    blocks, sequence = [], 0
    for _ in range(draw(st.integers(1, 4))):
        count = draw(st.integers(1, 150))
        amplitude = draw(st.sampled_from([0.0, 1e-6, 1e-3, 0.1, 1e4]))
        time = (sequence + np.arange(count)) * period
        position = amplitude * np.sin(60 * time + draw(st.floats(0, 6)))
        position += draw(st.sampled_from([0.0, 0.0, 1e-3, -5.0]))
        force = draw(st.sampled_from([0.0, 450.0, -300.0, 1e5, 1e9])) * position
        force += draw(st.sampled_from([0.0, 5e-3, 10.0])) * random.standard_normal(count)
        if draw(st.booleans()):
            force = np.clip(force, -2.0, 2.0)
        for signal in (position, force):
            for _ in range(draw(st.integers(0, 3))):
                signal[draw(st.integers(0, count - 1))] = draw(st.sampled_from(EXTREME))
        blocks.append(SampleBlock(START, sequence, period, position, force, np.full(count, np.nan)))
        sequence += count + draw(st.sampled_from([0, 0, 1, 1000]))
    return blocks


def assert_sound(estimates):
    for entry in dataclasses.fields(estimates)[1:-1]:  # all but the names
        if entry.name not in ("innovation", "normalized_innovation_squared"):
            assert np.all(np.isfinite(getattr(estimates, entry.name))), entry.name
    missing = np.isnan(estimates.innovation)
    np.testing.assert_array_equal(missing, np.isnan(estimates.normalized_innovation_squared))
    nis = estimates.normalized_innovation_squared[~missing]
    assert np.all(np.isfinite(nis) & (nis >= 0))
    product = estimates.stiffness_variance * estimates.damping_variance
    assert np.all(estimates.stiffness_variance > 0)
    assert np.all(estimates.damping_variance > 0)
    assert np.all(estimates.stiffness_damping_covariance**2 <= product * (1 + 1e-6))
    assert np.all(estimates.covariance_trace >= estimates.stiffness_variance)


@pytest.mark.parametrize(
    ("name", "discretisation"), [*((name, "exact") for name in ESTIMATORS), ("ekf", "euler")]
)
@settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
@given(blocks=streams())
def test_estimates_are_sound_whatever_comes_in(name, discretisation, blocks):
    chosen = EstimatorSettings(discretisation=discretisation)
    estimator = Estimator(name, chosen)
    for block in blocks:
        estimates = estimator.process(block)
        assert len(estimates) == len(block)
        assert_sound(estimates)
        assert np.all(estimates.stiffness <= chosen.stiffness_maximum)
        assert np.all(estimates.stiffness >= chosen.stiffness_minimum)
        assert np.all(estimates.stiffness_variance <= chosen.stiffness_prior_sd**2 * (1 + 1e-12))


@pytest.mark.parametrize("seed", [415, 779])
def test_what_rounding_has_spoilt_begins_anew(seed):
    """After kilometres of motion the covariance may be one that no numbers have: S < 0."""
    random = np.random.default_rng(seed)
    period, count = 1e-4, int(random.integers(20, 150))
    far = 1e4 * np.sin(60 * period * np.arange(count) + random.uniform(0, 6))
    near = 1e-6 * np.sin(60 * period * np.arange(2) + random.uniform(0, 6))
    parts = [(far, 450.0 * far), (near, 10 * random.standard_normal(2))]
    estimator, sequence = Estimator("ekf", EstimatorSettings(discretisation="exact")), 0
    for position, force in parts + 4 * [(np.zeros(1), np.zeros(1))]:
        unknown = np.full(position.size, np.nan)
        block = SampleBlock(START, sequence, period, position, force, unknown)
        assert_sound(estimator.process(block))
        sequence += position.size


@pytest.mark.parametrize("name", ["robust_ekf", "afekf", "afukf", "lock_in", "rls"])
def test_an_estimator_that_forgets_finds_the_tissue_again_after_a_spike(name):
    position, force = Experiment(duration=2.0).run()
    force[1000] = 40.0
    block = SampleBlock(START, 0, 5e-4, position, force, np.full(force.size, np.nan))
    estimates = Estimator(name, EstimatorSettings()).process(block)
    assert estimates.stiffness[-1] == pytest.approx(450, rel=0.01)
    assert estimates.damping[-1] == pytest.approx(5, rel=0.02)
