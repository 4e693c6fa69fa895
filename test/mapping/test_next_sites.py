"""The next sites: where they tell most, never where they may not be."""

from functools import cache

import numpy as np
import pytest

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.exploration.choice import Travel, next_sites
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.felt_surface import sums_at
from tissue_probe.mapping.posterior.posterior_sample import Sampled
from tissue_probe.mapping.posterior.prior import MOST_INCLUSIONS, PARAMETERS
from tissue_probe.mapping.sites import Sites

AREA = Polygon(np.array([(0.0, 0.0), (0.04, 0.0), (0.04, 0.04), (0.0, 0.04)]))
EVERYWHERE = Travel(speed=1e6)  # the way costs nothing


def sites(x, y, k, t=None):
    x, y, k = (np.array(each, dtype=float) for each in (x, y, k))
    return Sites(x, y, 0 * x, t, k, 0.001 * k)


def felt(x, y, nodule=(0.02, 0.02), contrast=2.5, radius=0.006):
    excess = 0.5 ** (((x - nodule[0]) ** 2 + (y - nodule[1]) ** 2) / radius**2)
    rng = np.random.default_rng(len(x))
    return 450.0 * (1.0 + (contrast - 1.0) * excess) * (1.0 + 0.01 * rng.standard_normal(len(x)))


@cache
def left_half_felt():
    """A raster of 5 mm over the left half of plain tissue; nothing is known of the right one."""
    x, y = (
        each.ravel() for each in np.meshgrid(np.arange(0, 0.021, 0.005), np.linspace(0, 0.04, 9))
    )
    return Sampled.of(sites(x, y, felt(x, y, contrast=1.0)), AREA)


def distances(chosen):
    places = np.array([(one.x, one.y) for one in chosen])
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    return apart[np.triu_indices(len(chosen), 1)]


def test_sites_go_where_nothing_was_felt():
    chosen = next_sites(left_half_felt(), 6, AREA, travel=EVERYWHERE)
    assert all(one.x > 0.022 for one in chosen)
    assert all(one.gain > 0.0 for one in chosen)


def test_several_sites_are_several_places():
    chosen = next_sites(left_half_felt(), 6, AREA, travel=EVERYWHERE)
    assert distances(chosen).min() > 0.002


def test_a_site_that_is_pending_is_not_chosen_again():
    (first,) = next_sites(left_half_felt(), 1, AREA, travel=EVERYWHERE)
    (second,) = next_sites(
        left_half_felt(), 1, AREA, pending=[(first.x, first.y)], travel=EVERYWHERE
    )
    assert np.hypot(first.x - second.x, first.y - second.y) > 0.003


def test_a_doubtful_nodule_is_probed_again_beside_where_it_was_felt():
    """One site of nine is stiff: an outlier, a peak, or the flank of something."""
    x, y = (each.ravel() for each in np.meshgrid(*[[0.006, 0.02, 0.034]] * 2))
    sampled = Sampled.of(sites(x, y, felt(x, y, nodule=(0.022, 0.021))), AREA)
    chosen = next_sites(sampled, 3, AREA, travel=EVERYWHERE)
    assert min(np.hypot(one.x - 0.022, one.y - 0.021) for one in chosen) < 0.008


def one_nodule_felt(x, y):
    return sites(x, y, felt(x, y, nodule=(0.012, 0.012), radius=0.006))


def test_what_hangs_on_one_site_is_palpated_again_first_and_once():
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(0.002, 0.038, 6)] * 2))
    k = felt(x, y, contrast=1.0)
    k[14] *= 2.0
    sampled = Sampled.of(sites(x, y, k), AREA)
    first, second = next_sites(sampled, 2, AREA)
    assert first.purpose == "again"
    assert 0.0 < np.hypot(first.x - x[14], first.y - y[14]) < 0.004
    assert second.purpose != "again"
    (after,) = next_sites(sampled, 1, AREA, pending=[(first.x, first.y)])
    assert after.purpose != "again"


def test_sites_are_chosen_for_the_edge_for_what_is_unseen_or_for_both_in_turn():
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(0.004, 0.02, 5)] * 2))
    sampled = Sampled.of(one_nodule_felt(x, y), AREA)
    chosen = {p: next_sites(sampled, 4, AREA, purpose=p) for p in ("edge", "find", "both")}
    assert [one.purpose for one in chosen["edge"]] == ["edge"] * 4
    assert [one.purpose for one in chosen["find"]] == ["find"] * 4
    assert {one.purpose for one in chosen["both"]} == {"edge", "find"}
    # Where nothing was felt, and apart from one another.
    places = np.array([(one.x, one.y) for one in chosen["find"]])
    assert (places.max(axis=1) > 0.024).all()
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    assert apart[np.triu_indices(4, 1)].min() > 0.006


