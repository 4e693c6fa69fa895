"""The noise floor, on forces whose noise is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from specimen import Specimen, chirp, multisine, sine

from tissue_probe.diagnosis.residuals.noise_floor import noise_floor

SEEDS = range(20)
SOFT = Specimen()
LIFTING = Specimen(contact_loss=True)
STICKING = Specimen(coulomb=0.3)


def relative_errors(force, step=0.0, noise=5e-3):
    """Return the errors over several draws of noise, relative to noise and quantisation."""
    truth = np.hypot(noise, step / np.sqrt(12))
    found = []
    for seed in SEEDS:
        measured = force + noise * np.random.default_rng(seed).standard_normal(force.size)
        found.append(noise_floor(np.round(measured / step) * step if step else measured))
    return np.array(found) / truth - 1.0


@pytest.mark.parametrize("step", [0.0, 10.0 / 2**12], ids=["smooth", "12 bits"])
@pytest.mark.parametrize(
    ("specimen", "motion", "duration"),
    [
        (SOFT, sine(), 2.0),
        (SOFT, multisine(), 4.0),
        (SOFT, chirp(), 4.0),
        (STICKING, sine(), 2.0),
        (LIFTING, sine(), 2.0),
        (LIFTING, multisine(amplitude=5e-4), 4.0),
    ],
    ids=["sine", "multisine", "chirp", "friction", "contact lost", "contact lost, multisine"],
)
def test_five_millinewtons_are_found_to_three_per_cent(specimen, motion, duration, step):
    _, _, force, _ = specimen.measure(motion, duration)
    errors = relative_errors(force, step)
    assert abs(np.mean(errors)) < 0.015
    assert np.sqrt(np.mean(errors**2)) < 0.03


@pytest.mark.parametrize("share", [0.01, 0.1, 0.4])
def test_samples_that_are_left_out_change_nothing(share):
    _, _, force, _ = SOFT.measure(chirp(), 4.0)
    measured = force + 5e-3 * np.random.default_rng(4).standard_normal(force.size)
    kept = np.flatnonzero(np.random.default_rng(5).random(force.size) >= share)
    assert noise_floor(measured[kept], numbers=kept) == pytest.approx(5e-3, rel=0.05)


def test_outliers_and_impacts_are_passed_over():
    _, _, force, _ = SOFT.measure(sine())
    force[np.random.default_rng(1).integers(0, force.size, 40)] += 1.0
    assert abs(np.mean(relative_errors(force))) < 0.08


def test_slow_noise_is_not_counted():
    slow = 0.05 * np.sin(2 * np.pi * 0.7 * np.arange(4000) / 2000)
    assert abs(np.mean(relative_errors(slow))) < 0.015


def test_a_force_in_coarse_steps_has_the_noise_of_its_steps():
    ramp = np.linspace(0.0, 1.0, 20000)
    assert noise_floor(np.round(ramp / 0.05) * 0.05) == pytest.approx(0.05 / np.sqrt(12))


@given(st.floats(1e-6, 1e3), st.floats(-1e3, 1e3))
def test_it_scales_with_the_force_and_ignores_an_offset(scale, offset):
    noise = np.random.default_rng(0).standard_normal(500)
    expected = scale * noise_floor(noise)
    assert noise_floor(scale * (noise + offset)) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("force", [np.zeros(11), np.r_[np.zeros(100), np.nan]])
def test_what_cannot_be_judged_is_refused(force):
    with pytest.raises(ValueError, match="at least 12, all finite"):
        noise_floor(force)
