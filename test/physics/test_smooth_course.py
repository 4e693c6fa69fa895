"""Splines of higher degree through samples, against SciPy's and against the truth."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

from tissue_probe.physics.interpolation import cubics
from tissue_probe.physics.smooth_course import splines


def between(pieces, period, order=0):
    since = np.linspace(0.0, period, 5)[:-1]
    return np.array([np.polyval(np.polyder(piece, order), since) for piece in pieces.T]).ravel()


def times(count, period):
    return (np.arange(count - 1)[:, np.newaxis] * period + np.linspace(0, period, 5)[:-1]).ravel()


@given(
    seed=st.integers(0, 1000),
    count=st.integers(18, 80),
    degree=st.sampled_from([3, 7, 9]),
    period=st.sampled_from([1.0, 5e-4]),
)
def test_pieces_are_those_of_scipys_spline(seed, count, degree, period):
    values = np.random.default_rng(seed).standard_normal(count)
    pieces = splines(values, period, degree)
    assert pieces.shape == (degree + 1, count - 1)
    whole = make_interp_spline(np.arange(count) * period, values, k=degree)
    at = times(count, period)
    for order in range(3):
        right = whole(at, order)
        found = between(pieces, period, order)
        np.testing.assert_allclose(found, right, atol=1e-7 * np.abs(right).max())


def test_a_degree_of_seven_follows_what_is_quick():
    period, inside = 1e-3, slice(200, -200)
    values = np.sin(2 * np.pi * 100.0 * np.arange(200) * period)
    right = np.sin(2 * np.pi * 100.0 * times(200, period))
    cubic = np.abs(between(cubics(values, period), period) - right)[inside].max()
    septic = np.abs(between(splines(values, period, 7), period) - right)[inside].max()
    assert cubic > 5e-5
    assert septic < 1e-7


def test_too_few_samples_are_refused():
    with pytest.raises(ValueError, match="13 samples"):
        splines(np.zeros(13), 1.0, 7)
