"""Where an inclusion may lie: in the hull of the sites, however they are scattered."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.mapping.posterior.domain import Domain
from tissue_probe.mapping.posterior.posterior_map import map_of
from tissue_probe.mapping.sites import Sites

NONE = np.empty((0, 2))


def may_lie(domain, x, y):
    """Whether the middle of an inclusion may lie at a place [mm]."""
    hull = domain.region(np.zeros(1), np.zeros(1)).hull
    return bool((hull @ [x, y, 1.0] <= 0.0).all())


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0)), min_size=1, max_size=20),
    st.lists(st.floats(0.01, 1.0), min_size=20, max_size=20),
)
def test_an_inclusion_may_lie_anywhere_between_sites(places, shares):
    x, y = np.array(places).T
    weights = np.array(shares[: x.size]) / sum(shares[: x.size])
    assert may_lie(Domain.of(x, y, NONE), weights @ x, weights @ y)


def test_over_a_raster_it_may_lie_as_far_as_the_cells_reach():
    along = np.arange(5) * 4.0
    x, y = (each.ravel() for each in np.meshgrid(along, along))
    domain = Domain.of(x, y, NONE)
    assert domain.spacing == 4.0
    assert domain.box.tolist() == [-2.0, 18.0, -2.0, 18.0]
    assert domain.region(x, y).area == pytest.approx(20.0**2)
    assert may_lie(domain, 17.9, -1.9)
    assert not may_lie(domain, 18.1, 8.0)


def test_sites_on_one_line_have_the_mean_distance_and_the_line():
    x = np.array([0.0, 2.0, 3.0, 11.0, 12.0])
    domain = Domain.of(x, 2.0 * x, NONE)
    assert domain.spacing == pytest.approx(np.hypot(12.0, 24.0) / 4.0, abs=0.01)
    assert may_lie(domain, 7.0, 14.0)
    assert not may_lie(domain, 7.0, 24.0)


def test_the_surface_is_told_near_sites_alone():
    x = np.array([0.0, 2.0, 3.0, 31.0, 32.0])
    domain = Domain.of(x, 0.0 * x, NONE)
    assert domain.speaks_of(np.array([3.0, 17.0]), np.zeros(2)).tolist() == [True, False]


@pytest.mark.parametrize("seed", range(3))
def test_a_nodule_in_a_hole_between_scattered_sites_is_in_its_ellipse(seed):
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-0.03, 0.03, (2, 150))
    true = np.array([0.010, 0.004])
    outside = np.hypot(x - true[0], y - true[1]) > 0.0045
    x, y = x[outside], y[outside]
    squared = ((x - true[0]) ** 2 + (y - true[1]) ** 2) / 0.005**2
    k = 400.0 * (1.0 + 0.5**squared) * (1.0 + 0.02 * rng.standard_normal(x.size))
    found = map_of(Sites(x, y, np.zeros_like(x), None, k, 0.02 * k))
    (one,) = (each for each in found.inclusions if each.probability >= 0.9)
    off = np.array([one.x, one.y]) - true
    assert off @ np.linalg.solve(one.covariance, off) < 13.8  # one in a thousand is farther
