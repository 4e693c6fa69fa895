"""Jittering times give the signal at even times; rounded ones give the samples as they are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from tissue_probe.recording.clocks.even_grid import even_grid, interpolate
from tissue_probe.recording.errors import RecordingError


def sine(time, frequency=10.0):
    return np.sin(2.0 * np.pi * frequency * time)


def resampled(grid, time, values):
    return [(span.times, grid.values(span, time, values)) for span in grid.spans]


@given(
    period=st.sampled_from([5e-4, 1e-3, 1 / 3000, 0.02]),
    digits=st.integers(4, 9),
    start=st.sampled_from([0.0, 3.7, 1e5]),
)
@settings(max_examples=60, deadline=None)
def test_times_rounded_by_their_writer_leave_the_samples_as_they_are(period, digits, start):
    time = np.round(start + period * np.arange(500), digits)
    grid = even_grid(time, "x.csv")
    assert grid.even
    assert grid.notes == ()
    assert grid.period == pytest.approx(period, rel=1e-3)
    ((_, values),) = resampled(grid, time, sine(time))
    assert_array_equal(values, sine(time))


@pytest.mark.parametrize("jitter", [0.02, 0.1, 0.2])
def test_jittering_times_are_resampled_and_it_is_said(jitter):
    period, noise = 5e-4, np.random.default_rng(3)
    time = 5.0 + period * (np.arange(4000) + jitter * noise.uniform(-1.0, 1.0, 4000))
    grid = even_grid(time, "x.csv")
    assert not grid.even
    ((at, values),) = resampled(grid, time, sine(time))
    assert_allclose(np.diff(at)[:-1], grid.period, rtol=1e-9)
    assert grid.period == pytest.approx(period, rel=1e-5)
    assert_allclose(values, sine(at), atol=2e-6)
    (note,) = grid.notes
    assert "where that is needed, resampled by a cubic spline at 2000" in note
    assert "x.csv" in note


def test_a_few_odd_steps_leave_the_period_as_it_is():
    time = np.cumsum([0.0, *[0.02] * 400, 0.001, 0.019, *[0.02] * 300, 0.011, *[0.02] * 300])
    grid = even_grid(time, "x.csv")
    assert grid.period == pytest.approx(0.02, rel=1e-9)
    ((at, values),) = resampled(grid, time, sine(time, 1.0))
    assert_allclose(values, sine(at, 1.0), atol=1e-5)
    assert "at 50 Hz" in grid.notes[0]


def test_gaps_split_the_samples_and_count_what_is_missing():
    time = np.delete(np.arange(1000) * 1e-3, [*range(300, 400), 700])
    grid = even_grid(time, "x.csv")
    assert [span.sequence for span in grid.spans] == [0, 400, 701]
    assert [span.times.size for span in grid.spans] == [300, 300, 299]
    (note,) = grid.notes
    assert "2 gaps, the longest 0.101 s; split into 3 parts" in note


@given(digits=st.integers(4, 9), lost=st.sets(st.integers(1, 998), max_size=20))
@settings(max_examples=60, deadline=None)
def test_short_gaps_leave_samples_that_are_not_known(digits, lost):
    lost = sorted(lost - {n for n in lost if {n - 1, n - 2, n - 3} <= lost})
    kept = np.delete(np.arange(1000), lost)
    time = np.round(5.0 + kept * 5e-4, digits)
    grid = even_grid(time, "x.csv", bridged=3)
    assert grid.notes == ()
    (span,) = grid.spans
    values = grid.values(span, time, sine(time))
    assert list(np.flatnonzero(np.isnan(values))) == lost
    assert_array_equal(values[kept], sine(time))
    assert_allclose(span.times, 5.0 + np.arange(1000) * 5e-4, atol=1e-4)


@pytest.mark.parametrize("share", [0.1, 0.4])
def test_many_missing_samples_are_no_irregular_sampling(share):
    kept = np.random.default_rng(4).uniform(size=4000) >= share
    kept[:2] = True
    time = np.arange(4000)[kept] * 5e-4
    grid = even_grid(time, "x.csv", bridged=20)
    (span,) = grid.spans
    assert_allclose(grid.period, 5e-4, rtol=1e-9)
    known = np.isfinite(grid.values(span, time, sine(time)))
    assert_array_equal(known, kept[: known.size])


@pytest.mark.parametrize("spread", [0.2, 0.3])
def test_times_that_jitter_by_nearly_a_third_of_a_period_are_one_stretch(spread):
    period, random = 5e-3, np.random.default_rng(7)
    time = period * (np.arange(4000) + np.clip(spread * random.standard_normal(4000), -0.49, 0.49))
    ((at, values),) = resampled(even_grid(time, "x.csv"), time, sine(time))
    assert at.size > 3990
    assert np.isfinite(values).all()
    assert_allclose(values, sine(at), atol=2e-3)


@pytest.mark.parametrize("spread", [0.1, 0.3])
def test_a_loop_whose_steps_jitter_is_one_stretch(spread):
    random = np.random.default_rng(8)
    steps = 5e-3 * np.maximum(1.0 + spread * random.standard_normal(4000), 0.05)
    time = np.cumsum(steps)
    ((at, values),) = resampled(even_grid(time, "x.csv"), time, sine(time))
    assert at.size > 3900
    assert np.isfinite(values).all()


def test_longer_gaps_and_those_behind_which_the_clock_is_out_of_step_still_split():
    clock = np.arange(1000) * 1e-3
    clock[700:] += 4e-4
    time = np.delete(clock, [*range(300, 304), 500, 700])
    grid = even_grid(time, "x.csv", bridged=3)
    assert grid.even
    assert [span.sequence for span in grid.spans] == [0, 304, 701]
    assert [span.times.size for span in grid.spans] == [300, 396, 299]
    assert "2 gaps, the longest 0.005 s; split into 3 parts" in grid.notes[0]


def test_short_gaps_of_jittering_times_are_not_filled_by_resampling():
    period, noise = 5e-4, np.random.default_rng(3)
    time = period * (np.arange(4000) + 0.1 * noise.uniform(-1.0, 1.0, 4000))
    lost = np.arange(100, 3900, 100)
    time = np.delete(time, lost)
    grid = even_grid(time, "x.csv", bridged=3)
    ((at, values),) = resampled(grid, time, sine(time))
    unknown = np.isnan(values)
    away = np.abs(np.subtract.outer(at[unknown] / period, lost))
    assert (away.min(axis=1) < 1.2).all()
    assert (away.min(axis=0) < 1.2).all()
    assert_allclose(values[~unknown], sine(at[~unknown]), atol=1e-4)


@pytest.mark.parametrize(
    ("time", "said"),
    [
        ([0.0], "1 samples; give at least two"),
        ([0.0, 1.0, np.nan], "row 3 (t = nan s): no time"),
        ([0.0, 1.0, 1.0], "row 3 (t = 1 s): a time not later"),
        ([0.0, 1.0, 2.0, 2.2, 4.0, 4.3, 6.0], "is sampled irregularly"),
    ],
)
def test_times_that_are_no_regular_sampling_are_refused(time, said):
    with pytest.raises(RecordingError) as raised:
        even_grid(np.array(time), "x.csv")
    assert said in str(raised.value)


def test_values_not_known_are_not_invented():
    time = np.arange(100) * 0.01
    values = sine(time, 1.0)
    values[40:50] = np.nan
    at = np.linspace(-0.1, 1.1, 500)
    found = interpolate(time, values, at)
    unknown = (at < 0.0) | (at > 0.99) | ((at > 0.39) & (at < 0.5))
    assert_array_equal(np.isnan(found), unknown)
    assert_allclose(found[~unknown], sine(at[~unknown], 1.0), atol=1e-5)


@given(jump=st.integers(5, 90), height=st.floats(-3.0, 3.0).filter(lambda h: abs(h) > 0.3))
@settings(max_examples=30, deadline=None)
def test_a_jump_between_two_uneven_samples_does_not_ring(jump, height):
    random = np.random.default_rng(jump)
    time = np.arange(100) + 0.2 * random.uniform(-1.0, 1.0, 100)
    values = np.where(np.arange(100) < jump, 0.0, height) + 1e-3 * random.standard_normal(100)
    at = np.arange(1.0, 98.0, 0.25)
    found = interpolate(time, values, at)
    beside = (at < time[jump - 1]) | (at > time[jump])
    right = np.where(at < time[jump], 0.0, height)
    assert np.max(np.abs(found - right)[beside]) < 0.01
