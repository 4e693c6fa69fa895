"""The first sites: over all of the area, and nowhere else."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.exploration.first import FIRST_SITES, first_sites
from tissue_probe.mapping.exploration.places import spread
from tissue_probe.mapping.polygon import Polygon

SQUARE = Polygon(np.array([(0.0, 0.0), (0.04, 0.0), (0.04, 0.04), (0.0, 0.04)]))


def test_no_place_of_a_square_is_far_from_the_first_sites():
    sites = np.array(first_sites(SQUARE))
    assert len(sites) == FIRST_SITES
    x, y, _ = spread(SQUARE, 400)
    nearest = np.hypot(x[:, None] - sites[:, 0], y[:, None] - sites[:, 1]).min(axis=1)
    # Of three by three sites in the middles of their parts a corner is 9.4 mm away.
    assert nearest.max() < 0.013


def test_the_way_does_not_cross_the_area_again_and_again():
    way = np.array(first_sites(SQUARE))
    assert np.hypot(*np.diff(way, axis=0).T).sum() < 0.16


def test_no_first_site_is_in_a_zone_or_outside():
    shape = Polygon(
        np.array([(0, 0), (0.04, 0), (0.04, 0.01), (0.01, 0.01), (0.01, 0.04), (0, 0.04)])
    )
    zone = Polygon(np.array([(0.02, 0.0), (0.04, 0.0), (0.04, 0.04), (0.02, 0.04)]))
    x, y = np.array(first_sites(shape, [zone])).T
    assert shape.contains(x, y).all()
    assert not zone.contains(x, y).any()


def test_an_area_without_a_place_is_refused():
    with pytest.raises(ParameterError, match="no place is left"):
        first_sites(SQUARE, [SQUARE])


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=3, max_size=7),
    st.integers(1, 500),
)
def test_places_of_any_polygon_are_inside_it(corners, most):
    try:
        shape = Polygon(np.array(corners))
    except ParameterError:
        return
    x, y, step = spread(shape, most)
    assert x.size >= 1
    assert shape.contains(x, y).all()
    assert step > 0.0
