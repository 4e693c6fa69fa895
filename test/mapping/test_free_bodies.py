"""Bodies that no ellipse is like: each is one inclusion, with a boundary that follows it."""

import numpy as np
import pytest

from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.posterior_map import map_of
from tissue_probe.mapping.sites import Sites

ALONG = np.linspace(0.0, 0.04, 9)
X, Y = (each.ravel() for each in np.meshgrid(ALONG, ALONG))
FINE = np.linspace(0.0, 0.04, 81)
EVERYWHERE = tuple(each.ravel() for each in np.meshgrid(FINE, FINE))


def rectangle(x, y):
    return (np.abs(x - 0.02) < 0.011) & (np.abs(y - 0.02) < 0.0045)


def triangle(x, y):
    return (y > 0.012) & (y - 0.012 < 1.7 * (x - 0.009)) & (y - 0.012 < 1.7 * (0.031 - x))


def grown_together(x, y):
    return (np.hypot(x - 0.0145, y - 0.021) < 0.006) | (np.hypot(x - 0.0245, y - 0.021) < 0.006)


def sure(stiffness, seed):
    """Return the inclusions that are surely there at sites that err by 3 %."""
    rng = np.random.default_rng(seed)
    k = 450.0 * stiffness(X, Y) * (1.0 + 0.03 * rng.standard_normal(X.size))
    found = map_of(Sites(X, Y, np.zeros_like(X), None, k, 0.001 * k))
    return [one for one in found.inclusions if one.probability >= 0.9]


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("body", [rectangle, triangle, grown_together])
def test_a_body_is_one_inclusion_and_its_boundary_follows_it(body, seed):
    (one,) = sure(lambda x, y: 1.0 + body(x, y), seed)
    inside = Polygon(one.boundary_50).contains(*EVERYWHERE)
    true = body(*EVERYWHERE)
    assert 2.0 * (inside & true).sum() / (inside.sum() + true.sum()) > 0.75


def test_bodies_side_by_side_that_are_not_equally_stiff_are_two():
    def stiffness(x, y):
        left = np.hypot(x - 0.0125, y - 0.02) < 0.0065
        right = np.hypot(x - 0.0275, y - 0.02) < 0.0065
        return 1.0 + 0.8 * left + 3.0 * right

    assert len(sure(stiffness, 0)) == 2
