"""Filters on a probe whose measured position is the tip's: a testing machine, a robot's arm."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tissue_probe.estimation import Estimator, EstimatorSettings
from tissue_probe.settings import SettingsError, build
from tissue_probe.signals import SampleBlock, Status

#: The code of each is compiled: these have sigma points, fading and an offset between them.
KALMAN = [
    *("robust_ekf", "ekf", "afukf"),
    *(pytest.param(name, marks=pytest.mark.battery) for name in ("ukf", "afekf")),
]
MASS, FORCE_NOISE, POSITION_NOISE = 0.04, 5e-3, 1e-6


def motion(seed, duration, rate, frequency):
    """Return time, and a sine of 1 mm over 2 mm of preload with its first two derivatives."""
    t = np.arange(round(duration * rate)) / rate
    w, phase = 2 * np.pi * frequency, np.random.default_rng(seed).uniform(0, 2 * np.pi)
    u = 2e-3 + 1e-3 * np.sin(w * t + phase)
    return t, u, 1e-3 * w * np.cos(w * t + phase), -1e-3 * w * w * np.sin(w * t + phase)


def wandering(seed, duration, rate, knots):
    """Return time, and a cubic spline through random places with its first two derivatives."""
    t = np.arange(round(duration * rate)) / rate
    places = np.linspace(0.0, duration, round(duration * knots))
    random = np.random.default_rng(seed)
    spline = CubicSpline(places, 2e-3 + 0.7e-3 * random.standard_normal(places.size))
    return t, spline(t), spline(t, 1), spline(t, 2)


def block_of(seed, t, u, force, position_noise=POSITION_NOISE, first=0):
    """Return noisy samples of a position and a force."""
    random = np.random.default_rng(seed + 1000)
    return SampleBlock(
        stamp=0,
        sequence=first,
        sample_period=t[1] - t[0],
        position=u + position_noise * random.standard_normal(t.size),
        force=force + FORCE_NOISE * random.standard_normal(t.size),
        command=np.full(t.size, np.nan),
    )


def settings(position_noise=POSITION_NOISE, **changes):
    return EstimatorSettings(
        rig="rigid_probe",
        tip_mass=MASS,
        force_noise=FORCE_NOISE,
        encoder_resolution=position_noise * np.sqrt(12.0),
        **changes,
    )


def tissue(seed):
    random = np.random.default_rng(seed)
    return random.uniform(300.0, 1000.0), random.uniform(2.0, 10.0), random


def runs(name, count, rate, duration, frequencies, position_noise=POSITION_NOISE):
    """Yield true and estimated (k, beta), and the claimed standard deviations."""
    for seed in range(count):
        k, beta, random = tissue(seed)
        frequency = random.choice(frequencies)
        t, u, v, a = motion(seed, duration, rate, frequency)
        block = block_of(seed, t, u, MASS * a + k * u + beta * v, position_noise)
        estimator = Estimator(name, settings(position_noise, drive_frequency=frequency))
        found = estimator.process(block)[-1:]
        values = np.array([found.stiffness[0], found.damping[0]])
        yield (
            np.array([k, beta]),
            values,
            np.sqrt([found.stiffness_variance[0], found.damping_variance[0]]),
        )


@pytest.mark.parametrize("name", [*KALMAN, "rls", "lock_in"])
@pytest.mark.parametrize(
    ("rate", "duration", "frequencies", "position_noise"),
    [(2000.0, 1.0, (2.0, 5.0, 10.0, 20.0, 40.0, 80.0), 1e-6), (100.0, 20.0, (0.5, 1.0, 2.0), 2e-6)],
)
def test_two_standard_deviations_hold_the_truth(name, rate, duration, frequencies, position_noise):
    """Of 30 runs more than five miss once in 600 times if 95 % hold.

    Filters that forget nothing claim no more than they need: the mean square of their errors over
    the claim is 1, give or take 0.26.
    """
    found = list(runs(name, 30, rate, duration, frequencies, position_noise))
    true, estimated, deviations = (np.array(each) for each in zip(*found, strict=True))
    scores = (estimated - true) / deviations
    assert (np.mean(np.abs(scores) < 2.0, axis=0) >= 0.83).all()
    assert np.max(np.abs(estimated[:, 0] / true[:, 0] - 1.0)) < 0.01
    if name in ("ekf", "ukf"):
        squares = np.mean(scores**2, axis=0)
        assert (squares > 0.4).all()
        assert (squares < 1.8).all()


@pytest.mark.parametrize("name", ["robust_ekf", "ekf", "afukf", "rls"])
def test_any_motion_will_do(name):
    for seed in range(3):
        k, beta, _ = tissue(seed)
        t, u, v, a = wandering(seed, 4.0, 2000.0, knots=20.0)
        block = block_of(seed, t, u, MASS * a + k * u + beta * v)
        found = Estimator(name, settings()).process(block)
        assert found.stiffness[-1] == pytest.approx(k, rel=0.01)
        assert found.damping[-1] == pytest.approx(beta, rel=0.05)


def test_noise_of_the_position_does_not_make_the_damping_small():
    """As it does by differences of the position, which are mostly noise."""
    k, beta, noise = 500.0, 3.0, 1e-5
    t, u, v, a = motion(1, 10.0, 2000.0, 5.0)
    block = block_of(1, t, u, MASS * a + k * u + beta * v, noise)
    differences = np.c_[block.position, np.gradient(block.position, t), np.ones(t.size)]
    assert np.linalg.lstsq(differences, block.force, rcond=None)[0][1] < 0.8 * beta
    found = Estimator("ekf", settings(noise)).process(block)
    error = found.damping[-1] - beta
    assert abs(error) < 3.0 * np.sqrt(found.damping_variance[-1])
    assert abs(error) < 0.01 * beta


def test_a_constant_force_is_estimated_besides():
    t, u, v, _ = motion(2, 2.0, 2000.0, 5.0)
    block = block_of(2, t, u, 500.0 * u + 3.0 * v + 0.05)
    found = Estimator("robust_ekf", settings().model_copy(update={"tip_mass": 0.0})).process(block)
    assert found.force_offset[-1] == pytest.approx(0.05, abs=2e-3)
    assert found.stiffness[-1] == pytest.approx(500.0, rel=5e-3)


@pytest.mark.parametrize("name", [*KALMAN, "rls", "lock_in"])
def test_how_the_stream_is_cut_changes_no_bit(name):
    t, u, v, a = motion(3, 0.3, 2000.0, 10.0)
    block = block_of(3, t, u, MASS * a + 500.0 * u + 3.0 * v)
    whole = Estimator(name, settings()).process(block)
    estimator = Estimator(name, settings())
    places = [0, 1, 7, 30, 31, 200, 599, 600]
    parts = [estimator.process(block[a:b]) for a, b in pairwise(places)]
    for field in ("stiffness", "damping", "stiffness_variance", "innovation", "predicted_force"):
        np.testing.assert_array_equal(
            np.concatenate([getattr(part, field) for part in parts]), getattr(whole, field)
        )


@pytest.mark.parametrize("name", KALMAN)
def test_missing_samples_cost_the_windows_that_they_lie_in(name):
    t, u, v, a = motion(4, 2.0, 2000.0, 10.0)
    block = block_of(4, t, u, MASS * a + 500.0 * u + 3.0 * v)
    block.force[1000:1003] = np.nan
    block.position[2000] = np.nan
    estimator = Estimator(name, settings())
    found = estimator.process(block)
    assert estimator.missing == 4
    assert np.isnan(found.innovation[[1000, 2000, 2005]]).all()
    assert np.isfinite(found.innovation[2100])
    assert found.stiffness[-1] == pytest.approx(500.0, rel=5e-3)


def test_a_wrong_model_of_the_tissue_is_rejected():
    t, u, v, a = motion(5, 6.0, 2000.0, 5.0)
    force = MASS * a + 9000.0 * u**1.5 + 3.0 * v
    found = Estimator("ekf", settings()).process(block_of(5, t, u, force))
    assert found.status[-1] == Status.MODEL_REJECTED


def test_what_cannot_be_is_refused_in_one_sentence():
    with pytest.raises(SettingsError, match="tip_mass is 0 kg; only the tip of rig rigid_probe"):
        build(EstimatorSettings, {"tip_mass": 0.0})
    with pytest.raises(SettingsError, match="rig is 'force_driven': give one of"):
        build(EstimatorSettings, {"rig": "force_driven"})
    with pytest.raises(SettingsError, match="model files of compliant_probe only"):
        Estimator("ekf", EstimatorSettings(rig="rigid_probe", model="model.yaml"))
