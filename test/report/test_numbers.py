"""Numbers in reports: digits as many as are known."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.report.numbers import interval, significant


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (4.9876, "4.99"),
        (43.21, "43.2"),
        (0.0, "0.00"),
        (-3.2, "−3.20"),
        (1234.5, "1230"),
        (1.0013e8, "1.00 × 10⁸"),
        (2.5e-5, "2.50 × 10⁻⁵"),
        (math.nan, "–"),
    ],
)
def test_a_value_has_three_digits(value, text):
    assert significant(value) == text


@pytest.mark.parametrize(
    ("given", "texts"),
    [
        ((800.31, 798.9, 801.7), ("800.3", "798.9 … 801.7")),
        ((4.012, 3.994, 4.03), ("4.012", "3.994 … 4.030")),
        ((1.0013e8, 0.9989e8, 1.0037e8), ("1.0013 × 10⁸", "(0.9989 … 1.0037) × 10⁸")),
        ((0.5, math.nan, math.nan), ("0.5000", "")),
        ((12345.0, 11000.0, 14000.0), ("12300", "11000 … 14000")),
    ],
)
def test_a_value_has_two_digits_of_its_interval(given, texts):
    assert interval(*given) == texts


@given(st.floats(-1e12, 1e12), st.floats(1e-9, 1e6))
def test_no_value_and_no_interval_is_refused(value, half):
    texts = interval(value, value - half, value + half)
    assert all(isinstance(text, str) for text in texts)
