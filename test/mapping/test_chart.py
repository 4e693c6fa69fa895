"""Sites in space are laid flat: distances are kept, and places come back to where they were."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist
from scipy.spatial.transform import Rotation

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.chart import Chart
from tissue_probe.mapping.sites import Sites

STEP = 0.005


def raster(count=7):
    x, y = (each.ravel() for each in np.meshgrid(STEP * np.arange(count), STEP * np.arange(count)))
    return np.column_stack([x, y, np.zeros_like(x)])


def sites_at(points):
    x, y, z = points.T
    k = np.full(x.size, 450.0)
    return Sites(x, y, z, None, k, 0.02 * k)


def laid(chart):
    return np.column_stack([chart.sites.x, chart.sites.y])


@settings(max_examples=60, deadline=None)
@given(
    turn=st.tuples(*3 * [st.floats(-np.pi, np.pi)]),
    shift=st.tuples(*3 * [st.floats(-0.5, 0.5)]),
)
def test_a_plane_keeps_its_distances_however_it_is_turned_and_places_come_back(turn, shift):
    points = raster(5) @ Rotation.from_euler("xyz", turn).as_matrix().T + shift
    chart = Chart.of(sites_at(points))
    # x and y are kept where they are right to 2 %.
    exact = 1e-9 if chart.note else 0.02
    assert pdist(laid(chart)) == pytest.approx(pdist(points), rel=exact)
    np.testing.assert_allclose(chart.places(chart.sites.x, chart.sites.y), points, atol=1e-9)


def test_x_and_y_of_a_level_surface_are_kept_bit_for_bit():
    points = raster()
    points[:, 2] += 1e-4 * np.random.default_rng(1).standard_normal(len(points))
    given_sites = sites_at(points)
    chart = Chart.of(given_sites)
    assert chart.sites is given_sites
    assert chart.note == ""


def test_an_upright_wall_is_told_as_such():
    chart = Chart.of(sites_at(raster()[:, [2, 0, 1]]))
    assert "in a plane tilted by 90 degrees" in chart.note
    assert sorted(np.ptp(laid(chart), axis=0)) == pytest.approx(2 * [6 * STEP])


def test_a_line_that_climbs_lies_in_the_plane_that_is_tilted_least():
    along = STEP * np.arange(8.0)
    points = np.column_stack([along, np.zeros(8), along])
    chart = Chart.of(sites_at(points))
    assert np.ptp(chart.sites.y) < 1e-12
    assert np.ptp(chart.sites.x) == pytest.approx(np.ptp(along) * np.sqrt(2.0))


def cap(radius, most=np.pi / 4.0):
    """Points of a sphere to an angle from its pole, on rings."""
    rings = [(0.0, np.zeros(1))]
    for angle in np.linspace(0.0, most, 6)[1:]:
        around = max(int(16 * angle / most), 6)
        rings.append((angle, np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)))
    angle = np.concatenate([np.full(turns.size, angle) for angle, turns in rings])
    turn = np.concatenate([turns for _, turns in rings])
    out = np.sin(angle)
    return radius * np.column_stack([out * np.cos(turn), out * np.sin(turn), np.cos(angle)])


def test_ways_along_a_cylinder_are_those_on_its_unrolled_surface():
    angle, along = (
        each.ravel() for each in np.meshgrid(np.linspace(-0.8, 0.8, 9), STEP * np.arange(9.0))
    )
    radius = 0.025
    points = np.column_stack([radius * np.sin(angle), along, radius * np.cos(angle)])
    chart = Chart.of(sites_at(points))
    assert "bent surface" in chart.note
    unrolled = np.column_stack([radius * angle, along])
    assert pdist(laid(chart)) == pytest.approx(pdist(unrolled), rel=0.03)


def test_near_places_of_a_cap_keep_their_distance_and_all_come_back():
    radius = 0.03
    points = cap(radius)
    chart = Chart.of(sites_at(points))
    chords = pdist(points)
    ways = 2.0 * radius * np.arcsin(chords / (2.0 * radius))
    near = ways < 0.01
    # A sphere is not flat: its curvature stays somewhere.
    assert pdist(laid(chart))[near] == pytest.approx(ways[near], rel=0.15)
    assert np.mean(pdist(laid(chart))[near] / ways[near]) == pytest.approx(1.0, abs=0.03)
    np.testing.assert_allclose(chart.places(chart.sites.x, chart.sites.y), points, atol=1e-6)


def test_places_visited_twice_at_other_heights_are_one():
    points = cap(0.03)
    again = points[:10] + np.array([0.0, 0.0, 1e-4])
    chart = Chart.of(sites_at(np.concatenate([points, again])))
    assert laid(chart)[-10:] == pytest.approx(laid(chart)[:10], abs=2e-4)


def test_a_surface_that_folds_over_is_refused_with_two_of_its_sites():
    angle, along = (
        each.ravel()
        for each in np.meshgrid(
            np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False), STEP * np.arange(9.0)
        )
    )
    finger = np.column_stack([0.01 * np.cos(angle), along, 0.01 * np.sin(angle)])
    with pytest.raises(ParameterError, match=r"folds over: those at .* map each side by itself"):
        Chart.of(sites_at(finger))


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_sites_have_a_chart(count):
    points = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.02], [0.0, 0.01, 0.01]])[:count]
    chart = Chart.of(sites_at(points))
    np.testing.assert_allclose(chart.places(chart.sites.x, chart.sites.y), points, atol=1e-9)
