"""When a dwell has told enough: a period seen, the test's time over, filters sure and agreed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.mapping.fusion import Estimate
from tissue_probe.mapping.leaving import DwellEvidence, period
from tissue_probe.signals import SampleBlock, Status

BEGIN = 10**18
MS = 1_000_000
TEST = 0.2


def estimate(stamp, k=450.0, sd=0.2):
    return Estimate(stamp, k, 5.0, 1.0, sd**2, 0.001)


def dwell(seconds, *, frequency=10.0, filters=("ekf", "ukf"), course=None, status=None, test=TEST):
    """Feed a dwell block by block; return when it was enough, in s since it began, or None."""
    told = DwellEvidence(BEGIN, test)
    for number in range(round(seconds * 200)):
        stamp = BEGIN + 5 * MS * number
        t = 0.005 * number + 0.0005 * np.arange(10)
        position = 1e-3 * np.sin(2 * np.pi * frequency * t + 1.0)
        told.add_samples(SampleBlock(stamp, 10 * number, 0.0005, position, 0 * t, 0 * t))
        for name in filters:
            end = stamp + 9 * MS // 2
            since = (end - BEGIN) / 1e9
            k = 450.0 if course is None else course(name, since)
            told.add_estimate(name, status(name, since) if status else 1, estimate(end, k))
        enough = told.enough()
        if enough is not None:
            assert enough <= stamp + 5 * MS
            return (enough - BEGIN) / 1e9
    return None


def test_a_plain_dwell_ends_when_the_models_test_has_had_its_time():
    assert dwell(1.0) == pytest.approx(TEST, abs=0.006)


def test_a_slow_drive_is_seen_for_a_period():
    assert 0.5 <= dwell(1.0, frequency=2.0) <= 0.62
    assert dwell(0.9, frequency=1.0) is None


def test_filters_that_differ_have_not_told_enough():
    assert dwell(1.0, course=lambda name, t: 450.0 if name == "ekf" else 460.0) is None


def test_an_estimate_on_its_way_has_not_told_enough_however_small_its_variance():
    """The error of 6 % fades; it is below half a per cent only after that."""

    def course(name, t):
        return 450.0 * (1.0 + 0.06 * np.exp(-t / 0.08) * np.cos(2 * np.pi * 20.0 * t))

    left = dwell(1.0, course=course)
    assert left > 0.21
    assert abs(0.06 * np.exp(-left / 0.08)) < 0.005


@pytest.mark.parametrize("wrong", [Status.MODEL_REJECTED, Status.DISTURBED])
def test_a_doubt_at_any_time_holds_the_probe_for_its_longest_time(wrong):
    def status(name, t):
        return wrong if name == "ukf" and 0.05 < t < 0.06 else Status.CONVERGED

    assert dwell(1.0, status=status) is None


def test_a_filter_that_does_not_know_the_tissue_yet_is_waited_for():
    def status(name, t):
        return Status.CONVERGING if name == "ukf" and t < 0.4 else Status.CONVERGED

    assert dwell(1.0, status=status) == pytest.approx(0.4, abs=0.01)


def test_a_filter_that_remembers_while_no_force_is_known_has_told_nothing():
    told = DwellEvidence(BEGIN, TEST)
    for number in range(200):
        stamp = BEGIN + 5 * MS * number
        t = 0.005 * number + 0.0005 * np.arange(10)
        position = 1e-3 * np.sin(2 * np.pi * 10.0 * t + 1.0)
        told.add_samples(SampleBlock(stamp, 10 * number, 0.0005, position, np.nan * t, 0 * t))
        told.add_estimate("ekf", Status.CONVERGED, estimate(stamp)._replace(innovation=np.nan))
        assert told.enough() is None


def test_a_filter_that_fell_silent_is_not_taken_for_one_that_agrees():
    told = DwellEvidence(BEGIN, 0.0)
    t = 0.0005 * np.arange(2000)
    told.add_samples(SampleBlock(BEGIN, 0, 0.0005, np.sin(62.8 * t), 0 * t, 0 * t))
    for number in range(200):
        told.add_estimate("ekf", Status.CONVERGED, estimate(BEGIN + 5 * MS * number))
    assert told.enough() is not None
    told.add_estimate("ukf", Status.CONVERGED, estimate(BEGIN + 5 * MS))
    assert told.enough() is None


def test_without_estimates_or_motion_nothing_is_told():
    assert dwell(1.0, filters=()) is None
    assert dwell(1.0, frequency=0.0) is None


def test_what_came_before_the_dwell_says_nothing_of_it():
    told = DwellEvidence(BEGIN, 0.0)
    told.add_estimate("ekf", Status.MODEL_REJECTED, estimate(BEGIN - 1))
    t = 0.0005 * np.arange(400)
    told.add_samples(SampleBlock(BEGIN - 100 * MS, 0, 0.0005, np.sin(62.8 * t), 0 * t, 0 * t))
    told.add_estimate("ekf", Status.CONVERGED, estimate(BEGIN + 50 * MS))
    assert told.enough() is None  # half of the period was seen before the dwell
    told.add_samples(SampleBlock(BEGIN + 100 * MS, 400, 0.0005, np.sin(62.8 * t), 0 * t, 0 * t))
    told.add_estimate("ekf", Status.CONVERGED, estimate(BEGIN + 150 * MS))
    assert told.enough() == BEGIN + 150 * MS + 1


@given(st.floats(0.0, 6.28), st.floats(0.5, 50.0), st.floats(1e-5, 1.0))
def test_a_period_is_seen_after_one_period_whatever_the_phase(phase, frequency, amplitude):
    t = np.arange(round(2.5 * 2000 / frequency)) / 2000.0
    rng = np.random.default_rng(1)
    noise = 1e-3 * amplitude * rng.standard_normal(t.size)
    count = period(amplitude * np.cos(2 * np.pi * frequency * t + phase) + noise)
    assert 0.85 <= count * frequency / 2000.0 <= 1.25
