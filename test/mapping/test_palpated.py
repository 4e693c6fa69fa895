"""Which announced sites make the grid of a map."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.palpated_sites import PalpatedSites
from tissue_probe.signals import PalpationSite, Phase


def announced(*scans):
    """Sites of several scans, each a sequence of (number, (x, y) in mm)."""
    sites = PalpatedSites()
    for scan in scans:
        for number, (x, y) in scan:
            for phase in Phase:
                sites.add(PalpationSite(0, number, (1e-3 * x, 1e-3 * y, 0.0), phase))
    return sites


def raster(spacing, rows, columns, x=0.0, y=0.0):
    """The scan of a grid, lengths in mm."""
    grid = Grid((x, y, 0.0), spacing, rows, columns)
    return [(site, grid.position(site)[:2]) for site in range(len(grid))]


@given(
    spacing=st.sampled_from([0.5, 1.0, 3.0, 10.0]),
    rows=st.integers(2, 6),
    columns=st.integers(2, 6),
    x=st.integers(-50, 50),
    heard=st.integers(1, 36),
)
def test_a_scan_has_the_grid_of_the_sites_announced_so_far(spacing, rows, columns, x, heard):
    whole = raster(spacing, rows, columns, x=x)
    grid, cells = announced(whole[:heard]).cells()
    assert len(cells) == min(heard, rows * columns)
    if heard > columns:
        assert grid.spacing == pytest.approx(1e-3 * spacing)
        assert grid.columns == columns
    for number, (x, y) in whole[:heard]:
        row, column = cells[(round(1e-3 * x, 9), round(1e-3 * y, 9))]
        assert (grid.x[column], grid.y[row]) == pytest.approx((1e-3 * x, 1e-3 * y), abs=1e-9)
        assert number < heard


def test_some_sites_palpated_again_stay_on_the_grid_of_all():
    whole = raster(3.0, 4, 4)
    grid, cells = announced(whole, [whole[3], whole[9]]).cells()
    assert grid.shape == (4, 4)
    assert len(cells) == 16


def test_sites_palpated_again_need_lie_on_no_grid_of_their_own():
    whole = raster(3.0, 1, 6)
    grid, cells = announced(whole, [whole[0], whole[2], whole[5]]).cells()
    assert grid.shape == (1, 6)
    assert len(cells) == 6


def test_one_site_palpated_again_stays_on_the_grid_of_all():
    whole = raster(3.0, 4, 4)
    grid, _ = announced(whole, [whole[5]], [whole[5]]).cells()
    assert grid.shape == (4, 4)


def test_a_finer_grid_between_the_sites_keeps_the_coarse_ones():
    grid, cells = announced(raster(10.0, 3, 3), raster(5.0, 5, 5)).cells()
    assert grid.spacing == pytest.approx(0.005)
    assert len(cells) == 25


@pytest.mark.parametrize(
    "other",
    [raster(3.0, 4, 4), raster(10.0, 3, 3, x=4.0), raster(7.0, 2, 2, x=1.0)],
    ids=["finer, no part", "shifted", "incommensurable"],
)
def test_a_scan_on_another_grid_begins_the_map_anew(other):
    grid, cells = announced(raster(10.0, 3, 3), other).cells()
    assert len(cells) == len(other)
    assert grid == announced(other).cells()[0]


def test_scans_before_one_on_another_grid_are_no_part_of_the_map():
    first, other = raster(10.0, 2, 2), raster(3.0, 2, 2, x=1.0)
    _, cells = announced(first, other, first).cells()
    assert len(cells) == 4
    assert (0.001, 0.0) not in cells


def test_sites_on_no_square_grid_are_refused():
    with pytest.raises(ValueError, match="no square grid"):
        announced([(0, (0.0, 0.0)), (1, (3.0, 0.0)), (2, (7.1, 0.0))]).cells()


def test_without_any_site_there_is_no_grid():
    with pytest.raises(ValueError, match="no positions"):
        PalpatedSites().cells()


def test_a_surface_measured_beside_the_given_one_is_the_same_site_of_the_same_scan():
    sites = PalpatedSites()
    for number, x in enumerate([0.0, 0.01]):
        sites.add(PalpationSite(0, number, (x, 0.0, 0.0), Phase.APPROACH))
        for phase in (Phase.DWELL, Phase.LIFTED):  # half a millimetre lower along a tilted normal
            sites.add(PalpationSite(0, number, (x + 0.0003, 0.0, -0.0004), phase))
    grid, cells = sites.cells()
    assert set(cells) == {(0.0003, 0.0), (0.0103, 0.0)}
    assert grid.origin == pytest.approx((0.0003, 0.0, -0.0004))
    assert sites.count >= 2
