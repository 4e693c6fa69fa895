"""Splines through equally spaced samples are SciPy's, of many signals at once."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.interpolate import CubicSpline

from tissue_probe.physics.interpolation import cubics, later

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
