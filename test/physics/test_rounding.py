"""The smooth course of a coarsely read position."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tissue_probe.physics.rounding import CAUTION, smooth_rounding

PERIOD = 5e-4
TIME = np.arange(4000) * PERIOD


def chirp(time):
    return 1e-3 * np.sin(2 * np.pi * (time + 0.25 * 29.0 * time**2))


def multisine(time):
    phases = np.random.default_rng(1).uniform(0.0, 2 * np.pi, 30)
    lines = np.arange(1, 31)[:, None]
    return 1e-4 * np.sin(2 * np.pi * lines * time + phases[:, None]).sum(axis=0)


def rounded(position, step):
    return np.round(position / step) * step


def rms(values):
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("motion", [chirp, multisine])
@pytest.mark.parametrize("step", [3e-6, 3e-5])
def test_the_course_is_nearer_the_truth_than_what_was_read_and_tells_how_near(motion, step):
    true = motion(TIME)
    found = smooth_rounding(rounded(true, step), step)
    off = rms(found.course - true)
    assert off < 0.6 * rms(rounded(true, step) - true)
    assert rms(found.error) == pytest.approx(off, rel=0.4)


def test_a_motion_whose_speed_grows_is_smoothed_most_where_it_is_slow():
    true = chirp(TIME)
    found = smooth_rounding(rounded(true, 1e-5), 1e-5)
    slow, fast = rms((found.course - true)[200:800]), rms((found.course - true)[3200:3800])
    assert slow < 0.7 * fast


def test_nowhere_does_the_course_leave_the_step_that_was_read():
    # 34 um steps of a sine with a harmonic: their variance is small by chance, so that the course
    # that takes off as much as usual would stray at the ends by more than a step.
    angle = 2 * np.pi * 10.0 * TIME
    true = 2.9e-3 + 1.19e-3 * np.sin(angle) + 1.8e-5 * np.sin(angle) ** 2
    step = 3.35e-5
    read = rounded(true, step)
    found = smooth_rounding(read, step)
    assert np.abs(found.course - read).max() < 0.52 * step
    assert np.abs(found.course - true).max() < 0.5 * step
    assert rms((found.course - true)[100:-100]) < 0.1 * step


def test_the_errors_that_a_steady_sine_makes_in_every_period_are_taken_off():
    true = 1.89804e-3 + 8.068e-4 * np.sin(2 * np.pi * 10.0 * TIME + 0.4)
    read = rounded(true, 1e-7)

    def at_80_hz(error):
        return abs(np.mean(error * np.exp(-2j * np.pi * 80.0 * TIME)))

    course = smooth_rounding(read, 1e-7, fine=True).course
    assert np.max(np.abs(course - true)) < 1.5e-7
    assert at_80_hz(course - true) < 0.3 * at_80_hz(read - true)
    assert rms(course - true) < rms(read - true)


@pytest.mark.parametrize("count", [1, 8, 9, 50])
def test_short_and_motionless_records_stay_as_they_are(count):
    position = np.full(count, 3e-5)
    found = smooth_rounding(position, 1e-5)
    assert found.course == pytest.approx(position, abs=1e-8)
    assert np.isfinite(found.error).all()


@given(
    position=hnp.arrays(np.float64, st.integers(2, 300), elements=st.floats(-1e-3, 1e-3)),
    step=st.sampled_from([1e-7, 1e-5, 1e-3]),
    fine=st.booleans(),
)
def test_any_record_yields_a_finite_course_within_the_errors_of_rounding(position, step, fine):
    read = rounded(position, step)
    found = smooth_rounding(read, step, fine)
    assert np.isfinite(found.course).all()
    assert np.isfinite(found.error).all()
    share = 1.0 if fine else CAUTION
    assert rms(found.course - read) <= 1.1 * np.sqrt(share) * step / np.sqrt(12.0) + 1e-12
