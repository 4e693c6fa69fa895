"""Tests of residuals: a right model passes, and what an effect leaves is told by its kind."""

import numpy as np
import pytest
from specimen import Specimen, chirp, kelvin_voigt_residual, multisine, sine

from tissue_probe.diagnosis.residuals.all_tests import residual_tests
from tissue_probe.diagnosis.residuals.drive import drive_of
from tissue_probe.diagnosis.residuals.noise_floor import noise_floor

PERIOD, NOISE = 5e-4, 5e-3
TIME = PERIOD * np.arange(8000)


def swelling(time):
    """Return a sine whose amplitude goes up and down between 0.2 and 1.8 mm."""
    return sine(12.3)(time) * (1.0 + 0.8 * np.sin(2 * np.pi * 0.7 * time))


def judge(residual, position):
    return {test.name: test for test in residual_tests(residual, position, PERIOD, NOISE)}


def judge_fit(specimen, motion, duration=4.0):
    position, _, _, residual = kelvin_voigt_residual(specimen, motion, duration)
    return judge(residual, position)


def white(size=TIME.size, seed=0):
    return NOISE * np.random.default_rng(seed).standard_normal(size)


def failed(tests):
    return {name for name, test in tests.items() if not test.passed}


DRIVES = {
    "sine": sine(),
    "multisine": multisine(),
    "odd multisine": multisine(range(1, 60, 2)),
    "chirp": chirp(),
    "swelling": swelling,
}


@pytest.mark.parametrize("drive", DRIVES)
def test_white_noise_passes_whatever_the_drive(drive):
    position = DRIVES[drive](TIME)
    failures = [failed(judge(white(seed=seed), position)) for seed in range(15)]
    # 165 tests at a level of 1e-3: two or more would be a one in a hundred chance.
    assert sum(map(len, failures)) <= 1, failures


@pytest.mark.parametrize("drive", ["sine", "multisine", "chirp"])
def test_a_right_model_passes_with_the_noise_as_estimated(drive):
    position, _, _, residual = kelvin_voigt_residual(Specimen(), DRIVES[drive], 4.0)
    _, _, _, measured = Specimen().measure(DRIVES[drive], 4.0)
    assert not [
        t for t in residual_tests(residual, position, PERIOD, noise_floor(measured)) if not t.passed
    ]


def test_a_failed_test_hints_and_a_passed_one_does_not():
    for test in judge(white() + 0.02 * sine(30.0, 1.0)(TIME), sine()(TIME)).values():
        assert bool(test.hint) != test.passed
        assert test.finding


def test_stiffening_leaves_odd_harmonics():
    tests = judge_fit(Specimen(cubic=1e8), sine(), 2.0)
    assert {"level", "whiteness", "Ljung-Box", "harmonics"} <= failed(tests)
    assert "30 Hz, 3 times the 10 Hz" in tests["harmonics"].finding
    assert "odd" in tests["harmonics"].hint
    assert "cubic_stiffening" in tests["harmonics"].hint


def test_lost_contact_leaves_even_harmonics_and_an_offset():
    tests = judge_fit(Specimen(contact_loss=True), sine(), 2.0)
    assert {"offset", "harmonics"} <= failed(tests)
    assert "even" in tests["harmonics"].hint
    for name in ("offset", "harmonics"):
        assert "contact_loss" in tests[name].hint


@pytest.mark.parametrize(
    ("specimen", "power", "hint"),
    [
        (Specimen(cubic=1e8), 3.0, "stiffening"),
        (Specimen(coulomb=0.1), 0.0, "friction"),
        (Specimen(contact_loss=True), 1.0, "contact_loss"),
    ],
    ids=["cubic", "friction", "contact"],
)
def test_the_power_of_the_amplitude_tells_the_family(specimen, power, hint):
    test = judge_fit(specimen, swelling)["amplitude"]
    assert test.statistic == pytest.approx(power, abs=0.35)
    assert hint in test.hint


