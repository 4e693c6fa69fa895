"""NIS and NEES: the variances that a filter claims against the errors that it makes."""

import numpy as np
import pytest
from measured import block_of

from benchmarks.estimators_simulator import Experiment
from tissue_probe.estimation import Estimator, EstimatorSettings

SEEDS = range(700, 720)
KALMAN = ["robust_ekf", "ekf", "ukf", "afekf"]


@pytest.fixture(scope="module", params=KALMAN)
def runs(request):
    return [
        Estimator(request.param, EstimatorSettings().exact()).process(
            block_of(Experiment(duration=0.5, seed=seed))
        )
        for seed in SEEDS
    ]


def test_the_nis_is_that_of_chi_squared_with_one_degree_of_freedom(runs):
    nis = np.concatenate([run.normalized_innovation_squared[100:] for run in runs])
    assert 0.93 <= np.mean(nis < 3.841) <= 0.97
    assert 0.8 <= nis.mean() <= 1.05


def test_innovations_are_white(runs):
    nu = np.array([run.innovation[100:] for run in runs])
    correlation = np.mean(nu[:, 1:] * nu[:, :-1]) / np.mean(nu**2)
    assert abs(correlation) < 0.15


def test_errors_stay_within_what_the_covariance_claims(runs):
    """NEES of (k, beta): the paper's process noise makes the claim a cautious one."""
    inside = []
    for run in runs:
        e, f = run.stiffness[100:] - 450, run.damping[100:] - 5
        kk, bb = run.stiffness_variance[100:], run.damping_variance[100:]
        kb = run.stiffness_damping_covariance[100:]
        nees = (e**2 * bb - 2 * e * f * kb + f**2 * kk) / (kk * bb - kb**2)
        inside.append(np.mean(nees < 5.991))
    assert np.mean(inside) >= 0.85


def test_ekf_and_ukf_agree_since_the_measurement_is_linear():
    block = block_of(Experiment(duration=1.0))
    ekf, ukf = (Estimator(n, EstimatorSettings().exact()).process(block) for n in ("ekf", "ukf"))
    np.testing.assert_allclose(ekf.stiffness[400:], ukf.stiffness[400:], rtol=1e-4)
    np.testing.assert_allclose(ekf.damping[400:], ukf.damping[400:], rtol=5e-4)


def test_a_filter_that_claims_less_noise_than_there_is_fails_the_same_test():
    """That the test can fail: half the true noise is claimed."""
    block = block_of(Experiment(duration=0.5))
    estimates = Estimator("ekf", EstimatorSettings(force_noise=2.5e-3).exact()).process(block)
    nis = estimates.normalized_innovation_squared[100:]
    assert np.mean(nis < 3.841) < 0.75
