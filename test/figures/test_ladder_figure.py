"""The picture of the ladder: errors per step on a logarithmic axis, falling to the noise."""

from io import BytesIO

import numpy as np
import pytest

from tissue_probe.figures.ladder import Rungs, draw_ladder, wrap_name

MODELS = ("Kelvin-Voigt", "+ cubic_stiffening", "+ coulomb_friction")
TRAINING, HELDOUT, NOISE = (0.043, 0.012, 0.00503), (0.048, 0.0131, 0.0052), 5e-3


def lines(axes):
    return {line.get_label(): line.get_ydata() for line in axes.lines}


def test_errors_stand_in_millinewtons_over_the_names_of_the_steps():
    (axes,) = draw_ladder(Rungs(MODELS, TRAINING, HELDOUT, NOISE)).axes
    drawn = lines(axes)
    np.testing.assert_allclose(drawn["fitted data"], 1e3 * np.array(TRAINING))
    np.testing.assert_allclose(drawn["held-out data"], 1e3 * np.array(HELDOUT))
    assert axes.get_yscale() == "log"
    assert axes.get_ylabel() == "rms error [mN]"
    labels = [label.get_text().replace("\n", "") for label in axes.get_xticklabels()]
    assert labels == [MODELS[0], MODELS[1], MODELS[2]]


def test_the_noise_is_a_line_within_the_axes():
    (axes,) = draw_ladder(Rungs(MODELS, TRAINING, HELDOUT, NOISE)).axes
    assert set(lines(axes)["noise, 5 mN"]) == {5.0}
    low, high = axes.get_ylim()
    assert low < 5.0 < 48.0 < high


def test_each_step_tells_its_distance_to_the_noise():
    (axes,) = draw_ladder(Rungs(MODELS, TRAINING, HELDOUT, NOISE)).axes
    assert [text.get_text() for text in axes.texts] == ["9.6×", "2.62×", "1.04×"]


@pytest.mark.parametrize("count", [1, 3, 9])
def test_the_legend_hides_no_mark_and_no_number(count):
    errors = np.geomspace(NOISE, 0.1, count)
    figure = draw_ladder(Rungs(["+ force_bias"] * count, errors, errors, NOISE))
    figure.draw_without_rendering()
    (axes,) = figure.axes
    legend = axes.get_legend().get_window_extent()
    assert not any(legend.overlaps(text.get_window_extent()) for text in axes.texts)
    assert legend.y0 >= axes.get_window_extent().y1
    assert 0.0 <= legend.x0 < legend.x1 <= figure.bbox.x1


def test_without_held_out_data_the_fitted_datas_error_is_told():
    (axes,) = draw_ladder(Rungs(MODELS[:1], TRAINING[:1], [np.nan], NOISE)).axes
    assert [text.get_text() for text in axes.texts] == ["8.6×"]


@pytest.mark.parametrize("kind", ["png", "svg"])
@pytest.mark.parametrize("count", [1, 3, 9])
def test_any_number_of_steps_can_be_drawn(count, kind):
    names = [f"+ exponential_stiffening_{n}" for n in range(count)]
    errors = np.geomspace(0.1, 5e-3, count)
    draw_ladder(Rungs(names, errors, errors, NOISE)).savefig(BytesIO(), format=kind)


@pytest.mark.parametrize(("names", "errors"), [((), ()), (MODELS, (0.1,))])
def test_steps_without_their_errors_are_refused(names, errors):
    with pytest.raises(ValueError, match="one of each for every step"):
        Rungs(names, errors, errors, NOISE)


def test_an_error_is_told_off_the_mark_of_the_other_data():
    (axes,) = draw_ladder(Rungs(MODELS[:2], (0.04, 0.02), (0.05, 0.01), NOISE)).axes
    above, below = axes.texts
    assert above.get_va() == "bottom"
    assert below.get_va() == "top"


@pytest.mark.parametrize(
    ("room", "lines"),
    [
        (30, ["+ load_cell_stiffness_error"]),
        (14, ["+ load_cell_", "stiffness_", "error"]),
        (6, ["+", "load_", "cell_", "stiffness_", "error"]),
    ],
)
def test_a_long_name_is_broken_at_its_underscores(room, lines):
    assert wrap_name("+ load_cell_stiffness_error", room).split("\n") == lines
