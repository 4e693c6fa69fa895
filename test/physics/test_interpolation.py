"""Splines through equally spaced samples are SciPy's, of many signals at once."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.interpolate import CubicSpline

from tissue_probe.jumps import jumps
from tissue_probe.physics.interpolation import between_jumps, cubics, later

PERIOD = 5e-4
SIGNALS = arrays(
    np.float64,
    st.tuples(st.integers(4, 60), st.integers(1, 4)),
    elements=st.floats(-1e3, 1e3, allow_subnormal=False),
)


@given(SIGNALS)
def test_pieces_are_those_of_scipy(signals):
    expected = CubicSpline(np.arange(len(signals)) * PERIOD, signals[:, 0]).c
    scale = np.max(np.abs(signals)) / PERIOD ** np.arange(3, -1, -1)
    error = np.abs(cubics(signals[:, 0], PERIOD) - expected)
    assert np.all(error <= 1e-11 * scale[:, None])


@given(SIGNALS, st.floats(-70.0, 70.0))
def test_what_was_earlier_is_what_scipy_reads(signals, samples):
    times = np.arange(len(signals)) * PERIOD
    spline, wanted = CubicSpline(times, signals), times - samples * PERIOD
    read, rate = later(signals, PERIOD, samples * PERIOD)
    at, scale = np.clip(wanted, 0.0, times[-1]), np.max(np.abs(signals))
    assert np.max(np.abs(read - spline(at))) <= 1e-11 * scale
    # At an end itself rounding tells whether it stands still.
    between = np.abs(wanted - np.clip(wanted, 1e-9, times[-1] - 1e-9)) == 0.0
    expected = spline(at, 1)[:, 0] * (wanted == at)
    assert np.max(np.abs(rate - expected)[between], initial=0.0) <= 1e-10 * scale / PERIOD


@given(
    st.lists(
        st.tuples(st.integers(4, 12), st.tuples(*3 * [st.floats(-1.0, 1.0)])),
        min_size=1,
        max_size=5,
    )
)
def test_between_jumps_a_course_is_that_of_each_part_up_to_the_next(parts):
    """Cubics are their own splines: each part goes on as its polynomial until the other begins."""
    ends = np.cumsum([length for length, _ in parts])
    values, right = [], []
    for number, (length, (slope, bend, twist)) in enumerate(parts):
        polynomial = np.polynomial.Polynomial([10.0 * number, slope, bend / 10, twist / 100])
        values += list(polynomial(np.arange(length)))
        right += list(polynomial(np.arange(length) + 0.5))
    pieces = between_jumps(np.array(values), 1.0, ends[:-1])
    middle = np.array([np.polyval(piece, 0.5) for piece in pieces.T])
    assert np.allclose(middle, right[:-1], atol=1e-9 * max(np.abs(values)) + 1e-9)


@given(st.floats(6.01, 200.0), st.floats(0.0, 6.3), st.floats(-5.0, 5.0))
def test_a_sine_does_not_jump(samples, phase, offset):
    sine = offset + np.sin(2.0 * np.pi * np.arange(300) / samples + phase)
    assert not jumps(np.diff(sine)[:-1])[1:-1].size


def test_squares_jump_and_ramps_jump_where_they_end():
    square = np.repeat([0.0, 1.0, -2.0, -2.0, 3.0], 7)
    assert list(jumps(np.diff(square))) == [7, 14, 28]
    ramp = np.concatenate([0.1 * np.arange(20), np.zeros(5), [6.0] * 4, 6.0 - 0.1 * np.arange(9)])
    assert list(jumps(np.diff(ramp))) == [20, 25]
    pulse = np.zeros(9)
    pulse[4] = 1.0
    assert list(jumps(np.diff(pulse))) == [4, 5]


def test_what_lies_beyond_the_ends_stands_still():
    signal = np.linspace(1.0, 2.0, 10)[:, None]
    for delay, end in ((1.0, 1.0), (-1.0, 2.0)):
        read, rate = later(signal, PERIOD, delay)
        assert np.all(read == end)
        assert np.all(rate == 0.0)


@pytest.mark.parametrize("read", [cubics, lambda values, h: later(values[:, None], h, 0.0)])
def test_three_samples_are_refused(read):
    with pytest.raises(ValueError, match="3 samples: a cubic spline needs 4 at least"):
        read(np.zeros(3), PERIOD)


def test_a_number_that_is_none_spoils_all_pieces():
    assert np.isnan(cubics(np.array([0.0, 1.0, np.nan, 1.0, 0.0]), PERIOD)[2]).all()
