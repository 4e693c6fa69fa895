"""The picture of a comparison: both forces, the error, and where it is marked "here"."""

from io import BytesIO
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from tissue_probe.diagnosis.residuals.localise import localise
from tissue_probe.figures.compare import _title, draw_comparison
from tissue_probe.quantities import FORCE

PERIOD, NOISE = 5e-4, 5e-3
TIME = PERIOD * np.arange(4000)
POSITION = 1e-3 * np.sin(2 * np.pi * 9.7 * TIME)
PREDICTED = 800.0 * POSITION


def draw(louder, factor=6.0):
    residual = NOISE * np.random.default_rng(0).standard_normal(TIME.size)
    residual = residual * np.where(louder, factor, 1.0)
    found = localise(residual, POSITION, POSITION, PERIOD, NOISE)
    return draw_comparison(TIME, PREDICTED + residual, PREDICTED, found, NOISE)


def panels(figure):
    """Return the four panels of signals, and the six of quantities by their first word."""
    signals, where = figure.axes[:4], figure.axes[4:]
    return signals, {axes.get_title().split()[0]: axes for axes in where}


def words(axes):
    return [text.get_text() for text in axes.texts]


def marks(axes):
    """Return where regions begin and end, in order along the axis."""
    regions = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
    return sorted(
        x for patch in regions for x in (patch.get_x(), patch.get_x() + patch.get_width())
    )


LATE = (TIME > 1.0) & (TIME < 1.3)


def test_there_are_four_panels_of_signals_and_six_of_quantities():
    signals, where = panels(draw(LATE))
    assert len(signals) == 4
    assert list(where) == ["time", "frequency", "indentation", "speed", "direction", "phase"]
    assert signals[0].get_ylabel() == "force [N]"
    assert signals[2].get_ylabel() == "error [mN]"


def test_measured_predicted_and_error_are_what_was_given():
    signals, _ = panels(draw(LATE))
    lines = {line.get_label(): line.get_ydata() for line in [*signals[0].lines, *signals[2].lines]}
    np.testing.assert_array_equal(lines["predicted"], PREDICTED)
    np.testing.assert_allclose(
        lines["measured − predicted"], 1e3 * (lines["measured"] - PREDICTED), atol=1e-9
    )


def test_the_magnified_panel_shows_a_few_cycles_where_the_error_is_largest():
    signals, _ = panels(draw(LATE))
    begin, end = signals[1].get_xlim()
    assert 0.9 < begin < end < 1.4
    assert end - begin == pytest.approx(3.0 / 9.7, abs=0.02)


def test_the_magnified_panel_keeps_to_the_time_that_stands_out():
    slow = 0.1 * (TIME > 1.9)  # in the error as drawn, not in what is left with slow noise out
    evened = NOISE * np.random.default_rng(0).standard_normal(TIME.size) * np.where(LATE, 6.0, 1.0)
    found = localise(evened, POSITION, POSITION, PERIOD, NOISE)
    figure = draw_comparison(TIME, PREDICTED + evened + slow, PREDICTED, found, NOISE)
    begin, end = panels(figure)[0][1].get_xlim()
    assert 0.85 < begin < end < 1.45


def test_the_error_in_the_title_is_of_the_samples_that_were_used_and_of_the_record_named():
    found = localise(NOISE * np.ones(TIME.size), POSITION, POSITION, PERIOD, NOISE)
    measured = PREDICTED + np.where(LATE, 1.0, NOISE)
    figure = draw_comparison(
        TIME, measured, PREDICTED, found, NOISE, used=~LATE, name="second of two"
    )
    assert figure.get_suptitle().startswith("second of two\nError 5 mN rms")


def test_the_region_is_marked_here_and_named_in_the_title():
    figure = draw(LATE)
    _, where = panels(figure)
    assert words(where["time"])[0].startswith("here: ")
    assert marks(where["time"]) == pytest.approx([1.0, 1.3], abs=0.06)
    assert "Where most: time" in figure.get_suptitle()


def test_a_region_through_180_degrees_is_marked_at_both_ends():
    away = np.abs(np.rad2deg(np.angle(np.exp(2j * np.pi * 9.7 * TIME - 0.5j * np.pi)))) > 150.0
    _, where = panels(draw(away))
    assert marks(where["phase"]) == pytest.approx([-180.0, -150.0, 150.0, 180.0], abs=10.0)


def test_noise_is_marked_nowhere_and_lies_at_one():
    figure = draw(np.zeros(TIME.size, dtype=bool))
    _, where = panels(figure)
    assert not any(words(axes) for axes in where.values())
    assert "No region stands out" in figure.get_suptitle()
    heights = where["time"].patches[0].get_data().values
    assert np.nanmean(heights) == pytest.approx(1.0, abs=0.05)


def test_the_title_tells_the_error_in_newtons_of_the_force_and_of_the_noise():
    title = draw(np.ones(TIME.size, dtype=bool), factor=4.0).get_suptitle()
    assert "Error 20 mN rms: 3.52 % of the force, 3.99 times the noise of 5 mN" in title


def test_the_share_counts_the_forces_offset_as_the_printed_one_does():
    force = np.full(8, 2.0)
    title = _title(force, force - 0.02, SimpleNamespace(here=None), 0.005, FORCE)
    assert "1 % of the force, 4 times the noise" in title


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_it_can_be_saved_as_picture_and_drawing(kind):
    file = BytesIO()
    draw(LATE).savefig(file, format=kind, dpi=100)
    data = file.getvalue()
    if kind == "png":
        width = int.from_bytes(data[16:20], "big")
        assert width == 1200
    else:
        assert ElementTree.fromstring(data).tag.endswith("svg")


def test_a_record_without_motion_is_drawn():
    still, noise = np.zeros(4000), NOISE * np.random.default_rng(0).standard_normal(4000)
    found = localise(noise, still, still, PERIOD, NOISE)
    draw_comparison(TIME, noise, still, found, NOISE).savefig(BytesIO())
