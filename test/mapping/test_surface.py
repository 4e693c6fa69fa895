"""The surface through the cells, and its uncertainty."""

import numpy as np
import pytest

from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.surface import POINTS_PER_SPACING, interpolate

GRID = Grid((0.0, 0.0, 0.0), 0.01, rows=5, columns=5)
AT_CELLS = slice(POINTS_PER_SPACING // 2, None, POINTS_PER_SPACING)


def smooth(x, y):
    return 450.0 + 600.0 * np.exp(-((x - 0.02) ** 2 + (y - 0.01) ** 2) / 0.015**2)


def test_the_surface_passes_through_accurate_cells():
    values = smooth(*np.meshgrid(GRID.x, GRID.y))
    surface = interpolate(GRID, values, np.full((5, 5), 0.3))
    np.testing.assert_allclose(surface.x[AT_CELLS], GRID.x)
    np.testing.assert_allclose(surface.mean[AT_CELLS, AT_CELLS], values, atol=1.0)
    assert surface.stddev[AT_CELLS, AT_CELLS].max() < 0.31


def test_the_uncertainty_grows_away_from_the_cells():
    values = smooth(*np.meshgrid(GRID.x, GRID.y))
    surface = interpolate(GRID, values, np.full((5, 5), 0.3))
    at_cell = POINTS_PER_SPACING // 2
    between = at_cell + POINTS_PER_SPACING // 2
    assert surface.stddev[between, between] > 10 * surface.stddev[at_cell, at_cell]


def test_noise_of_stated_size_is_smoothed_away_and_not_believed():
    rng = np.random.default_rng(3)
    surface = interpolate(GRID, 450.0 + 20.0 * rng.standard_normal((5, 5)), np.full((5, 5), 20.0))
    assert np.abs(surface.mean - 450.0).max() < 20.0
    assert surface.stddev.max() < 20.0


def test_the_uncertainty_covers_the_error_between_the_cells():
    rng = np.random.default_rng(5)
    scores = []
    for _ in range(20):
        centre = rng.uniform(0.0, 0.04, size=2)

        def truth(x, y, centre=centre):
            squared = (x - centre[0]) ** 2 + (y - centre[1]) ** 2
            return 450.0 + 600.0 * np.exp(-squared / 0.01**2)

        surface = interpolate(GRID, truth(*np.meshgrid(GRID.x, GRID.y)), np.full((5, 5), 0.3))
        error = surface.mean - truth(*np.meshgrid(surface.x, surface.y))
        scores.append(np.mean(np.abs(error) < 2.0 * surface.stddev + 1.0))
    assert np.mean(scores) > 0.9


def test_unmeasured_cells_are_left_out_and_uncertain():
    values = smooth(*np.meshgrid(GRID.x, GRID.y))
    values[4, 4] = np.nan
    surface = interpolate(GRID, values, np.where(np.isnan(values), np.nan, 0.3))
    assert np.isfinite(surface.mean).all()
    unmeasured = surface.stddev[AT_CELLS, AT_CELLS][4, 4]
    assert unmeasured > 100 * surface.stddev[AT_CELLS, AT_CELLS][0, 0]


def test_one_measured_cell_says_little_about_the_rest():
    values = np.full((5, 5), np.nan)
    values[2, 2] = 450.0
    surface = interpolate(GRID, values, np.full((5, 5), 0.3))
    np.testing.assert_allclose(surface.mean, 450.0, atol=1e-6)
    assert surface.stddev[0, 0] > 50.0


@pytest.mark.parametrize("level", [0.0, 450.0])
def test_equal_cells_without_noise_give_a_flat_surface(level):
    surface = interpolate(GRID, np.full((5, 5), level), np.zeros((5, 5)))
    np.testing.assert_allclose(surface.mean, level, atol=1e-3)


@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (5, 1)])
def test_a_grid_of_one_row_or_column_has_a_surface_too(shape):
    grid = Grid((0.0, 0.0, 0.0), 0.01, *shape)
    surface = interpolate(grid, np.full(shape, 450.0), np.full(shape, 0.3))
    assert surface.mean.shape == (surface.y.size, surface.x.size)
    assert surface.x[[0, -1]] == pytest.approx([-0.005, grid.x[-1] + 0.005])
    assert surface.step == pytest.approx(0.01 / POINTS_PER_SPACING)


def test_a_map_without_measured_cells_is_refused():
    with pytest.raises(ValueError, match="no cell"):
        interpolate(GRID, np.full((5, 5), np.nan), np.full((5, 5), np.nan))


@pytest.mark.parametrize("stddev", [-1.0, np.nan])
def test_a_value_without_standard_deviation_is_refused(stddev):
    with pytest.raises(ValueError, match="standard deviation"):
        interpolate(GRID, np.full((5, 5), 450.0), np.full((5, 5), stddev))
