"""The picture of the map: what is drawn, where, and in which unit."""

from io import BytesIO

import numpy as np
import pytest
from matplotlib.patches import Circle, Rectangle

from tissue_probe.figures.stiffness_map import draw_map
from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.regions import Region
from tissue_probe.mapping.stiffness_map import StiffnessMapData
from tissue_probe.mapping.verdict import Verdict

GRID = Grid((0.0, 0.0, 0.0), 0.01, rows=3, columns=4)
NODULES = [(0.01, 0.02, 0.003), (0.03, 0.0, 0.005)]
FOUND = [Region(0.011, 0.019, 1200.0, 3.0, 2.66, 1e-4)]


def map_with_gaps(*unmeasured, verdicts=()):
    stiffness = 450.0 + 10.0 * np.arange(12.0).reshape(3, 4)
    verdict = np.full(GRID.shape, Verdict.MEASURED, dtype=np.uint8)
    for cell in unmeasured:
        stiffness[cell], verdict[cell] = np.nan, Verdict.NOT_PALPATED
    for cell, why in dict(verdicts).items():
        verdict[cell] = why
        if why != Verdict.DISTURBED:
            stiffness[cell] = np.nan
    scaled = (stiffness / by for by in (90.0, 1e4, 1e3, 1e4))
    return StiffnessMapData(GRID, 1, stiffness, *scaled, verdict)


def panels(figure):
    return figure.axes[:3]


def patches(axes, kind):
    return [patch for patch in axes.patches if isinstance(patch, kind)]


def test_each_panel_shows_its_quantity_with_its_unit():
    figure = draw_map(map_with_gaps())
    labels = [axes.get_xlabel() for axes in figure.axes[3:]]
    assert labels == ["stiffness k [N/m]", "damping β [N s/m]", "covariance trace, mixed units"]
    assert [axes.get_xlabel() for axes in panels(figure)] == ["x [mm]"] * 3
    assert figure.axes[0].get_ylabel() == "y [mm]"


def test_the_surface_lies_over_the_sites_in_millimetres():
    figure = draw_map(map_with_gaps())
    (image,) = figure.axes[0].images
    assert image.get_extent() == pytest.approx([-5.0, 35.0, -5.0, 25.0])
    assert image.origin == "lower"
    surface = image.get_array()
    assert surface[5, 5] == pytest.approx(450.0, abs=2.0)
    assert surface[5, 35] == pytest.approx(480.0, abs=2.0)
    assert surface[25, 5] == pytest.approx(530.0, abs=2.0)


def test_the_colours_span_the_cells_of_each_quantity():
    stiffness, damping, _ = (axes.images[0] for axes in panels(draw_map(map_with_gaps())))
    assert stiffness.get_clim() == pytest.approx((450.0, 560.0))
    assert damping.get_clim() == pytest.approx((5.0, 560.0 / 90.0))


def test_a_uniform_map_does_not_blow_up_its_noise():
    values = np.full((3, 4), 450.0)
    values[0, 0] = 450.1
    measured = np.full((3, 4), Verdict.MEASURED, dtype=np.uint8)
    data = StiffnessMapData(GRID, 1, values, values, values, values / 1e3, values / 1e3, measured)
    low, high = draw_map(data).axes[0].images[0].get_clim()
    assert high - low == pytest.approx(45.01)


def test_palpated_sites_are_dotted_and_the_others_hatched():
    figure = draw_map(map_with_gaps((0, 3), (2, 1)))
    for axes in panels(figure):
        (sites,) = axes.lines
        assert len(sites.get_xdata()) == 10
        hatched = patches(axes, Rectangle)
        assert {patch.get_hatch() for patch in hatched} == {"///"}
        centres = {tuple(np.round(patch.get_center())) for patch in hatched}
        assert centres == {(30.0, 0.0), (10.0, 20.0)}
    assert "not palpated" in [text.get_text() for text in figure.legends[0].get_texts()]


@pytest.mark.parametrize(
    ("why", "mark", "meaning"),
    [
        (Verdict.NO_ESTIMATE, "N", "no estimate"),
        (Verdict.NOT_CONVERGED, "U", "unsure: not converged"),
        (Verdict.NO_CONTACT, "A", "in air: no contact"),
        (Verdict.MODEL_REJECTED, "R", "rejected: the model is wrong"),
        (Verdict.DISTURBED, "D", "measured, disturbed by another force"),
    ],
)
def test_a_letter_tells_why_a_palpated_cell_is_not_simply_measured(why, mark, meaning):
    figure = draw_map(map_with_gaps(verdicts={(1, 2): why}))
    for axes in panels(figure):
        (letter,) = (text for text in axes.texts if text.get_text() == mark)
        assert letter.xy == pytest.approx((20.0, 10.0))
        without = [patch.get_center() for patch in patches(axes, Rectangle)]
        assert len(without) == (why != Verdict.DISTURBED)
        assert not any(patch.get_hatch() for patch in patches(axes, Rectangle))
    assert meaning in [text.get_text() for text in figure.legends[0].get_texts()]


def test_true_nodules_are_circles_of_their_depth():
    for axes in panels(draw_map(map_with_gaps(), nodules=NODULES)):
        circles = patches(axes, Circle)
        assert [circle.get_center() for circle in circles] == [(10.0, 20.0), (30.0, 0.0)]
        assert [circle.get_radius() for circle in circles] == [3.0, 5.0]


def test_found_nodules_are_crossed_and_told_with_their_ratio():
    figure = draw_map(map_with_gaps(), FOUND, NODULES)
    for axes in panels(figure):
        (cross,) = (line for line in axes.lines if line.get_marker() == "x")
        assert cross.get_xydata()[0] == pytest.approx((11.0, 19.0))
    assert [text.get_text() for text in figure.axes[0].texts] == ["3 mm", "5 mm", "2.7×"]


def test_the_legend_names_only_what_is_drawn():
    figure = draw_map(map_with_gaps())
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["site measured"]


def test_an_empty_map_says_so_and_can_be_saved():
    nothing = np.full((3, 4), np.nan)
    figure = draw_map(StiffnessMapData(GRID, 0, *[nothing] * 5, np.zeros((3, 4), np.uint8)))
    assert len(figure.axes) == 3
    for axes in figure.axes:
        assert "nothing measured" in axes.get_title()
        assert len(patches(axes, Rectangle)) == 12
    picture = BytesIO()
    figure.savefig(picture, format="png")
    assert picture.getvalue().startswith(b"\x89PNG")
