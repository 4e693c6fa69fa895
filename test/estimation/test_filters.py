"""Every Kalman filter finds the tissue, and says truthfully how well it knows it."""

import numpy as np
import pytest
from measured import block_of

from benchmarks.estimators_simulator import Experiment
from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.estimation.layout import force_variance
from tissue_probe.signals import Status

EXACT = EstimatorSettings().exact()
EULER = EstimatorSettings(discretisation="euler").exact()


def estimate(name, experiment, settings=EXACT):
    return Estimator(name, settings).process(block_of(experiment))


@pytest.mark.parametrize("name", ESTIMATORS)
def test_stiffness_and_damping_are_found(name):
    estimates = estimate(name, Experiment(duration=1.0))
    assert estimates.stiffness[-1] == pytest.approx(450, rel=0.005)
    assert estimates.damping[-1] == pytest.approx(5, rel=0.01)
    assert estimates.status[0] == Status.CONVERGING
    assert estimates.status[-1] == Status.CONVERGED


@pytest.mark.parametrize("name", ["ekf", "ukf", "afekf"])
@pytest.mark.parametrize("frequency", [5.0, 10.0, 30.0])
def test_the_exact_step_has_no_bias(name, frequency):
    estimates = estimate(name, Experiment(frequency=frequency, force_noise=1e-6))
    assert estimates.stiffness[-1] == pytest.approx(450, rel=2e-4)
    assert estimates.damping[-1] == pytest.approx(5, rel=2e-4)


@pytest.mark.parametrize("frequency", [5.0, 10.0, 30.0])
def test_eulers_bias_is_as_derived(frequency):
    """Seen on the fading filter, which forgets the start: dk = w^2 (beta0 + beta) dt / 2."""
    experiment = Experiment(frequency=frequency, force_noise=1e-6)
    euler = estimate("afekf", experiment, EULER)
    w, dt = 2 * np.pi * frequency, experiment.sample_period
    assert euler.stiffness[-1] - 450 == pytest.approx(w**2 * (0.8 + 5) * dt / 2, rel=0.15, abs=0.3)
    assert euler.damping[-1] - 5 == pytest.approx(0.04 * w**2 * dt, rel=0.15, abs=0.003)


@pytest.mark.parametrize("period", [1e-4, 2e-3])
@pytest.mark.parametrize("name", ["ekf", "ukf"])
def test_the_exact_step_holds_at_other_sample_rates(name, period):
    experiment = Experiment(duration=1.0, sample_period=period, force_noise=1e-4)
    estimates = estimate(name, experiment)
    assert estimates.stiffness[-1] == pytest.approx(450, rel=1e-3)
    assert estimates.damping[-1] == pytest.approx(5, rel=1e-3)


def test_only_the_fading_filter_of_the_papers_three_follows_a_change():
    experiment = Experiment(tissue=((0.0, 450.0, 5.0), (1.0, 900.0, 10.0)), duration=2.0)
    last = {name: estimate(name, experiment).stiffness[-1] for name in ("ekf", "ukf", "afekf")}
    assert last["afekf"] == pytest.approx(900, rel=0.01)
    assert last["ekf"] < 800
    assert last["ukf"] < 800


def test_the_fading_filters_covariance_settles_and_the_others_falls():
    papers = EstimatorSettings(velocity_noise=1e-8).exact()
    experiment = Experiment(duration=4.0)
    ekf, afekf = (estimate(name, experiment, papers) for name in ("ekf", "afekf"))
    assert afekf.covariance_trace[-1] == pytest.approx(0.58, rel=0.1)
    assert ekf.covariance_trace[-1] < 0.03


@pytest.mark.parametrize("name", ["ekf", "afekf"])
def test_a_tip_in_the_air_is_reported_as_no_contact(name):
    estimates = estimate(name, Experiment(tissue=((0.0, 0.0, 0.0),), duration=0.5))
    assert estimates.status[-1] == Status.NO_CONTACT
    assert abs(estimates.stiffness[-1]) < 5


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_resting_coil_teaches_nothing_and_harms_nothing(name):
    estimates = estimate(name, Experiment(amplitude=0.0, duration=1.0))
    assert np.all(estimates.status == Status.CONVERGING)
    assert np.all(estimates.stiffness_variance <= 1.000001 * EXACT.stiffness_prior_sd**2)
    assert np.all(estimates.damping_variance <= 1.000001 * EXACT.damping_prior_sd**2)


def test_the_ukf_is_that_of_all_its_sigma_points():
    """F says where the points of the tip's motion go: exactly, for the step is linear in it."""
    experiment = Experiment(duration=0.3)
    unbounded = {"stiffness_minimum": -1e6, "stiffness_maximum": 1e6, "damping_minimum": -1e4}
    settings = EULER.model_copy(update=unbounded)
    estimates = estimate("ukf", experiment, settings)
    stiffness, damping = literal_ukf(*experiment.run(), experiment.sample_period, settings)
    assert estimates.stiffness[2:] == pytest.approx(stiffness[2:], rel=1e-6, abs=1e-4)
    assert estimates.damping[2:] == pytest.approx(damping[2:], rel=1e-6, abs=1e-4)


def literal_ukf(position, force, dt, s):
    """Eqs. 6 and 29-41 of the paper, with matrices and all nine sigma points."""
    k0, beta0, m = s.load_cell_stiffness, s.load_cell_damping, s.tip_mass
    X, H, R = np.zeros(4), np.array([-k0, 0.0, 0.0, 0.0]), force_variance(s)
    deviations = [s.tip_position_prior_sd, s.tip_velocity_prior_sd]
    P = np.diag(np.square([*deviations, s.stiffness_prior_sd, s.damping_prior_sd]))
    weights = np.r_[2 / 6, np.full(8, 1 / 12)]
    rates = np.diff(position)[np.r_[0, 0 : position.size - 2]] / dt
    found = []
    for t, u in enumerate(position):
        if t > 0:
            upper = np.linalg.cholesky(P[::-1, ::-1])[::-1, ::-1]
            x, v, k, b = (X[:, None] + np.sqrt(6) * np.c_[np.zeros(4), upper, -upper]).copy()
            load = k0 * (position[t - 1] - x) + beta0 * (rates[t - 1] - v)
            points = np.array([x + dt * v, v + dt * (load - k * x - b * v) / m, k, b])
            X = points @ weights
            P = (weights * (points - X[:, None])) @ (points - X[:, None]).T
            P += np.diag([0.0, s.velocity_noise, 0.0, 0.0])
        S = H @ P @ H + R
        K = P @ H / S
        X = X + K * (force[t] - k0 * (u - X[0]))
        L = np.eye(4) - np.outer(K, H)
        P = L @ P @ L.T + R * np.outer(K, K)
        found.append(X[2:])
    return np.transpose(found)
