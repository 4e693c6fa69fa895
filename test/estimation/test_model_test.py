"""The test of the model that all filters share: what it rejects, what it must not, how long."""

import math

import numpy as np
import pytest
from measured import START

from benchmarks.estimators_simulator import Experiment, HardeningTissue, simulate_ramp
from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.excitation import Chirp, Multisine, Sine, SteppedSweep
from tissue_probe.signals import SampleBlock, Status, TissueEstimates

PERIOD, NOISE = 5e-4, 5e-3
MASS, CELL_STIFFNESS, CELL_DAMPING = 0.04, 9700.0, 0.8
KALMAN = ["robust_ekf", "ekf", "ukf", "afekf"]
UNSURE_OF_OFFSETS = ["ekf", "ukf", "afekf", "rls"]
KNOWN = (Status.CONVERGED, Status.DISTURBED)


def kelvin_voigt(x, v):
    return 450.0 * x + 5.0 * v


def touched(x, v):
    """Tissue that is left in each cycle: it pushes, and never pulls."""
    return max(450.0 * x + 5.0 * v, 0.0) if x > 0.0 else 0.0


def hertz(x, v):
    """A sphere that touches at 0.2 mm."""
    depth = max(x - 2e-4, 0.0)
    return 28e3 * depth**1.5 + 5.0 * (depth / 1.8e-3) ** 0.5 * v


def stiffening(x, v):
    return 450.0 * x * (1.0 + 0.2 * (x / 1e-3) ** 2) + 5.0 * v


def exponential(x, v):
    return 0.6 * math.expm1(x / 2e-3) + 5.0 * v


def simulated(law, excitation, duration=1.0, mean=0.0, seed=0, extra=None, before=0.3):
    """Position and force of a probe that has moved for a while (Runge and Kutta, in Python)."""
    count, parts = round((duration + before) / PERIOD), 4
    fine = np.arange(2 * parts * count + 1) * PERIOD / (2 * parts)
    coil = mean + 1e-3 * excitation(fine)
    coil, speed = coil.tolist(), np.gradient(coil, fine).tolist()
    h = PERIOD / parts

    def rate(i, x, v):
        cell = CELL_STIFFNESS * (coil[i] - x) + CELL_DAMPING * (speed[i] - v)
        return (cell - law(x, v)) / MASS

    x, v, tip = coil[0], 0.0, []
    for i in range(0, 2 * parts * count, 2):
        if i % (2 * parts) == 0:
            tip.append(x)
        a1 = rate(i, x, v)
        v2 = v + h / 2 * a1
        a2 = rate(i + 1, x + h / 2 * v, v2)
        v3 = v + h / 2 * a2
        a3 = rate(i + 1, x + h / 2 * v2, v3)
        v4 = v + h * a3
        a4 = rate(i + 2, x + h * v3, v4)
        x, v = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    times, position = fine[: -1 : 2 * parts], np.array(coil[: -1 : 2 * parts])
    force = CELL_STIFFNESS * (position - np.array(tip))
    force += NOISE * np.random.default_rng(seed).standard_normal(count)
    if extra is not None:
        force += extra(times)
    late = round(before / PERIOD)
    return position[late:], force[late:]


def block_of(position, force, first=0):
    unknown = np.full(position.size, np.nan)
    return SampleBlock(START, first, PERIOD, position, force, unknown)


def estimate(name, position, force, **settings):
    return Estimator(name, EstimatorSettings(**settings).exact()).process(block_of(position, force))


EXCITATIONS = {
    "1 Hz": Sine(frequency=1.0),
    "10 Hz": Sine(frequency=10.0),
    "30 Hz": Sine(frequency=30.0),
    "chirp": Chirp(duration=1.0),
    "stepped sweep": SteppedSweep(duration=1.0),
    "multisine": Multisine(),
}


@pytest.fixture(scope="module")
def right():
    return {name: simulated(kelvin_voigt, each) for name, each in EXCITATIONS.items()}


@pytest.mark.parametrize("excitation", EXCITATIONS)
@pytest.mark.parametrize("name", ESTIMATORS)
def test_the_right_model_is_not_rejected(name, excitation, right):
    if name == "lock_in" and "Hz" not in excitation:
        pytest.skip("it is for one sine")
    frequency = EXCITATIONS[excitation].highest_frequency
    estimates = estimate(name, *right[excitation], drive_frequency=frequency)
    assert not np.any(estimates.status == Status.MODEL_REJECTED)
    assert estimates.stiffness[-1] == pytest.approx(450, rel=0.02)


WRONG = {
    "contact lost in each cycle": (touched, 0.0),
    "contact lost for a part of each cycle": (touched, 8e-4),
    "hertz": (hertz, 2e-3),
    "cubic": (stiffening, 0.0),
    "exponential": (exponential, 1e-3),
}


@pytest.fixture(scope="module")
def wrong():
    tens = Sine(frequency=10.0)
    return {name: simulated(law, tens, mean=mean) for name, (law, mean) in WRONG.items()}


