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


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ((3.1e4, -1.9e7, 1.9e7), "0 ± 1.9 × 10⁷"),
        ((-1e-5, -0.00591, 0.00589), "0 ± 0.0059"),
        ((0.0, -250.0, 250.0), "0 ± 250"),
        ((0.04, -0.96, 1.04), "0 ± 1.0"),
    ],
)
def test_a_value_that_is_lost_in_its_interval_is_zero_give_or_take(given, text):
    assert interval(*given) == (text, "")


def test_an_end_at_zero_has_no_sign():
    assert interval(2.15e-4, -1e-7, 4.3e-4) == ("2.1 × 10⁻⁴", "(0.0 … 4.3) × 10⁻⁴")


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e3))
def test_every_interval_has_two_digits_and_no_value_is_a_bare_zero(value, half):
    told, ends = interval(value, value - half, value + half)
    number = told.removeprefix("0 ± ")
    assert any(digit in number for digit in "123456789")
    if not ends:
        assert float(number) == pytest.approx(half, rel=0.05)
    elif "×" not in ends:
        low, high = (float(end.replace("−", "-")) for end in ends.split(" … "))
        assert 0.5 * (high - low) == pytest.approx(half, rel=0.06)


@given(st.floats(-1e12, 1e12), st.floats(1e-9, 1e6))
def test_no_value_and_no_interval_is_refused(value, half):
    texts = interval(value, value - half, value + half)
    assert all(isinstance(text, str) for text in texts)
