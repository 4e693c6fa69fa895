"""The load cell's zero is found in free air, and never in contact."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from steady_motion import K0, MASS, PERIOD, steady

from tissue_probe.identification.free_air import Refused, free_air_zero


def zero_of(position, force) -> float:
    return free_air_zero(position, force, PERIOD, MASS, K0)


@pytest.mark.parametrize("frequency", [2.0, 5.0, 10.0, 30.0])
@pytest.mark.parametrize("offset", [-1.5, 0.0, 0.2])
def test_the_offset_is_found_in_free_air(frequency, offset):
    position, force = steady({frequency: 1e-3}, 1.0, noise=0.005)
    assert zero_of(position, force + offset) == pytest.approx(offset, abs=0.001)


@settings(max_examples=60, deadline=None)
@given(
    stiffness=st.floats(30.0, 5000.0),
    damping=st.floats(0.0, 30.0),
    frequency=st.floats(2.0, 30.0),
    offset=st.floats(-2.0, 2.0),
)
def test_it_is_refused_on_any_tissue(stiffness, damping, frequency, offset):
    position, force = steady({frequency: 1e-3}, 1.0, stiffness, damping, noise=0.005)
    with pytest.raises(Refused, match=r"in contact|too little to tell"):
        zero_of(position, force + offset)


def test_the_refusal_tells_how_stiff_it_feels():
    position, force = steady({10.0: 1e-3}, 1.0, 440.0, 5.0, noise=0.005)
    with pytest.raises(Refused, match=r"it feels 4[34]\d N/m; lift it"):
        zero_of(position, force)


@pytest.mark.parametrize(
    ("lines", "duration", "said"),
    [
        ({}, 1.0, "the coil does not move"),
        ({5.0: 3e-5}, 1.0, "moves too little"),
        ({10.0: 1e-3}, 0.05, "100 samples are too few"),
    ],
)
def test_it_is_refused_where_contact_cannot_be_told(lines, duration, said):
    with pytest.raises(Refused, match=said):
        zero_of(*steady(lines, duration, noise=0.05))


def test_it_is_refused_where_a_sample_is_missing():
    position, force = steady({10.0: 1e-3}, 1.0)
    force[17] = np.nan
    with pytest.raises(Refused, match="a sample is missing"):
        zero_of(position, force)
