"""Noise of a position that drives, in the output of the model: white again, and no false alarm.

Covariances are dense matrices of this file; motions and forces are its closed forms.
"""

import numpy as np
import pytest
from hidden import first_of
from hypothesis import given, settings
from hypothesis import strategies as st
from specimen import Specimen, multisine

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.observation.chained_noise import NEAR, Chained
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.motion import MotionEstimate
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS

MASSLESS = {"tip_mass": (0.0, 0.0), "contact_position": (0.0, 0.0)}


def covariance_of(calmness, noise):
    """Return that of a motion whose third differences are as strong as its noise allows."""
    differences = np.diff(np.eye(calmness.size + 3), 3, axis=0)
    precision = np.eye(calmness.size + 3) + differences.T @ (calmness[:, None] * differences)
    return noise**2 * np.linalg.inv(precision)


@settings(max_examples=30, deadline=None)
@given(
    st.integers(30, 60),
    st.floats(-2.0, 6.0),
    st.integers(0, 2**31),
    st.booleans(),
    st.sampled_from([(), (0.8,), (1.5, -0.7)]),
)
def test_what_is_new_in_each_sample_is_white_and_of_variance_1(samples, level, seed, gaps, memory):
    random = np.random.default_rng(seed)
    calmness = np.exp(random.normal(level, 1.0, samples - 3))
    errors = covariance_of(calmness, 0.7)
    taps = random.normal(size=2 * NEAR + 1)
    felt = sum(
        tap * np.eye(samples, k=NEAR - place) for place, tap in enumerate(taps)
    )  # the latest neighbour first
    felt_now = felt @ errors @ felt.T + 0.1**2 * np.eye(samples)
    rings = np.eye(samples) - sum(m * np.eye(samples, k=-1 - lag) for lag, m in enumerate(memory))
    rung = np.linalg.inv(rings)
    every = rung @ felt_now @ rung.T + 0.3**2 * np.eye(samples)
    used = random.uniform(size=samples) > (0.2 if gaps else 0.0)
    chain = MotionEstimate(np.zeros(samples), 0.7, calmness).chain()
    white = Chained(0.3, chain, taps, 0.1, np.array(memory)).white(np.eye(samples), used)
    used[:NEAR] = used[-NEAR:] = False
    whitened = white @ every @ white.T
    np.testing.assert_allclose(whitened, np.diag(used.astype(float)), atol=1e-8)
    assert not white[:, ~used].any()


def triangles(seed, damping, position_noise, force_noise):
    """Return straight lines to and fro, rounded at their corners, on Kelvin-Voigt tissue."""
    random = np.random.default_rng(seed)
    rate, period, rounding = 100.0, 2.0, 0.06
    time = np.arange(1500) / rate
    # The speed goes from one sign to the other within the rounding, as half a sine does.
    fine = np.arange(0.0, time[-1] + 0.01, 1e-4)
    phase = np.mod(fine - 0.5, period)
    away = np.minimum(np.abs(phase - 0.5 * period), np.minimum(phase, period - phase))
    sign = np.where(phase < 0.5 * period, 1.0, -1.0)
    speed = 2e-3 * sign * np.sin(0.5 * np.pi * np.minimum(away / (0.5 * rounding), 1.0))
    speed[fine < 0.5] = 0.0
    course = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) * 1e-4])
    u, v = np.interp(time, fine, course), np.interp(time, fine, speed)
    force = 1000.0 * u + damping * v + force_noise * random.standard_normal(time.size)
    position = u + position_noise * random.standard_normal(time.size)
    return Measurement(position, force, 1.0 / rate, at_rest=True)


@pytest.mark.parametrize("damping", [3.0, 300.0])
@pytest.mark.parametrize("seed", first_of([1, 2], 1))
def test_a_noisy_position_is_no_effect_even_where_corners_hide_in_its_noise(damping, seed):
    measurement = triangles(seed, damping, 1.5e-6, 1.5e-3)
    found = diagnose(
        Composition("rigid_probe"), [measurement], Instrument("rigid_probe", MASSLESS), EFFECTS
    )
    assert found.verdict == "adequate"
    named = found.ladder.final.named()
    assert named["damping"] == pytest.approx(damping, abs=2.0)
    assert named["stiffness"] == pytest.approx(1000.0, rel=2e-3)


def on_a_load_cell(seed, **of_specimen):
    """Return a motion of the paper's probe, whose encoder makes more noise than its load cell."""
    specimen = Specimen(noise=3e-3, **of_specimen)
    position, _, _, force = specimen.measure(multisine(range(2, 40)), duration=1.0, seed=seed)
    noise = 2e-6 * np.random.default_rng(seed + 100).standard_normal(position.size)
    return Measurement(position + noise, force, specimen.sample_period, at_rest=True)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_noisy_position_is_no_effect_on_a_tip_that_a_load_cell_carries(seed):
    found = diagnose(Composition(), [on_a_load_cell(seed)], Instrument(), EFFECTS)
    assert found.verdict == "adequate"
    named, deviations = found.ladder.final.named(), found.ladder.final.deviations()
    for name, truth in (("stiffness", 800.0), ("damping", 4.0)):
        assert abs(named[name] - truth) < 3.0 * deviations[name]
        assert deviations[name] < 0.03 * truth


def test_an_effect_is_found_beside_the_noise_of_a_position_on_a_load_cell():
    found = diagnose(Composition(), [on_a_load_cell(3, cubic=4e8)], Instrument(), EFFECTS)
    assert (found.verdict, found.effects) == ("missing", ("cubic_stiffening",))
    assert found.ladder.final.named()["cubic_stiffness"] == pytest.approx(4e8, rel=0.1)
