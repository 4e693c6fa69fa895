"""The grid: where its sites are, and how they are numbered."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.mapping.grid import MAXIMUM_SITES, Grid

grids = st.builds(
    Grid,
    origin=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
    spacing=st.floats(1e-4, 0.1),
    rows=st.integers(1, 12),
    columns=st.integers(1, 12),
)


def test_sites_run_in_serpentine_order():
    grid = Grid((0.0, 0.0, 0.0), 0.01, rows=3, columns=3)
    cells = [grid.cell(site) for site in range(len(grid))]
    assert cells == [(0, 0), (0, 1), (0, 2), (1, 2), (1, 1), (1, 0), (2, 0), (2, 1), (2, 2)]


@given(grids)
def test_consecutive_sites_are_one_spacing_apart(grid):
    positions = [grid.position(site) for site in range(len(grid))]
    for here, there in pairwise(positions):
        assert math.dist(here, there) == pytest.approx(grid.spacing)


@given(grids)
def test_site_and_cell_are_inverse(grid):
    cells = [grid.cell(site) for site in range(len(grid))]
    assert len(set(cells)) == len(grid)
    assert [grid.site(*cell) for cell in cells] == list(range(len(grid)))


@given(grids, st.floats(-0.49, 0.49), st.floats(-0.49, 0.49), st.data())
def test_a_position_within_half_a_spacing_of_a_site_falls_into_its_cell(grid, dx, dy, data):
    site = data.draw(st.integers(0, len(grid) - 1))
    x, y, z = grid.position(site)
    near = (x + dx * grid.spacing, y + dy * grid.spacing, z + 1.0)
    assert grid.nearest(near) == grid.cell(site)


def test_coordinates_of_rows_and_columns_agree_with_positions():
    grid = Grid((0.1, 0.2, 0.3), 0.01, rows=2, columns=3)
    row, column = grid.cell(4)
    assert grid.position(4) == pytest.approx((grid.x[column], grid.y[row], 0.3))


@pytest.mark.parametrize(
    "position", [(0.016, 0.0), (0.0, -0.006), (math.nan, 0.0), (math.inf, 0.0)]
)
def test_a_position_off_the_grid_is_refused(position):
    with pytest.raises(ValueError, match="outside the grid"):
        Grid((0.0, 0.0, 0.0), 0.01, rows=2, columns=2).nearest(position)


@pytest.mark.parametrize("site", [-1, 4])
def test_a_site_that_does_not_exist_is_refused(site):
    with pytest.raises(IndexError, match="4 sites"):
        Grid((0.0, 0.0, 0.0), 0.01, rows=2, columns=2).cell(site)


@pytest.mark.parametrize(("row", "column"), [(-1, 0), (0, 2), (2, 0)])
def test_a_cell_that_does_not_exist_is_refused(row, column):
    with pytest.raises(IndexError, match="no cell"):
        Grid((0.0, 0.0, 0.0), 0.01, rows=2, columns=2).site(row, column)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"origin": (0.0, math.nan, 0.0)}, "lengths in m"),
        ({"origin": (0.0, 0.0)}, "three"),
        ({"spacing": 0.0}, "spacing is 0.0 m"),
        ({"spacing": math.inf}, "finite"),
        ({"rows": 0}, "rows is 0"),
        ({"columns": -1}, "columns is -1"),
        ({"rows": MAXIMUM_SITES, "columns": 2}, "at most"),
    ],
)
def test_parameters_out_of_range_are_refused(changed, message):
    valid = {"origin": (0.0, 0.0, 0.0), "spacing": 0.01, "rows": 5, "columns": 5}
    with pytest.raises(ValueError, match=message):
        Grid(**{**valid, **changed})


@given(grids)
def test_the_grid_through_its_sites_has_a_cell_at_each(grid):
    positions = [grid.position(site) for site in range(len(grid))]
    through = Grid.through(positions)
    if len(grid) > 1:
        assert through.shape == grid.shape
        assert through.spacing == pytest.approx(grid.spacing, abs=2e-9)
    for site, position in enumerate(positions):
        assert through.nearest(position) == grid.cell(site)


def test_the_grid_through_some_sites_leaves_room_for_those_between():
    assert Grid.through([(0.0, 0.0, 0.0), (0.01, 0.0, 0.0), (0.04, 0.02, 0.0)]).shape == (3, 5)


@pytest.mark.parametrize(
    ("positions", "message"),
    [
        ([], "no positions"),
        ([(0.0, 0.0, 0.0), (0.01, 0.0, 0.0), (0.025, 0.0, 0.0)], "no square grid"),
    ],
)
def test_positions_on_no_grid_are_refused(positions, message):
    with pytest.raises(ValueError, match=message):
        Grid.through(positions)
