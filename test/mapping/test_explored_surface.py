"""The surface that an exploration comes to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.mapping.explored_surface import ExploredSurface

CORNERS = np.array([(0.0, 0.0, 0.0), (0.03, 0.0, 0.003), (0.03, 0.03, 0.003), (0.0, 0.03, 0.0)])
SLOPE = 0.1

places = st.tuples(st.floats(0.0, 0.03), st.floats(0.0, 0.03))


@given(places)
def test_without_contact_it_is_the_plane_of_the_corners(place):
    point, normal = ExploredSurface(CORNERS).at(place, [])
    assert point == pytest.approx((*place, SLOPE * place[0]), abs=1e-12)
    assert normal == pytest.approx(np.array([-SLOPE, 0.0, 1.0]) / np.hypot(1.0, SLOPE))


@given(places, st.lists(places, min_size=1, max_size=12))
def test_contact_on_the_plane_leaves_the_plane(place, felt):
    on_plane = [(x, y, SLOPE * x) for x, y in felt]
    point, normal = ExploredSurface(CORNERS).at(place, on_plane)
    assert point[2] == pytest.approx(SLOPE * place[0], abs=1e-9)
    assert normal == pytest.approx(np.array([-SLOPE, 0.0, 1.0]) / np.hypot(1.0, SLOPE), abs=1e-6)


def dome(x, y):
    """Height [m] of a sphere of 60 mm whose top is over the middle of the area."""
    return np.sqrt(0.06**2 - (x - 0.015) ** 2 - (y - 0.015) ** 2) - 0.06


def test_a_dome_is_followed_from_nine_felt_places_in_height_and_normal():
    along = (0.005, 0.015, 0.025)
    felt = [(x, y, dome(x, y)) for x in along for y in along]
    surface = ExploredSurface(CORNERS * (1.0, 1.0, 0.0))
    for place in [(0.01, 0.01), (0.02, 0.012), (0.027, 0.015)]:
        point, normal = surface.at(place, felt)
        # A plane is up to 2.5 mm off; contact is searched within some tenths of a millimetre.
        assert point[2] == pytest.approx(dome(*place), abs=2e-4)
        x, y = place
        true = np.array([x - 0.015, y - 0.015, dome(x, y) + 0.06]) / 0.06
        # The plane would be off by up to 12 degrees.
        assert np.degrees(np.arccos(normal @ true)) < 5.0


def test_one_felt_place_moves_what_is_near_it_and_twice_the_same_is_no_error():
    surface = ExploredSurface(CORNERS * (1.0, 1.0, 0.0))
    felt = [(0.01, 0.01, 0.001)] * 2
    assert surface.at((0.01, 0.01), felt)[0][2] == pytest.approx(0.001, rel=0.02)
    assert 0.0 < surface.at((0.0, 0.03), felt)[0][2] < 0.001


@given(places)
def test_the_normal_is_that_of_the_heights_about_it(place):
    felt = [(0.01, 0.012, 0.0004), (0.02, 0.005, -0.0003), (0.025, 0.022, 0.0002)]
    surface = ExploredSurface(CORNERS)
    (x, y), step = place, 1e-5
    slope = [
        (surface.at((x + a, y + b), felt)[0][2] - surface.at((x - a, y - b), felt)[0][2])
        / (2 * step)
        for a, b in ((step, 0.0), (0.0, step))
    ]
    normal = np.array([-slope[0], -slope[1], 1.0])
    told = surface.at(place, felt)[1]
    assert told == pytest.approx(normal / np.linalg.norm(normal), abs=1e-6)