def test_another_purpose_is_refused():
    with pytest.raises(ParameterError, match="give one of edge, find, both"):
        next_sites(left_half_felt(), 1, AREA, purpose="all")


def test_no_site_is_outside_the_area_nor_in_a_zone():
    triangle = Polygon(np.array([(0.0, 0.0), (0.04, 0.0), (0.04, 0.04)]))
    zone = Polygon(np.array([(0.025, 0.0), (0.04, 0.0), (0.04, 0.02), (0.025, 0.02)]))
    chosen = next_sites(left_half_felt(), 30, triangle, no_go=[zone])
    x, y = (np.array([getattr(one, name) for one in chosen]) for name in "xy")
    assert triangle.contains(x, y).all()
    assert not zone.contains(x, y).any()


def test_a_place_that_was_not_reached_is_not_proposed():
    unreachable = []
    for _ in range(4):
        (one,) = next_sites(left_half_felt(), 1, AREA, unreachable=unreachable)
        unreachable.append((one.x, one.y))
    places = np.array(unreachable)
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    assert apart[np.triu_indices(4, 1)].min() >= 0.003


def test_of_places_that_tell_as_much_a_slow_probe_takes_the_nearest():
    ways = []
    for travel in (EVERYWHERE, Travel(speed=1e-4)):
        starts = [(0.04, 0.0), (0.04, 0.02), (0.04, 0.04)]
        chosen = [next_sites(left_half_felt(), 1, AREA, start=s, travel=travel)[0] for s in starts]
        ways.append([np.hypot(c.x - x, c.y - y) for c, (x, y) in zip(chosen, starts, strict=True)])
    assert (np.array(ways[1]) <= ways[0]).all()
    assert sum(ways[1]) < sum(ways[0])


def test_a_revisit_tells_drift_from_a_stiff_place():
    """The first site is stiffer: it was felt early, or lies over an inclusion.

    To feel it again tells which. Where no drift can be, there is no such doubt, as long as no site
    is an outlier.
    """
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(0.004, 0.036, 4)] * 2))
    k = felt(x, y, nodule=(x[0], y[0]), contrast=1.35, radius=0.005)
    elsewhere = [
        Polygon(np.array([(a, b), (c, b), (c, d), (a, d)]))
        for a, b, c, d in (
            (-1.0, -1.0, x[0] - 1e-4, 1.0), (x[0] + 1e-4, -1.0, 1.0, 1.0),
            (-1.0, -1.0, 1.0, y[0] - 1e-4), (-1.0, y[0] + 1e-4, 1.0, 1.0),
        )
    ]  # fmt: skip
    gains = []
    for times in (1.5 * np.arange(16.0), None):
        sampled = Sampled.of(sites(x, y, k, times), AREA, outliers=0.0)
        (again,) = next_sites(sampled, 1, AREA, no_go=elsewhere)
        assert (again.x, again.y) == pytest.approx((x[0], y[0]))
        gains.append(again.gain)
    assert gains[0] > 1.2 * gains[1]


def test_the_same_sites_have_the_same_next_ones():
    assert next_sites(left_half_felt(), 3, AREA) == next_sites(left_half_felt(), 3, AREA)


@pytest.mark.parametrize("count", [0, 101])
def test_a_number_of_sites_out_of_range_is_refused(count):
    with pytest.raises(ParameterError, match="from 1 to 100"):
        next_sites(left_half_felt(), count, AREA)


def test_an_area_that_is_all_no_go_is_refused():
    with pytest.raises(ParameterError, match="no place is left"):
        next_sites(left_half_felt(), 1, AREA, no_go=[AREA])


def test_soft_inclusions_that_overlap_between_sites_leave_some_stiffness():
    """Two that each take 70 % would take more than all: no place has a negative stiffness."""
    soft = [0.0, 0.0, np.log(5.0), np.log(0.3), np.log(2.0), 0.0, 0.0]
    rows = np.zeros((1, MOST_INCLUSIONS, PARAMETERS))
    rows[0, :2] = soft
    x = np.linspace(-10.0, 10.0, 21)
    left = sums_at(rows, np.array([2]), x, 0.0 * x)[0]
    assert left[10] == pytest.approx(0.05)
    assert left[0] == pytest.approx(1.0 - 2 * 0.7 * 2.0**-4.0)
