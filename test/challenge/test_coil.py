"""Faults of the coil: as large as they say, smooth, and part of what is measured."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.challenge import make_challenge
from tissue_probe.challenge.coil import HARMONICS, JITTER, Coil
from tissue_probe.challenge.trajectory import DURATIONS, Trajectory

RATE = 8_000
FAULTY = Coil(second=6e-3, third=3e-3, jitter=2e-6, seed=4)


def test_a_sine_has_the_harmonics_that_are_told():
    angle = 2.0 * np.pi * np.arange(200) / 200
    value, _ = Coil(second=6e-3, third=3e-3).distort_motion(np.sin(angle), np.cos(angle))
    lines = 2.0 * np.abs(np.fft.rfft(value)) / 200
    np.testing.assert_allclose(lines[1:5], [1.0, 6e-3, 3e-3, 0.0], atol=1e-12)


def test_jitter_has_its_rms_and_falls_with_the_frequency_up_to_100_hz():
    jitter, _ = FAULTY.draw_jitter(2 * RATE, RATE)
    assert jitter.std() == pytest.approx(2e-6)
    lines = np.abs(np.fft.rfft(jitter))
    np.testing.assert_allclose(lines[2:201] * np.arange(2, 201), 2.0 * lines[2])
    assert lines[201:].max() < 1e-9 * lines[2]


@given(st.sampled_from(list(DURATIONS)), st.integers(0, 100))
def test_the_velocity_is_the_derivative_of_what_a_faulty_coil_does(kind, seed):
    motion = Trajectory(kind, 1e-3, DURATIONS[kind], coil=FAULTY._replace(seed=seed))
    u, rate = motion.sample_motion(RATE)
    slope = (u[2:] - u[:-2]) * RATE / 2.0
    wrong = np.abs(slope - rate[1:-1]) > 1e-3 * np.abs(rate).max()
    begins = motion.before(RATE) + round(motion.start_of_motion * RATE) - 1
    assert set(np.flatnonzero(wrong)) <= {begins}


def test_without_faults_the_coil_does_what_it_is_told():
    motion = Trajectory("chirp60", 1e-3, 4.0)
    u, _ = motion.sample_motion(RATE)
    assert (
        np.abs(u - Trajectory("chirp60", 1e-3, 4.0, coil=FAULTY).sample_motion(RATE)[0]).max()
        > 2e-6
    )
    time = np.arange(u.size) / RATE
    np.testing.assert_allclose(u, 1e-3 * np.sin(2 * np.pi * (time + 59 / 8 * time**2)), atol=1e-15)


def test_before_its_motion_a_faulty_coil_is_at_rest():
    motion = Trajectory("sine10", 1e-3, 2.0, preload=1e-3, hold=0.3, coil=FAULTY)
    u, _ = motion.sample_motion(RATE)
    assert np.ptp(u[motion.before(RATE) - 1000 : motion.before(RATE)]) == 0.0


def test_a_challenge_has_one_coil_of_its_own_in_both_recordings():
    answers = [make_challenge(seed, (), "sine10ss").answer for seed in (1, 2)]
    coils = [answer.excitation["coil"] for answer in answers]
    assert coils[0] != coils[1]
    assert answers[0].second_excitation["coil"] == coils[0]
    for coil in coils:
        assert HARMONICS[0] < coil["second"] < HARMONICS[1]
        assert HARMONICS[0] < coil["third"] < HARMONICS[1]
        assert JITTER[0] < coil["jitter"] < JITTER[1]