def test_one_amplitude_tells_no_power_and_says_so():
    test = judge_fit(Specimen(cubic=1e8), chirp())["amplitude"]
    assert np.isnan(test.statistic)
    assert test.passed
    assert "one amplitude" in test.finding


@pytest.mark.parametrize("mains", [50.0, 60.0])
@pytest.mark.parametrize("drive", ["chirp", "sine"])
def test_hum_is_found_and_told_from_a_harmonic_where_it_can_be(mains, drive):
    position = DRIVES[drive](TIME)
    tests = judge(white() + sine(mains, 2e-3)(TIME), position)
    assert f"{mains:g} Hz" in failed(tests)
    assert "harmonics" not in failed(tests)
    assert tests[f"{mains:g} Hz"].statistic == pytest.approx(2e-3, rel=0.15)
    assert ("harmonic of the drive" in tests[f"{mains:g} Hz"].hint) == (drive == "sine")


def test_hum_on_a_driven_frequency_cannot_be_told():
    test = judge(white() + sine(50.0, 2e-3)(TIME), multisine()(TIME))["50 Hz"]
    assert test.finding.startswith("cannot be told")


@pytest.mark.parametrize(
    ("frequency", "hint"), [(0.3, "breathing"), (1.3, "breathing"), (133.3, "vibration")]
)
def test_lines_that_are_not_the_drives_are_told_by_their_frequency(frequency, hint):
    tests = judge(white() + sine(frequency, 2e-3)(TIME), sine()(TIME))
    assert "other lines" in failed(tests)
    assert hint in tests["other lines"].hint


def test_what_follows_the_motion_late_correlates_with_it():
    position = chirp()(TIME)
    late = np.r_[np.zeros(20), position[:-20]] * 3.0
    test = judge(white() + late, position)["position"]
    assert not test.passed
    assert "+10 ms after" in test.finding
    assert "channel_delay" in test.hint


def test_a_harmonic_does_not_correlate_with_the_motion():
    tests = judge(white() + sine(30.0, 0.1)(TIME), sine()(TIME))
    assert tests["position"].passed
    assert tests["speed"].passed


def test_single_spikes_are_counted():
    spikes = np.zeros(TIME.size)
    spikes[[500, 1700, 4000, 7990]] = 0.1
    tests = judge(white() + spikes, sine()(TIME))
    assert tests["outliers"].statistic == 4
    assert "outliers" in failed(tests)


def test_a_transient_is_no_outlier():
    ringing = 0.2 * np.exp(-TIME / 0.02) * np.sin(2 * np.pi * 78.0 * TIME)
    assert judge(white() + ringing, sine()(TIME))["outliers"].passed


def test_a_constant_is_an_offset():
    tests = judge(white() + 1e-3, sine()(TIME))
    assert tests["offset"].statistic == pytest.approx(1e-3, rel=0.2)
    assert "force_bias" in tests["offset"].hint


@pytest.mark.parametrize(
    ("motion", "repetition"),
    [(sine(9.7), 9.7), (sine(29.77), 29.77), (multisine(range(1, 60, 2)), 1.0), (chirp(), None)],
)
def test_the_repetition_of_the_drive_is_read_from_the_position(motion, repetition):
    found = drive_of(motion(TIME), PERIOD).repetition
    assert found == (repetition and pytest.approx(repetition, rel=1e-4))


@pytest.mark.parametrize(
    ("residual", "position", "noise", "message"),
    [
        (np.zeros(63), np.zeros(63), 1.0, "at least 64 samples"),
        (np.zeros(300), np.zeros(301), 1.0, "one length"),
        (np.full(300, np.nan), np.zeros(300), 1.0, "finite"),
        (np.zeros(300), np.zeros(300), 0.0, "positive"),
    ],
)
def test_what_cannot_be_tested_is_refused(residual, position, noise, message):
    with pytest.raises(ValueError, match=message):
        residual_tests(residual, position, PERIOD, noise)


def test_a_still_and_silent_record_is_judged_without_complaint():
    assert not failed(judge(np.zeros(400), np.zeros(400)))
