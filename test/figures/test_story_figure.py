"""The picture of a whole diagnosis: the base, where it fails, the ranking, the ladder."""

from io import BytesIO

import numpy as np
import pytest

from tissue_probe.diagnosis.residuals.localise import localise
from tissue_probe.figures.compare import Comparison
from tissue_probe.figures.ladder import Rungs
from tissue_probe.figures.story import TriedEffect, draw_story
from tissue_probe.quantities import POSITION

PERIOD, NOISE = 5e-4, 5e-3
TIME = PERIOD * np.arange(4000)
MOTION = 1e-3 * np.sin(2 * np.pi * 9.7 * TIME)
LATE = (TIME > 1.0) & (TIME < 1.3)
RANKING = (
    TriedEffect("cubic_stiffening", 0.012, added=True, tied=True),
    TriedEffect("hertz_contact", 0.0122, tied=True),
    TriedEffect("coulomb_friction", 0.03),
)
RUNGS = Rungs(("Kelvin-Voigt", "+ cubic_stiffening"), (0.043, 0.012), (0.045, 0.012), NOISE)
ADEQUATE = Rungs(("Kelvin-Voigt",), (NOISE,), (NOISE,), NOISE)


def compared(louder=LATE, **output):
    residual = NOISE * np.random.default_rng(0).standard_normal(TIME.size)
    residual = residual * np.where(louder, 6.0, 1.0)
    found = localise(residual, MOTION, MOTION, PERIOD, NOISE)
    return Comparison(TIME, 800.0 * MOTION + residual, 800.0 * MOTION, found, NOISE, **output)


def draw(base=None, ranking=RANKING, rungs=RUNGS, name=""):
    figure = draw_story("Missing: cubic_stiffening", base or compared(), ranking, rungs, name)
    figure.savefig(BytesIO())
    return figure


def panels(figure):
    """Return the axes by their titles; the error has none."""
    return {axes.get_title(loc="left"): axes for axes in figure.axes}


def bars(axes):
    return [bar.patches[0] for bar in axes.containers]


def numbers(axes):
    return [text.get_text() for text in axes.texts]


def overlap(figure, texts):
    """Whether two of these texts lie on one another."""
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in texts if text.get_text()]
    return any(a.overlaps(b) for n, a in enumerate(boxes) for b in boxes[:n])


def test_the_title_is_the_verdict_and_the_panels_follow_the_story():
    figure = draw()
    assert figure.get_suptitle() == "Missing: cubic_stiffening"
    assert list(panels(figure)) == [
        "1  The base model: Kelvin-Voigt",
        "",
        "Where its error lies",
        "2  Error left by each effect alone",
        "3  Effects added, and the error left",
    ]


def test_the_base_is_shown_where_its_error_stands_out_and_the_region_is_marked():
    force, error, where, *_ = draw().axes
    begin, end = error.get_xlim()
    assert 0.9 < begin < end < 1.4
    assert [line.get_label() for line in force.lines] == ["measured", "predicted"]
    assert where.get_xlabel() == "time [s]"
    assert numbers(where)[0].startswith("here: ")


def test_where_nothing_stands_out_none_is_marked_and_nothing_is_added():
    untouched = [TriedEffect(each.name, NOISE) for each in RANKING]
    figure = draw(compared(louder=False), untouched, ADEQUATE)
    assert numbers(panels(figure)["Nothing stands out"]) == []
    assert "3  Nothing is added" in panels(figure)


def test_the_error_of_the_region_is_called_what_the_comparison_calls_it():
    where = panels(draw())["Where its error lies"]
    assert where.get_ylabel() == "rms error / noise,\nknown 1/f noise taken out"


def test_no_line_is_seen_through_the_number_of_a_bar():
    axes = panels(draw())["2  Error left by each effect alone"]
    for number in axes.texts:
        assert number.get_bbox_patch().get_facecolor() == (1.0, 1.0, 1.0, 1.0)
        assert number.get_zorder() > max(line.get_zorder() for line in axes.lines)


@pytest.mark.parametrize("count", [1, 3, 9])
@pytest.mark.parametrize("ranking", [(), RANKING])
def test_the_ladders_legend_lies_between_its_title_and_its_marks(count, ranking):
    errors = np.geomspace(NOISE, 0.1, count)  # the last mark in the upper corner
    figure = draw(ranking=ranking, rungs=Rungs(["+ force_bias"] * count, errors, errors, NOISE))
    figure.draw_without_rendering()
    axes = figure.axes[-1]
    legend = axes.get_legend().get_window_extent()
    title = axes._left_title.get_window_extent()
    assert axes.get_window_extent().y1 <= legend.y0 < legend.y1 <= title.y0
    assert 0.0 <= legend.x0 < legend.x1 <= figure.bbox.x1


