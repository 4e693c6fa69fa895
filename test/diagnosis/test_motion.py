"""The motion in a noisy position, and intervals that hold the truth in spite of its noise.

All motions are closed forms of this file, and so are the forces.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binomtest

from tissue_probe.diagnosis.cleaning import clean_measurements
from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.motion import MotionInformation, motion
from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.rigs import RIGID_PROBE

RATE = 100.0
TRUE = {"stiffness": 400.0, "damping": 5.0, "tip_mass": 0.1}
FREE = Instrument(RIGID_PROBE)


def smooth_ramp(time, begins, lasts):
    """Return a ramp from 0 to 1 whose acceleration is continuous, and its two derivatives."""
    s = np.clip((time - begins) / lasts, 0.0, 1.0)
    inside = (s > 0.0) & (s < 1.0)
    course = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    speed = 30.0 * s**2 * (1.0 - s) ** 2 / lasts
    acceleration = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / lasts**2
    return course, speed * inside, acceleration * inside


def ramp_and_hold(time, random):
    begins, lasts = random.uniform(0.4, 0.8), random.uniform(0.3, 0.6)
    return [3e-3 * each for each in smooth_ramp(time, begins, lasts)]


def sine(time, random):
    rate = 2.0 * np.pi * random.uniform(1.0, 3.0)
    phase = rate * time + random.uniform(0.0, 6.0)
    waves = np.sin(phase), rate * np.cos(phase), -(rate**2) * np.sin(phase)
    return [1e-3 * each for each in waves]


def several_sines(time, random):
    total = np.zeros((3, time.size))
    for _ in range(5):
        total += np.array(sine(time, random)) * random.uniform(0.3, 1.0)
    return list(total)


MOTIONS = (ramp_and_hold, sine, several_sines)


def probed(moved, seed, position_noise, force_noise, samples=1200):
    """Return a measurement of a mass on Kelvin-Voigt tissue, moved by a robot's encoder."""
    random = np.random.default_rng(seed)
    time = np.arange(samples) / RATE
    u, v, a = moved(time, random)
    k, b, m = TRUE.values()
    force = k * u + b * v + m * a + force_noise * random.standard_normal(samples)
    position = u + position_noise * random.standard_normal(samples)
    return Measurement(position, force, 1.0 / RATE, moved is ramp_and_hold)


@pytest.mark.parametrize("moved", MOTIONS)
@pytest.mark.parametrize("noise", [2e-6, 1e-5])
def test_the_acceleration_of_the_motion_has_far_less_noise_than_that_of_the_samples(moved, noise):
    random = np.random.default_rng(1)
    u = moved(np.arange(1200) / RATE, random)[0]
    samples = u + noise * random.standard_normal(u.size)
    left = [np.std(np.diff(each - u, 2)) for each in (motion(samples, noise).position, samples)]
    assert left[0] < 0.5 * left[1]


@pytest.mark.parametrize("moved", MOTIONS)
def test_drawn_errors_are_as_large_as_those_of_the_motion(moved):
    noise, random = 3e-6, np.random.default_rng(2)
    u = moved(np.arange(1200) / RATE, random)[0]
    told = motion(u + noise * random.standard_normal(u.size), noise)
    drawn = np.mean([np.std(told.error(random)) for _ in range(5)])
    assert np.std(told.position - u) == pytest.approx(drawn, rel=0.4)


@settings(max_examples=25, deadline=None)
@given(st.integers(4, 400), st.integers(0, 10**6), st.floats(-12.0, 6.0))
def test_the_motion_keeps_parabolas_and_scales_with_its_unit(size, seed, power):
    random, unit = np.random.default_rng(seed), 10.0**power
    at = np.linspace(-1.0, 1.0, size)
    samples = random.standard_normal(size) * 0.01 + np.sin(3.0 * at)
    found = motion(samples, 0.01).position
    scaled = motion(unit * samples, unit * 0.01).position / unit
    np.testing.assert_allclose(scaled, found, atol=1e-5)
    parabola = 1.0 + at + at**2
    np.testing.assert_allclose(motion(parabola, 0.01).position, parabola, atol=1e-5)


@pytest.mark.parametrize("moved", MOTIONS)
def test_intervals_hold_mass_stiffness_and_damping_in_spite_of_a_noisy_position(moved):
    inside, right, count = 0, 0, 15
    for seed in range(count):
        noises = [(1e-6, 0.01), (1e-5, 0.02), (3e-7, 0.003)][seed % 3]
        (clean,), _ = clean_measurements([probed(moved, seed, *noises)])
        fit = fit_base(Composition("rigid_probe"), [clean], FREE)
        found, deviations = fit.named(), fit.deviations()
        inside += sum(abs(found[n] - true) <= 1.96 * deviations[n] for n, true in TRUE.items())
        right += leaves_only_noise(fit)
    assert binomtest(inside, 3 * count, 0.95).pvalue > 1e-3
    assert right >= count - 1


def told_by(force, moved, seed, noise=1e-5):
    """Return a noisy position, and what a force of damped tissue beside it shows of its motion."""
    random, time = np.random.default_rng(seed), np.arange(800) / RATE
    u, _, _ = moved(time, random)
    read = u + noise * random.standard_normal(time.size)
    taps = np.pad([25.0 * RATE, 400.0, -25.0 * RATE], 3)
    felt = np.convolve(u, taps, mode="same") + 1e-3 * random.standard_normal(time.size)
    return read, MotionInformation(
        felt + force(time) - np.convolve(read, taps, mode="same"), read, taps, 1e-3
    )


@pytest.mark.parametrize("moved", MOTIONS)
def test_a_force_that_a_wrong_model_takes_for_motion_tells_nothing_of_it(moved):
    read, felt = told_by(lambda time: 1.0 + 0.5 * np.sin(time), moved, 0)
    alone = motion(read, 1e-5).position
    np.testing.assert_allclose(motion(read, 1e-5, felt).position, alone, atol=1e-6)


@pytest.mark.parametrize("moved", MOTIONS)
def test_a_force_shows_where_a_motion_starts_that_hides_in_the_noise_of_the_position(moved):
    read, felt = told_by(np.zeros_like, moved, 0)
    u = moved(np.arange(800) / RATE, np.random.default_rng(0))[0]
    left, alone = (
        np.std((found.position - u)[20:-20])
        for found in (motion(read, 1e-5, felt), motion(read, 1e-5))
    )
    assert left < alone


def test_what_the_force_feels_of_a_rough_position_is_motion_and_stays():
    random = np.random.default_rng(3)
    deepest = np.repeat(random.uniform(0.7, 1.0, 40), 10)
    depths = 3e-3 * np.tile(np.linspace(0.0, 1.0, 10), 40) * deepest  # a new depth at each sample
    force = 500.0 * depths + 0.01 * random.standard_normal(depths.size)
    (clean,), _ = clean_measurements([Measurement(depths, force, 0.1)])
    np.testing.assert_array_equal(clean.position, depths)


@pytest.mark.parametrize("digits", [9, 12])
def test_a_sine_of_a_whole_number_of_samples_has_no_noise(digits):
    """Its few values come again in each period: the least difference of two is no step."""
    time = np.arange(2000) / 2000.0
    position = 1e-3 * np.sin(20.0 * np.pi * time)
    force = 450.0 * position + 0.3 * np.exp(-time / 3e-3) * np.sin(450.0 * time)  # a tip rings
    read = np.round(position, digits), np.round(force, 9)
    assert Measurement(*read, 1.0 / 2000.0).position_noise == 0.0
