"""Values as engineers read them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.quantities import engineering, scale_value


@given(st.floats(1e-12, 1e12), st.sampled_from(["N", "m", "N/m", "Hz"]))
def test_a_value_has_one_to_three_digits_before_the_point_and_stays_itself(value, unit):
    number, shown = engineering(value, unit).split()
    assert 1.0 <= abs(float(number)) < 1000.0 or not 1e-12 <= value < 1e12
    factor, _ = scale_value(value, unit)
    assert float(number) * factor == pytest.approx(value, rel=6e-3)
    assert shown.endswith(unit)


@pytest.mark.parametrize(
    ("value", "unit", "told"),
    [
        (0.0402, "N", "40.2 mN"),
        (-1437.0, "N", "-1.44 kN"),
        (999.96, "N", "1 kN"),
        (0.0, "N", "0 N"),
        (0.04, "kg", "40 g"),
        (0.5, "1", "0.5"),
        (3.0, "1/s", "3 1/s"),
        (math.nan, "N", "nan N"),
    ],
)
def test_prefixes_are_those_of_engineers(value, unit, told):
    assert engineering(value, unit) == told
