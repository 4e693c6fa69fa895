"""A late channel, read earlier as its samples come."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.estimation.late import Late

COEFFICIENTS = st.lists(st.floats(-5.0, 5.0), min_size=4, max_size=4)


@given(samples=st.floats(0.0, 40.0), coefficients=COEFFICIENTS)
def test_a_cubic_is_read_exactly(samples, coefficients):
    cubic = np.polynomial.Polynomial(coefficients)
    place = np.arange(100.0) / 20.0
    read = Late(samples).read(cubic(place))
    late = read[45:] - cubic(place[45:] - samples / 20.0)
    assert np.abs(late).max() < 1e-9 * (1.0 + np.abs(cubic(place)).max())


@given(
    samples=st.floats(0.0, 40.0),
    cuts=st.lists(st.integers(1, 90), max_size=6),
    seed=st.integers(0, 2**32 - 1),
)
def test_no_cut_into_blocks_changes_a_bit(samples, cuts, seed):
    values = np.random.default_rng(seed).standard_normal(100)
    late = Late(samples)
    parts = np.split(values, sorted(set(cuts)))
    cut = np.concatenate([late.read(part) for part in parts])
    np.testing.assert_array_equal(cut, Late(samples).read(values))


@pytest.mark.parametrize("samples", [0.0, 0.3, 1.0, 2.5, 7.0])
def test_what_came_before_the_first_stands_still_and_no_sample_is_read_ahead(samples):
    values = np.zeros(60)
    values[30] = 1.0
    read = Late(samples).read(values)
    assert not read[:30].any()
    assert Late(samples).read(np.ones(5)) == pytest.approx(np.ones(5))
    late = Late(samples)
    late.read(np.full(50, 7.0))
    late.restart()
    assert late.read(np.ones(5)) == pytest.approx(np.ones(5))
