"""Stiff regions: found where they are, and not where they are not."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.regions import Background, Region, find_regions, match
from tissue_probe.mapping.stiffness_map import StiffnessMapData
from tissue_probe.mapping.verdict import Verdict
from tissue_probe.physics.phantom import Phantom

GRID = Grid((0.0, 0.0, 0.0), 0.01, rows=5, columns=5)


def map_of(stiffness, stddev=0.3):
    layer = np.where(np.isnan(stiffness), np.nan, 1.0)
    verdict = np.where(np.isnan(stiffness), Verdict.NOT_PALPATED, Verdict.MEASURED).astype(np.uint8)
    return StiffnessMapData(GRID, 1, stiffness, layer, layer, stddev * layer, layer, verdict)


def tissue(*nodules, seed=0, noise=0.3):
    x, y = np.meshgrid(GRID.x, GRID.y)
    stiffness = 450.0 + noise * np.random.default_rng(seed).standard_normal((5, 5))
    for centre_x, centre_y, excess in nodules:
        squared = (x - centre_x) ** 2 + (y - centre_y) ** 2
        stiffness += 450.0 * excess * np.exp(-squared / 0.006**2)
    return stiffness


def region_at(x, y):
    return Region(x, y, 900.0, 1.0, 2.0, 1e-4)


def test_nodules_are_found_at_their_places_the_stiffest_first():
    found = find_regions(map_of(tissue((0.01, 0.03, 1.2), (0.03, 0.01, 1.8))))
    assert len(found) == 2
    assert (found[0].x, found[0].y) == pytest.approx((0.03, 0.01), abs=0.001)
    assert (found[1].x, found[1].y) == pytest.approx((0.01, 0.03), abs=0.001)
    assert found[0].ratio == pytest.approx(2.8, rel=0.05)
    assert found[0].stiffness == pytest.approx(2.8 * 450.0, rel=0.05)
    assert 0.005 < found[0].diameter < 0.02


def test_a_nodule_between_two_sites_is_found_once_and_between_them():
    (found,) = find_regions(map_of(tissue((0.015, 0.02, 2.0))))
    assert (found.x, found.y) == pytest.approx((0.015, 0.02), abs=0.001)


def test_a_nodule_on_the_border_is_found():
    (found,) = find_regions(map_of(tissue((0.04, 0.04, 1.5))))
    assert (found.x, found.y) == pytest.approx((0.04, 0.04), abs=0.002)


@pytest.mark.parametrize("seed", range(10))
def test_uniform_tissue_has_no_regions(seed):
    assert find_regions(map_of(tissue(seed=seed))) == []


@pytest.mark.parametrize("seed", range(10))
def test_scatter_as_large_as_its_stated_uncertainty_is_no_nodule(seed):
    assert find_regions(map_of(tissue(seed=seed, noise=100.0), stddev=100.0)) == []


def test_a_soft_spot_is_no_nodule():
    assert find_regions(map_of(tissue((0.02, 0.02, -0.7)))) == []


def test_a_peak_that_is_not_certain_is_no_nodule():
    stiffness = tissue((0.02, 0.02, 1.5))
    assert len(find_regions(map_of(stiffness, stddev=1.0))) == 1
    assert find_regions(map_of(stiffness, stddev=400.0)) == []


def test_half_a_map_shows_the_nodule_that_was_visited():
    stiffness = tissue((0.01, 0.01, 1.5), (0.03, 0.03, 1.5))
    stiffness[3:] = np.nan
    (found,) = find_regions(map_of(stiffness))
    assert (found.x, found.y) == pytest.approx((0.01, 0.01), abs=0.001)


def test_an_empty_map_has_no_regions_and_no_background():
    empty = np.full((5, 5), np.nan)
    assert find_regions(map_of(empty)) == []
    with pytest.raises(ValueError, match="no cell"):
        Background.of(empty)


def test_the_background_ignores_the_nodules_and_what_they_do_to_their_neighbours():
    stiffness = tissue((0.01, 0.03, 1.8), (0.03, 0.01, 1.8))
    assert np.median(stiffness) > 453.0
    assert Background.of(stiffness).stiffness == pytest.approx(450.0, abs=1.0)


def test_the_spread_of_the_background_is_that_of_its_cells():
    cells = 450.0 + 20.0 * np.random.default_rng(2).standard_normal((50, 50))
    assert Background.of(cells).stddev == pytest.approx(20.0, rel=0.1)


def test_every_nodule_of_the_default_phantom_is_found():
    phantom = Phantom.load(Path(__file__).parents[2] / "config" / "phantom.yaml")
    found = find_regions(map_of(phantom.stiffness(*np.meshgrid(GRID.x, GRID.y))))
    result = match(found, [(n.x, n.y) for n in phantom.nodules], tolerance=0.003)
    assert len(result.pairs) == 3
    assert (result.missed, result.false) == ((), ())


def test_a_match_names_pairs_missed_and_false():
    found = [region_at(0.031, 0.01), region_at(0.0, 0.04)]
    result = match(found, [(0.01, 0.01), (0.03, 0.01)], tolerance=0.005)
    assert result.pairs == ((0, 1, pytest.approx(0.001)),)
    assert result.missed == (0,)
    assert result.false == (1,)


def test_a_match_prefers_more_pairs_to_nearer_ones():
    found = [region_at(0.000, 0.0), region_at(0.004, 0.0)]
    result = match(found, [(0.001, 0.0), (-0.004, 0.0)], tolerance=0.005)
    assert {pair[:2] for pair in result.pairs} == {(0, 1), (1, 0)}


places = st.lists(st.tuples(st.floats(0.0, 0.04), st.floats(0.0, 0.04)), max_size=5)


@given(places, places, st.floats(1e-4, 0.05))
def test_every_region_and_every_nodule_is_accounted_for_once(found, true, tolerance):
    result = match([region_at(x, y) for x, y in found], true, tolerance)
    assert sorted([p[0] for p in result.pairs] + list(result.false)) == list(range(len(found)))
    assert sorted([p[1] for p in result.pairs] + list(result.missed)) == list(range(len(true)))
    assert all(distance <= tolerance for _, _, distance in result.pairs)
