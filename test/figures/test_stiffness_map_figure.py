"""The picture of the map: what is drawn, where, and in which unit."""

from io import BytesIO

import numpy as np
import pytest
from matplotlib.patches import Circle

from tissue_probe.figures.stiffness_map import draw_map
from tissue_probe.mapping.posterior.posterior_map import map_of
from tissue_probe.mapping.posterior.results import PosteriorMap
from tissue_probe.mapping.sites import Sites


def mapped(excess=1.0, missing=False) -> tuple[PosteriorMap, Sites]:
    x, y = (each.ravel() for each in np.meshgrid(np.arange(7) * 0.006, np.arange(6) * 0.006))
    k = 450.0 * (1.0 + excess * 0.5 ** (((x - 0.018) ** 2 + (y - 0.012) ** 2) / 0.005**2))
    k[-1] = np.nan if missing else k[-1]
    sites = Sites(x, y, np.zeros_like(x), None, k, 0.01 * np.where(np.isnan(k), 1.0, k))
    return map_of(sites, raster=0.001), sites


def panels(figure):
    return figure.axes[:3]


def test_each_panel_shows_its_quantity_with_its_unit():
    figure = draw_map(*mapped())
    labels = [axes.get_xlabel() for axes in figure.axes[3:]]
    assert labels == [
        "stiffness k [N/m]",
        "P(inclusion)",
        "could hide, 1.5 times stiffer: radius [mm]",
    ]
    assert [axes.get_xlabel() for axes in panels(figure)] == ["x [mm]"] * 3
    assert figure.axes[0].get_ylabel() == "y [mm]"


def test_the_surface_lies_where_the_sites_are_in_millimetres():
    found, sites = mapped()
    (image,) = draw_map(found, sites).axes[0].images
    left, right, bottom, _ = image.get_extent()
    assert (left, bottom) == pytest.approx((-3.5, -3.5))
    assert right - left == pytest.approx(43.0)
    surface = image.get_array()
    peak = np.unravel_index(surface.argmax(), surface.shape)
    assert left + 0.5 + peak[1] == pytest.approx(18.0, abs=1.0)
    assert bottom + 0.5 + peak[0] == pytest.approx(12.0, abs=1.0)


def test_plain_tissue_does_not_look_like_mountains():
    low, high = draw_map(*mapped(excess=0.0)).axes[0].images[0].get_clim()
    assert high - low >= 0.09 * high


def test_an_inclusion_is_outlined_and_told_in_each_panel():
    found, sites = mapped()
    figure = draw_map(found, sites)
    for axes in panels(figure):
        styles = [line.get_linestyle() for line in axes.lines]
        assert {"-", ":"} <= set(styles)
    (text,) = figure.axes[0].texts
    assert text.xy == pytest.approx((18.0, 12.0), abs=1.0)
    assert text.get_text().startswith("2.")


def test_true_nodules_are_dashed_circles_of_their_radius():
    figure = draw_map(*mapped(), nodules=[(0.018, 0.012, 0.005)])
    for axes in panels(figure):
        (circle,) = (patch for patch in axes.patches if isinstance(patch, Circle))
        assert circle.get_center() == (18.0, 12.0)
        assert circle.get_radius() == 5.0


def test_a_site_without_a_value_is_crossed_out():
    figure = draw_map(*mapped(missing=True))
    for axes in panels(figure):
        (crosses,) = (line for line in axes.lines if line.get_marker() == "x")
        assert crosses.get_xydata() == pytest.approx(np.array([[36.0, 30.0]]))
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "site unknown" in legend


def test_the_legend_names_only_what_is_drawn_and_the_picture_can_be_saved():
    figure = draw_map(*mapped(excess=0.0))
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["site measured"]
    picture = BytesIO()
    figure.savefig(picture, format="png")
    assert picture.getvalue().startswith(b"\x89PNG")