@pytest.mark.parametrize("what", WRONG)
@pytest.mark.parametrize("name", KALMAN)
def test_every_filter_rejects_a_wrong_model_within_a_dwell_and_stays_with_it(name, what, wrong):
    rejected = estimate(name, *wrong[what]).status == Status.MODEL_REJECTED
    first = int(np.argmax(rejected))
    assert 0 < first < 1200
    assert np.all(rejected[first:])


@pytest.mark.parametrize("name", ["lock_in", "rls"])
@pytest.mark.parametrize("what", ["hertz", "contact lost in each cycle"])
def test_estimators_without_a_kalman_filter_reject_it_too(name, what, wrong):
    assert estimate(name, *wrong[what]).status[-1] == Status.MODEL_REJECTED


@pytest.mark.parametrize("name", UNSURE_OF_OFFSETS)
def test_tissue_that_does_not_begin_at_zero_is_rejected_where_no_offset_is_estimated(name):
    position, force = Experiment(contact_zero=3e-4).run()
    assert estimate(name, position, force).status[-1] == Status.MODEL_REJECTED
    assert estimate("robust_ekf", position, force).status[-1] == Status.CONVERGED


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_drive_that_pauses_and_goes_on_rejects_nothing(name):
    tens = Sine(frequency=10.0)
    # It stands still from the end of a period to that of another.
    paused = simulated(
        kelvin_voigt, lambda t: tens(np.where(t < 0.7, t, np.maximum(0.7, t - 0.4))), duration=1.5
    )
    estimates = estimate(name, *paused)
    assert not np.any(estimates.status == Status.MODEL_REJECTED)
    assert estimates.stiffness[-1] == pytest.approx(450, rel=0.02)


@pytest.mark.parametrize("mains", [50.0, 60.0])
@pytest.mark.parametrize("name", [*KALMAN, "lock_in", "rls"])
def test_hum_disturbs_and_rejects_nothing(name, mains):
    hum = simulated(
        kelvin_voigt,
        Sine(frequency=10.0),
        extra=lambda times: 0.03 * np.sin(2 * np.pi * (mains + 0.03) * times + 0.4),
    )
    estimates = estimate(name, *hum)
    assert estimates.status[-1] == Status.DISTURBED
    assert not np.any(estimates.status == Status.MODEL_REJECTED)
    assert estimates.stiffness[-1] == pytest.approx(450, rel=0.02)


@pytest.mark.parametrize("name", KALMAN)
def test_more_noise_than_was_set_disturbs_and_rejects_nothing(name, right):
    estimates = estimate(name, *right["10 Hz"], force_noise=1e-3)
    assert estimates.status[-1] == Status.DISTURBED
    assert not np.any(estimates.status == Status.MODEL_REJECTED)
    assert estimates.stiffness[-1] == pytest.approx(450, rel=0.02)


@pytest.mark.parametrize("after", [(900.0, 10.0), (225.0, 2.5), (0.0, 0.0)])
def test_a_change_that_the_filter_follows_rejects_nothing(after):
    for seed in range(3):
        tissue = ((0.0, 450.0, 5.0), (0.5 + 0.03 * seed, *after))
        estimates = estimate("robust_ekf", *Experiment(tissue=tissue, seed=seed).run())
        assert not np.any(estimates.status == Status.MODEL_REJECTED)
        assert estimates.status[-1] in (*KNOWN, Status.NO_CONTACT)


@pytest.mark.parametrize("length", [0.03, 0.1, 0.4])
def test_a_ramp_that_the_filter_follows_rejects_nothing(length):
    ramp = simulate_ramp((450.0, 5.0), (900.0, 10.0), start=0.4, length=length, duration=1.2)
    estimates = estimate("robust_ekf", *ramp.run())
    assert not np.any(estimates.status == Status.MODEL_REJECTED)
    assert estimates.stiffness[-1] == pytest.approx(900, rel=0.02)


def test_a_harmonic_that_does_not_matter_is_tolerated_however_little_noise_there_is():
    """It shifts the stiffness by 0.4 %: a law that is hardly curved, an excellent load cell."""
    tissue = HardeningTissue(hardening=0.005, force_noise=1e-4, encoder_resolution=0.0)
    position, force = tissue.run()
    estimates = estimate("ekf", position, force, force_noise=1e-4, encoder_resolution=0.0)
    assert not np.any(estimates.status == Status.MODEL_REJECTED)


@pytest.mark.parametrize("name", ["robust_ekf", "lock_in"])
def test_the_status_does_not_depend_on_how_the_stream_is_cut(name, wrong):
    block = block_of(*wrong["hertz"])
    whole = Estimator(name, EstimatorSettings()).process(block)
    cut = Estimator(name, EstimatorSettings())
    parts = [cut.process(block[i : i + 7]) for i in range(0, len(block), 7)]
    np.testing.assert_array_equal(whole.status, TissueEstimates.concatenate(parts).status)


@pytest.mark.parametrize("name", KALMAN)
def test_a_rejection_ends_where_the_filter_restarts(name, wrong, right):
    estimator = Estimator(name, EstimatorSettings())
    assert estimator.process(block_of(*wrong["hertz"])).status[-1] == Status.MODEL_REJECTED
    estimator.restart()
    after = estimator.process(block_of(*right["10 Hz"], first=2000))
    assert after.status[-1] == Status.CONVERGED
