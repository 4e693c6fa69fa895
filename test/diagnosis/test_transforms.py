"""Transforms and chances give the numbers of SciPy's, which take longer to import."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import signal, stats

from tissue_probe.diagnosis import chance, transforms

RATE = 2000.0


def sizes(least, most=200):
    return st.integers(least, most).flatmap(
        lambda n: arrays(np.float64, n, elements=st.floats(-1e3, 1e3, width=32))
    )


def close(found, wanted, scale=1.0):
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * max(scale, 1e-9))


@given(sizes(1), sizes(1))
def test_a_correlation_is_the_sum_of_products_at_each_lag(one, other):
    close(transforms.correlation(one, other), np.correlate(one, other, mode="full"), 1e6 * one.size)


@given(sizes(2))
def test_a_periodogram_counts_both_signs_of_frequency(values):
    frequencies, power = transforms.periodogram(values, 1.0 / RATE)
    wanted = signal.periodogram(values, RATE, window="hann", detrend="constant")
    close(frequencies, wanted[0])
    close(power, wanted[1], np.abs(values).max() ** 2)


@given(sizes(64), st.integers(8, 40))
def test_segments_of_a_spectrum_overlap_by_half(values, segment):
    frequencies, density = transforms.welch(values, 1.0 / RATE, segment)
    wanted = signal.welch(values, RATE, nperseg=segment)
    close(frequencies, wanted[0])
    close(density, wanted[1], np.abs(values).max() ** 2)


@given(sizes(1))
def test_an_analytic_signal_has_the_values_as_its_real_part(values):
    scale = np.abs(values).max()
    close(transforms.analytic(values), signal.hilbert(values), scale)
    close(transforms.analytic(values).real, values, scale)


@given(sizes(2))
def test_no_line_is_left(values):
    close(transforms.without_line(values), signal.detrend(values), 1e3 * np.abs(values).max())


@given(sizes(31), st.sampled_from([(9, 4), (31, 3), (5, 2)]), st.integers(0, 2))
def test_a_derivative_is_that_of_the_polynomial_through_a_window(values, shape, order):
    found = transforms.smooth_values(values, *shape, order, 1.0 / RATE)
    wanted = signal.savgol_filter(values, *shape, deriv=order, delta=1.0 / RATE)
    close(found, wanted, np.abs(values).max() * RATE**order)


@given(
    st.integers(3, 60).flatmap(lambda n: arrays(np.float64, n, elements=st.integers(-3, 3))),
    st.integers(-3, 3),
)
def test_a_flat_peak_is_found_in_its_middle(values, least):
    found = transforms.peaks(values, least)
    np.testing.assert_array_equal(found, signal.find_peaks(values, height=least)[0])


@pytest.mark.parametrize("value", [-3.0, 0.0, 0.5, 4.0, 30.0])
def test_a_normal_variable_has_the_tail_of_the_normal_distribution(value):
    assert chance.normal_beyond(value) == pytest.approx(stats.norm.sf(value), rel=1e-12)
    beyond = stats.norm.sf(value)
    if 0 < beyond < 1:
        assert chance.normal_at(beyond) == pytest.approx(stats.norm.isf(beyond), abs=1e-9)


@given(st.floats(0.0, 500.0), st.floats(0.5, 300.0))
def test_chi_squared_has_its_tail_and_median(value, freedom):
    wanted = stats.chi2.sf(value, freedom)
    assert chance.chi_squared_beyond(value, freedom) == pytest.approx(wanted, rel=1e-9, abs=1e-300)
    assert chance.chi_squared_median(freedom) == pytest.approx(stats.chi2.median(freedom))


@given(arrays(np.float64, 5, elements=st.floats(0.0, 1e3)), st.integers(1, 9), st.integers(1, 99))
def test_f_has_its_tail(values, above, below):
    wanted = stats.f.sf(values, above, below)
    np.testing.assert_allclose(
        chance.f_beyond(values, above, below), wanted, rtol=1e-7, atol=1e-300
    )


@given(st.integers(0, 60), st.integers(1, 50), st.floats(0.0, 1.0))
def test_successes_are_counted_from_the_count_on(count, trials, each):
    wanted = stats.binom.sf(count - 1, trials, each)
    found = chance.binomial_from(count, trials, each)
    assert found == pytest.approx(wanted, rel=1e-7, abs=1e-300)


def test_a_mean_is_told_from_zero_as_by_students_t():
    values = np.random.default_rng(1).normal(0.3, 1.0, 20)
    wanted = stats.ttest_1samp(values, 0.0).pvalue
    assert chance.mean_is_zero(values) == pytest.approx(wanted, rel=1e-12)
    assert chance.mean_is_zero(np.full(9, 0.2)) == 0.0
    assert chance.mean_is_zero(np.zeros(9)) == 1.0
