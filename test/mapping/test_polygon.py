"""Polygons: what is inside, and which corners make none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.polygon import Polygon


def polygon(*corners):
    return Polygon(np.array(corners, dtype=float))


def test_an_l_has_its_notch_outside():
    shape = polygon((0, 0), (4, 0), (4, 2), (2, 2), (2, 4), (0, 4))
    x, y = np.array([1.0, 3.0, 3.0, 1.0, -1.0]), np.array([1.0, 1.0, 3.0, 3.0, 1.0])
    assert shape.contains(x, y).tolist() == [True, True, False, True, False]
    assert shape.area == pytest.approx(12.0)


def test_corners_and_edges_are_inside():
    shape = polygon((0, 0), (0.04, 0), (0.04, 0.04), (0, 0.04))
    along = np.linspace(0.0, 0.04, 9)
    for x, y in ((along, 0 * along), (along, 0 * along + 0.04), (0 * along, along)):
        assert shape.contains(x, y).all()
    assert not shape.contains(along, 0 * along - 1e-6).any()


@given(
    st.floats(0.0, 6.28), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.booleans(),
)  # fmt: skip
def test_a_square_turned_and_shifted_has_the_same_inside(angle, dx, dy, mirrored):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
    corners = square @ turn.T + [dx, dy]
    shape = Polygon(corners[::-1] if mirrored else corners)
    places = np.array([(0.5, 0.5), (0.9, 0.1), (1.2, 0.5), (-0.2, 0.5), (0.5, 1.3)])
    x, y = (places @ turn.T + [dx, dy]).T
    assert shape.contains(x, y).tolist() == [True, True, False, False, False]
    assert shape.area == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("corners", "message"),
    [
        ([(0, 0), (1, 0)], "three corners or more"),
        ([(0, 0), (1, 0), (float("nan"), 1)], "not finite"),
        ([(0, 0), (1, 1), (2, 2)], "on one line"),
    ],
)
def test_corners_that_hold_nothing_are_refused(corners, message):
    with pytest.raises(ParameterError, match=message):
        polygon(*corners)


@pytest.mark.parametrize("turn", range(4))
def test_sides_that_cross_are_told_by_their_corners(turn):
    """A bow tie has no area by the corners' formula, an uneven one has some."""
    for wide in (0.04, 0.06):
        corners = np.array([[0.0, 0.0], [wide, 0.04], [0.0, 0.04], [0.04, 0.0]])
        with pytest.raises(ParameterError, match=r"sides of a polygon cross: that from corner \d"):
            Polygon(np.roll(corners, turn, axis=0))


def test_a_corner_that_is_given_twice_crosses_nothing():
    closed = np.array([[0.0, 0.0], [0.04, 0.0], [0.04, 0.04], [0.0, 0.04], [0.0, 0.0]])
    assert Polygon(closed).area == pytest.approx(0.0016)
