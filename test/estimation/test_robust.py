"""What the recommended filter adds: changes, constant forces, coarse encoders, wrong models."""

import numpy as np
import pytest
from measured import block_of

from benchmarks.estimators_simulator import Experiment, HardeningTissue, simulate_ramp
from tissue_probe.estimation import Estimator, EstimatorSettings
from tissue_probe.signals import Status

SEEDS = range(500, 505)


def estimate(experiment, name="robust_ekf", **settings):
    return Estimator(name, EstimatorSettings(**settings).exact()).process(block_of(experiment))


def settled_within(experiment, begin, limit, name="robust_ekf"):
    """Whether k and beta stay within 5 % of the truth from ``limit`` [s] after ``begin`` on."""
    estimates = estimate(experiment, name)
    late = slice(round((begin + limit) / experiment.sample_period) + 1, None)
    k, b = (values[late] for values in experiment.truth())
    errors = np.abs(estimates.stiffness[late] - k), np.abs(estimates.damping[late] - b)
    return np.all(errors[0] <= 0.05 * np.maximum(k, 450)) and np.all(
        errors[1] <= 0.05 * np.maximum(b, 5)
    )


@pytest.mark.parametrize("seed", [3008, 3049, *SEEDS])
def test_tissue_is_known_soon_after_the_start_whatever_the_noise(seed):
    """Tangents alone would believe wild first estimates: within 5 % after 112 ms in seed 3008."""
    assert settled_within(Experiment(duration=0.5, seed=seed), 0.0, 0.025)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("after", [(900.0, 10.0), (225.0, 2.5), (0.0, 0.0)])
def test_a_change_of_tissue_is_followed(seed, after):
    at = 0.5 + 0.02 * (seed % 5) + 1.7e-4
    experiment = Experiment(tissue=((0.0, 450.0, 5.0), (at, *after)), duration=1.0, seed=seed)
    assert settled_within(experiment, at, 0.05)


@pytest.mark.parametrize("disturbance", [{"force_offset": 0.1}, {"contact_zero": 1e-3}])
def test_a_constant_force_is_estimated_instead_of_spoiling_the_rest(disturbance):
    estimates = estimate(Experiment(duration=2.0, **disturbance))
    assert estimates.stiffness[2000:].mean() == pytest.approx(450, rel=1e-3)
    assert estimates.damping[2000:].mean() == pytest.approx(5, rel=3e-3)
    expected = disturbance.get("force_offset", -9700 * 450 / 10150 * 1e-3)
    assert estimates.force_offset[-1] == pytest.approx(expected, abs=2e-3)


def test_a_change_under_preload_moves_the_offset_too():
    tissue = ((0.0, 450.0, 5.0), (0.7, 900.0, 10.0))
    experiment = Experiment(tissue=tissue, contact_zero=2e-3, duration=1.5)
    assert settled_within(experiment, 0.7, 0.15)


@pytest.mark.parametrize("seed", [2009, *SEEDS])
def test_a_filter_that_has_lost_its_way_begins_anew(seed):
    """5 mm of preload, far beyond the offset's prior, and the tissue doubles under it."""
    tissue = ((0.0, 450.0, 5.0), (0.7, 900.0, 10.0))
    experiment = Experiment(tissue=tissue, contact_zero=5e-3, duration=1.5, seed=seed)
    assert settled_within(experiment, 0.7, 0.3)


def test_a_coarse_encoder_is_noise_that_the_filter_knows_of():
    experiment = Experiment(duration=2.0, encoder_resolution=5e-6)
    estimates = estimate(experiment, encoder_resolution=5e-6)
    inside = estimates.normalized_innovation_squared[200:] < 3.841
    assert 0.93 <= inside.mean() <= 0.98
    assert estimates.stiffness[-1] == pytest.approx(450, rel=0.01)


def test_a_ramp_of_stiffness_and_damping_is_followed():
    experiment = simulate_ramp((450.0, 5.0), (900.0, 10.0), start=0.5, length=0.1, duration=0.8)
    estimates = estimate(experiment)
    for truth, value in zip(
        experiment.truth(), (estimates.stiffness, estimates.damping), strict=True
    ):
        error = (value / truth - 1)[1000:1200]
        assert np.sqrt(np.mean(error**2)) < 0.08
    assert not np.any(estimates.status == Status.MODEL_REJECTED)


@pytest.mark.parametrize("after", [(900.0, 5.0), (450.0, 10.0)])
@pytest.mark.parametrize("seed", SEEDS)
def test_a_change_of_only_one_of_the_two_is_followed(seed, after):
    """Though after a change the filter takes both to go on changing by the same share."""
    at = 0.5 + 0.02 * (seed % 5) + 1.7e-4
    experiment = Experiment(tissue=((0.0, 450.0, 5.0), (at, *after)), duration=1.0, seed=seed)
    assert settled_within(experiment, at, 0.05)


def test_a_wrong_model_is_rejected_and_the_estimate_stays_calm():
    estimates = estimate(HardeningTissue(duration=2.0, hardening=0.2))
    assert np.all(estimates.status[2500:] == Status.MODEL_REJECTED)
    assert estimates.stiffness[2500:].std() < 0.01 * 450


def test_a_model_is_accepted_again_when_it_fits_again():
    """Not at once: after so long that a wrong one would have been contradicted again."""
    wrong = HardeningTissue(duration=1.0, hardening=0.5)
    right = Experiment(duration=12.0, encoder_resolution=0)
    estimator = Estimator("robust_ekf", EstimatorSettings().exact())
    assert estimator.process(block_of(wrong)).status[-1] == Status.MODEL_REJECTED
    after = estimator.process(block_of(right, first=2000))
    assert np.all(after.status[: 9 * 2000] == Status.MODEL_REJECTED)
    assert after.status[-1] == Status.CONVERGED
    assert after.stiffness[-1] == pytest.approx(450, rel=0.01)


@pytest.mark.parametrize("name", ["ekf", "ukf", "afekf"])
def test_the_papers_filters_say_that_a_change_contradicts_them(name):
    experiment = Experiment(tissue=((0.0, 450.0, 5.0), (0.5, 900.0, 10.0)), duration=0.8)
    estimates = estimate(experiment, name)
    assert estimates.status[990] == Status.CONVERGED
    assert estimates.status[-1] == Status.MODEL_REJECTED


def test_a_lost_contact_is_reported():
    experiment = Experiment(tissue=((0.0, 450.0, 5.0), (0.5, 0.0, 0.0)), duration=0.8)
    estimates = estimate(experiment)
    assert estimates.status[-1] == Status.NO_CONTACT
    assert not np.any(estimates.status[:1000] == Status.NO_CONTACT)
