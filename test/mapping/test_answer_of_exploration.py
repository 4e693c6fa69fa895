"""The answer of an exploration: nothing is there, so many are there, or what is still open."""

from functools import cache

import numpy as np
import pytest

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.exploration.answer import Sought, answer
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.posterior_sample import Sampled
from tissue_probe.mapping.sites import Sites

SIDE = 0.04
AREA = Polygon(np.array([(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)]))


@cache
def sampled(count, *nodules, side=SIDE, noise=0.01):
    """A raster of sites; a nodule is (x, y, radius, contrast)."""
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(0.0, side, count)] * 2))
    excess = sum(
        (c - 1.0) * 0.5 ** (((x - a) ** 2 + (y - b) ** 2) / r**2) for a, b, r, c in nodules
    )
    rng = np.random.default_rng(count)
    k = 450.0 * (1.0 + excess) * (1.0 + noise * rng.standard_normal(x.size))
    return Sampled.of(Sites(x, y, 0 * x, None, k, 0.001 * k), AREA)


def test_plain_tissue_that_was_felt_everywhere_has_nothing():
    found = answer(sampled(9))
    assert found.answered
    assert found.none >= 0.95
    assert found.text.startswith("no inclusion of 4 mm or more at contrast 1.5, P ")
    assert found.open == ()


def test_plain_tissue_that_was_felt_in_a_corner_may_have_something_elsewhere():
    found = answer(sampled(5, side=0.02))
    assert not found.answered
    assert found.none < 0.95
    assert any("may be elsewhere" in each for each in found.open)


def test_two_nodules_are_two_with_their_boundaries():
    true = ((0.011, 0.012, 0.006, 2.5), (0.029, 0.027, 0.006, 2.0))
    found = answer(sampled(15, *true))
    assert found.text.startswith("two inclusions, boundaries known to 0.")
    assert "no further inclusion of 4 mm or more at contrast 1.5, P " in found.text
    assert found.answered
    assert found.none < 0.01
    assert len([one for one in found.inclusions if one.probability > 0.95]) == 2
    assert all(0.0 < one.boundary_sd < 0.001 for one in found.inclusions)


def test_a_boundary_that_is_not_known_is_open():
    one = (0.02, 0.02, 0.006, 2.5)
    found = answer(sampled(5, one), Sought(boundary=1e-5))
    assert not found.answered
    assert any("the boundary of the inclusion near (2" in each for each in found.open)


def test_a_smaller_or_weaker_inclusion_than_sought_is_nothing():
    one = (0.02, 0.02, 0.004, 2.0)
    small, weak = Sought(radius=0.008), Sought(contrast=4.0)
    assert answer(sampled(9, one), small).none > 0.95
    assert answer(sampled(9, one), weak).none > 0.95
    assert answer(sampled(9, one), Sought(radius=0.003)).none < 0.05


def test_what_is_stated_is_never_more_than_is_known():
    found = answer(sampled(5, side=0.02))
    stated = float(found.text.split("P = ")[1])
    assert stated <= found.none


def test_sites_that_no_inclusions_explain_give_no_answer():
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(0.0, SIDE, 7)] * 2))
    stiff = np.random.default_rng(3).random(49) < 0.6
    k = 450.0 * np.where(stiff, 2.0, 1.0)
    found = answer(Sampled.of(Sites(x, y, 0 * x, None, k, 0.001 * k), AREA))
    assert not found.answered
    assert any("do not explain the sites" in each for each in found.open)


def test_three_sites_tell_nothing():
    x, y, k = np.array([(0.0, 0.0, 450.0), (0.02, 0.0, 900.0), (0.0, 0.02, 440.0)]).T
    found = answer(Sampled.of(Sites(x, y, 0 * x, None, k, 0.001 * k), AREA))
    assert not found.answered
    assert found.inclusions == ()
    assert "3 sites cannot tell" in found.open[0]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"radius": 0.0}, "radius is 0.0 m"),
        ({"contrast": 1.0}, "contrast is 1.0"),
        ({"probability": 1.0}, "probability is 1.0"),
        ({"boundary": float("nan")}, "boundary is nan m"),
    ],
)
def test_a_question_out_of_range_is_refused(wrong, message):
    with pytest.raises(ParameterError, match=message):
        Sought(**wrong)
