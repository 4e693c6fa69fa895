"""Where a model fails: regions put into noise are found again, and noise alone has none."""

import numpy as np
import pytest
from specimen import Specimen, chirp, kelvin_voigt_residual, sine

from tissue_probe.diagnosis.residuals.localise import localise

PERIOD, NOISE = 5e-4, 5e-3
TIME = PERIOD * np.arange(4000)
POSITION = sine(9.7)(TIME)
SPEED = np.gradient(POSITION, PERIOD)
PHASE = (360.0 * 9.7 * TIME - 90.0 + 180.0) % 360.0 - 180.0  # 0 where deepest


def white(seed=0):
    return NOISE * np.random.default_rng(seed).standard_normal(TIME.size)


def find(residual):
    result = localise(residual, POSITION, POSITION, PERIOD, NOISE)
    return {profile.quantity: profile for profile in result.profiles}, result.here


def louder_where(mask, factor=4.0):
    return white() * np.where(mask, factor, 1.0)


@pytest.mark.parametrize("seed", range(20))
def test_noise_has_no_region(seed):
    profiles, here = find(white(seed))
    assert here is None
    assert not any(profile.here for profile in profiles.values())
    assert profiles["time"].describe() == "time: nothing stands out"


@pytest.mark.parametrize(
    ("quantity", "mask", "begin", "end", "width"),
    [
        ("time", (TIME > 0.7) & (TIME < 1.0), 0.7, 1.0, 2.0 / 36),
        ("indentation", POSITION > 0.8e-3, 0.8, 1.0, 2.0 / 36),
        ("speed", np.abs(SPEED) < 10e-3, -10.0, 10.0, 122.0 / 36),
        ("phase", np.abs(PHASE + 90.0) < 30.0, -120.0, -60.0, 10.0),
        ("phase", np.abs(PHASE) > 150.0, 150.0, -150.0, 10.0),
    ],
    ids=["time", "indentation", "speed", "phase", "phase through 180 degrees"],
)
def test_a_louder_region_is_found_and_stands_out_most(quantity, mask, begin, end, width):
    profiles, _ = find(louder_where(mask))
    region = profiles[quantity].here
    assert region.begin == pytest.approx(begin, abs=width)
    assert region.end == pytest.approx(end, abs=width)
    assert region.excess == pytest.approx(16.0, rel=0.25)
    assert region.share == pytest.approx(1.0, abs=0.1)


def test_the_foremost_region_is_that_of_largest_contrast():
    profiles, here = find(louder_where((TIME > 0.7) & (TIME < 1.0)))
    assert here is profiles["time"]
    assert "time 0.667 to 1 s: " in here.describe()


def test_a_direction_is_named():
    profiles, here = find(louder_where(SPEED > 0.0))
    assert profiles["direction"].labels == ("out", "in")
    assert (profiles["direction"].here.begin, profiles["direction"].here.end) == (0.0, 1.0)
    assert profiles["direction"].describe().startswith("direction in: ")
    assert here is not None


def test_a_line_is_found_in_its_band():
    profiles, here = find(white() + sine(130.0, 0.02)(TIME))
    region = profiles["frequency"].here
    assert region.begin < 130.0 < region.end
    assert region.end < 2.0 * region.begin
    assert here is profiles["frequency"]


def test_energies_add_up_to_the_residuals():
    residual = louder_where(POSITION > 0.5e-3)
    profiles, _ = find(residual)
    for name, profile in profiles.items():
        # Welch's windows weigh the samples, and leave out the mean.
        tolerance = 0.05 if name == "frequency" else 1e-9
        assert profile.energy.sum() == pytest.approx(np.sum(residual**2), rel=tolerance)
        assert profile.expected.sum() == pytest.approx(TIME.size * NOISE**2, rel=1e-9)
        assert np.nanmin(profile.excess) >= 0.0


def test_friction_fails_where_the_tip_turns():
    position, tip, _, residual = kelvin_voigt_residual(Specimen(coulomb=0.1), sine())
    result = localise(residual, position, tip, PERIOD, NOISE)
    assert result.here.quantity == "speed"
    assert result.here.here.begin < 0.0 < result.here.here.end
    assert result.here.here.share > 0.6


def test_lost_contact_in_a_sweep_fails_late():
    specimen = Specimen(contact_loss=True, preload=9e-4)
    position, tip, _, residual = kelvin_voigt_residual(specimen, chirp(), 4.0)
    result = localise(residual, position, tip, PERIOD, NOISE)
    assert result.profiles[0].here.begin > 1.0


def test_a_record_that_cannot_be_judged_is_refused():
    with pytest.raises(ValueError, match="at least 64 samples"):
        localise(np.zeros(63), np.zeros(63), np.zeros(63), PERIOD, NOISE)


def test_samples_once_a_second_are_localised():
    residual = NOISE * np.random.default_rng(4).standard_normal(3000)
    position = 1e-3 * np.sin(0.1 * np.arange(3000))
    assert localise(residual, position, position, 1.0, NOISE).here is None
