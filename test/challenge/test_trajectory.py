"""Motions of the coil: smooth, from rest, in the band that they are named after."""

from __future__ import annotations

import numpy as np
import pytest

from tissue_probe.challenge.trajectory import DURATIONS, Trajectory

RATE = 80_000
PHASES = tuple(np.random.default_rng(3).uniform(0.0, 6.28, 60).tolist())


def coil(kind, preload=0.0):
    hold = 0.4 if preload else 0.0
    return Trajectory(kind, 1e-3, DURATIONS[kind], preload=preload, hold=hold, phases=PHASES)


@pytest.mark.parametrize("kind", DURATIONS)
@pytest.mark.parametrize("preload", [0.0, 2e-3])
def test_the_velocity_is_the_derivative(kind, preload):
    motion = coil(kind, preload)
    u, rate = motion.sample_motion(RATE)
    slope = (u[2:] - u[:-2]) * RATE / 2.0
    wrong = np.abs(slope - rate[1:-1]) > 1e-5 * np.abs(rate).max()
    # A sine from rest begins at full speed.
    begins = motion.before(RATE) + round(motion.start_of_motion * RATE) - 1
    assert set(np.flatnonzero(wrong)) <= {begins}


@pytest.mark.parametrize("kind", DURATIONS)
def test_before_the_record_the_coil_rests_in_its_preload_but_for_the_steady_sine(kind):
    motion = coil(kind, 2e-3)
    u, rate = motion.sample_motion(RATE)
    first = motion.before(RATE)
    assert u[0] == rate[0] == 0.0
    assert u[first + round(motion.start_of_motion * RATE)] == pytest.approx(2e-3)
    assert (np.abs(rate[first - 100 : first]).max() == 0.0) == (kind != "sine10ss")


@pytest.mark.parametrize("kind", DURATIONS)
def test_the_amplitude_is_reached_and_not_exceeded(kind):
    motion = coil(kind)
    u, _ = motion.sample_motion(RATE)
    assert 0.9e-3 < np.abs(u).max() < 1.002e-3


@pytest.mark.parametrize(("kind", "highest"), [("stepped30", 30.0), ("msine60", 60.0)])
def test_the_band_ends_where_the_name_says(kind, highest):
    motion = coil(kind)
    u, _ = motion.sample_motion(2_000)
    power = np.abs(np.fft.rfft(u)) ** 2
    frequency = np.fft.rfftfreq(u.size, 5e-4)
    beyond = power[frequency > highest + 3.0].sum() / power.sum()
    within = power[np.abs(frequency - highest) < 2.0].sum() / power.sum()
    assert beyond < 3e-3
    assert within > 5e-3


def test_every_rate_gives_the_same_motion():
    motion = coil("msine60", 2e-3)
    fine, coarse = motion.sample_motion(RATE)[0], motion.sample_motion(2_000)[0]
    np.testing.assert_allclose(fine[::40], coarse, atol=1e-12)