def test_effects_are_ranked_from_the_top_in_units_of_the_noise():
    axes = panels(draw())["2  Error left by each effect alone"]
    assert [label.get_text() for label in axes.get_yticklabels()] == [x.name for x in RANKING]
    assert axes.yaxis_inverted()
    assert numbers(axes) == ["2.4×", "2.44×", "6×"]
    ends = [bar.get_x() + bar.get_width() for bar in bars(axes)]
    np.testing.assert_allclose(ends, [2.4, 2.44, 6.0])
    assert {line.get_label(): line.get_xdata()[0] for line in axes.lines} == pytest.approx(
        {"base model": 9.0, "noise": 1.0}
    )


def test_the_chosen_effect_has_its_colour_and_those_that_cannot_be_told_apart_are_hatched():
    axes = panels(draw())["2  Error left by each effect alone"]
    chosen, tied, other = bars(axes)
    assert chosen.get_facecolor() != tied.get_facecolor() == other.get_facecolor()
    assert [bool(bar.get_hatch()) for bar in (chosen, tied, other)] == [True, True, False]
    told = [text.get_text() for text in axes.get_legend().get_texts()]
    assert told == ["chosen", "cannot be told apart", "base model", "noise"]


def test_eight_effects_are_shown_on_a_logarithmic_axis_where_errors_span_much():
    ranking = [
        TriedEffect(f"effect_{n}", error) for n, error in enumerate(np.geomspace(NOISE, 1, 9))
    ]
    axes = panels(draw(ranking=ranking))["2  Error left by each effect alone"]
    assert len(bars(axes)) == 8
    assert axes.get_xscale() == "log"


@pytest.mark.parametrize("base", [0.045, np.nan, np.inf])
def test_an_error_that_is_no_number_is_said_in_words(base):
    ranking = [TriedEffect("diverging", np.inf), TriedEffect("untried", np.nan)]
    rungs = Rungs(RUNGS.models, RUNGS.training, (base, np.inf), NOISE)
    axes = panels(draw(ranking=ranking, rungs=rungs))["2  Error left by each effect alone"]
    assert numbers(axes) == ["diverges", "not known"]
    assert [bar.get_width() for bar in bars(axes)] == [0.0, 0.0]


def test_effects_that_were_asked_for_have_no_ranking():
    figure = draw(ranking=())
    assert list(panels(figure))[-1] == "2  Effects added, and the error left"
    assert len(figure.axes) == 4


def test_of_several_records_the_one_that_is_shown_is_named_and_a_position_is_in_its_units():
    rungs = Rungs(RUNGS.models, RUNGS.training, RUNGS.heldout, NOISE, POSITION)
    figure = draw(compared(output=POSITION), rungs=rungs, name="data.csv (stretch 1 of 2)")
    position, error, *_, ladder = figure.axes
    assert position.get_ylabel() == "position [mm]"
    assert error.get_xlabel() == "time [s], data.csv (stretch 1 of 2)"
    assert ladder.get_ylabel() == "rms error [um]"


@pytest.mark.parametrize("count", [2, 5, 14])
@pytest.mark.parametrize("ranking", [(), RANKING])
def test_names_of_any_number_of_steps_stay_apart(count, ranking):
    names = ["Kelvin-Voigt", *["+ load_cell_stiffness_error"] * (count - 1)]
    errors = np.geomspace(0.1, NOISE, count)
    figure = draw(ranking=ranking, rungs=Rungs(names, errors, errors, NOISE))
    labels = figure.axes[-1].get_xticklabels()
    if labels[0].get_rotation() == 0.0:
        assert not overlap(figure, labels)


def test_long_names_of_effects_stay_apart_and_within_the_picture():
    ranking = [TriedEffect("an_effect_of_my_own_with_a_rather_long_name", 0.02)] * 8
    figure = draw(ranking=ranking)
    labels = panels(figure)["2  Error left by each effect alone"].get_yticklabels()
    assert not overlap(figure, labels)
    assert min(label.get_window_extent().x0 for label in labels) >= 0.0
