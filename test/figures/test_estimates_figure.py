"""The picture of the estimates: what is drawn, over which time, and within which limits."""

import warnings
from io import BytesIO

import numpy as np
import pytest

from tissue_probe.figures.estimates import draw_estimates
from tissue_probe.signals import (
    TEXT,
    PalpationSite,
    Phase,
    Recording,
    SampleBlock,
    Status,
    TissueEstimates,
)

SECOND = 1_000_000_000
START = 1_700_000_000 * SECOND
TRUTH = np.array([[450.0, 5.0], [900.0, 10.0]])
RATE = 200


def recording():
    """Two sites, each 0.5 s of approach, 1.5 s of contact."""
    sites = []
    for site in range(2):
        begin = START + 2 * site * SECOND
        for offset, phase in ((0, Phase.APPROACH), (SECOND // 2, Phase.DWELL)):
            sites.append(PalpationSite(begin + offset, site, (0.0, 0.0, 0.0), phase))
    sites.append(PalpationSite(START + 4 * SECOND, 1, (0.0, 0.0, 0.0), Phase.LIFTED))
    time = np.arange(8000) / 2000
    force = np.sin(2 * np.pi * 10 * time)
    block = SampleBlock(START, 0, 1 / 2000, 0.001 * force, force, 0.0 * force)
    return Recording((block,), tuple(sites))


def estimates(name="ekf", startup=-2000.0):
    """From 0.1 s after contact on, the truth of each site; before, a transient."""
    time = np.arange(4 * RATE) / RATE
    contact = time % 2.0 - 0.5
    truth = TRUTH[(time // 2.0).astype(int)]
    settled = contact >= 0.1
    status = np.where(settled, Status.CONVERGED, Status.CONVERGING)
    status = np.where(contact < 0.0, Status.NO_CONTACT, status)
    zeros = np.zeros(time.size)
    return TissueEstimates(
        estimator=name,
        stamp=START + np.rint(time * SECOND).astype(np.int64),
        sequence=np.arange(time.size),
        stiffness=np.where(settled, truth[:, 0], startup),
        damping=np.where(settled, truth[:, 1], startup / 50.0),
        covariance_trace=np.where(settled, 0.01, 1e6),
        stiffness_variance=np.full(time.size, 9.0),
        damping_variance=np.full(time.size, 0.04),
        stiffness_damping_covariance=zeros,
        force_offset=zeros,
        predicted_force=np.sin(2 * np.pi * 10 * time),
        innovation=np.where(np.arange(time.size) % 2, 0.004, -0.004),
        normalized_innovation_squared=zeros,
        status=status.astype(np.uint8),
        model=np.full(time.size, "kelvin_voigt", TEXT),
    )


def panels(figure):
    """Left and right column of axes, from top to bottom."""
    axes = figure.axes
    return axes[0:8:2], axes[1:8:2]


def lines(axes, label):
    return [line for line in axes.lines if line.get_label() == label]


def test_every_axis_names_its_quantity_and_unit():
    left, right = panels(draw_estimates(recording(), [estimates()], TRUTH))
    assert [axes.get_ylabel() for axes in left] == [
        "stiffness k [N/m]",
        "damping β [N s/m]",
        "covariance trace, mixed units",
        "force [N]",
    ]
    assert right[3].get_ylabel() == "rms force error [mN]"
    assert left[3].get_xlabel() == right[3].get_xlabel() == "time [s]"


def test_the_left_shows_the_first_second_of_the_chosen_dwell():
    left, _ = panels(draw_estimates(recording(), [estimates()], TRUTH, dwell=1))
    assert left[0].get_title().startswith("First 1 s at site 1")
    assert left[3].get_xlim() == pytest.approx((0.0, 1.0))
    (line,) = lines(left[0], "ekf")
    time, stiffness = line.get_data()
    assert (time[0], time[-1]) == pytest.approx((0.0, 1.0 - 1 / RATE))
    assert stiffness[-1] == 900.0


def test_the_right_shows_the_whole_scan_with_its_sites():
    figure = draw_estimates(recording(), [estimates()], TRUTH)
    _, right = panels(figure)
    assert right[3].get_xlim() == pytest.approx((0.0, 4.0))
    spans = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in right[0].patches]
    assert np.ravel(spans) == pytest.approx([0.5, 2.0, 2.5, 4.0])
    (numbers,) = right[0].child_axes
    assert [label.get_text() for label in numbers.get_xticklabels()] == ["0", "1"]


def test_nothing_is_drawn_where_there_was_no_contact():
    _, right = panels(draw_estimates(recording(), [estimates()], TRUTH))
    for axes in right[:3]:
        time, values = lines(axes, "ekf")[0].get_data()
        assert np.isnan(values[time % 2.0 < 0.5]).all()
        assert np.isfinite(values[time % 2.0 > 0.61]).all()


def test_what_a_filter_believes_between_dwells_is_not_drawn():
    believer = estimates()
    believer.status[:] = Status.CONVERGED
    _, right = panels(draw_estimates(recording(), [believer], TRUTH))
    time, values = lines(right[0], "ekf")[0].get_data()
    assert np.isnan(values[time % 2.0 < 0.5]).all()
    assert np.isfinite(values[time % 2.0 >= 0.5]).all()


def test_the_band_is_two_standard_deviations_to_either_side():
    left, _ = panels(draw_estimates(recording(), [estimates()], TRUTH))
    for axes, value, stddev in ((left[0], 450.0, 3.0), (left[1], 5.0, 0.2)):
        (band,) = axes.collections
        edge = np.vstack([path.vertices for path in band.get_paths()])
        at_the_end = edge[edge[:, 0] > 0.5, 1]
        assert at_the_end.min() == pytest.approx(value - 2 * stddev)
        assert at_the_end.max() == pytest.approx(value + 2 * stddev)


def test_true_values_are_dotted_over_each_dwell():
    _, right = panels(draw_estimates(recording(), [estimates()], TRUTH))
    for axes, values in zip(right, TRUTH.T, strict=False):
        dotted = lines(axes, "true")
        assert [line.get_ydata()[0] for line in dotted] == list(values)
        assert {line.get_linestyle() for line in dotted} == {":"}


def test_without_a_truth_none_is_drawn_or_named():
    figure = draw_estimates(recording(), [estimates()])
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["ekf", "measured"]


def test_a_start_up_transient_does_not_set_the_limits():
    left, right = panels(draw_estimates(recording(), [estimates()], TRUTH))
    for axes, highest in ((left[0], 450.0), (left[1], 5.0), (right[0], 900.0), (right[1], 10.0)):
        low, high = axes.get_ylim()
        assert -0.5 * highest < low <= 0.0
        assert highest < high < 1.5 * highest


def test_estimates_that_never_converge_are_still_within_the_limits():
    never = estimates(startup=300.0)
    never.status[never.status == Status.CONVERGED] = Status.MODEL_REJECTED
    left, _ = panels(draw_estimates(recording(), [never]))
    low, high = left[0].get_ylim()
    assert low < 300.0 < 450.0 < high


def test_measured_and_predicted_force_share_one_panel():
    left, _ = panels(draw_estimates(recording(), [estimates()], TRUTH))
    (measured,) = lines(left[3], "measured")
    (predicted,) = lines(left[3], "ekf")
    assert measured.get_xdata().size == 2000
    assert predicted.get_xdata().size == RATE
    np.testing.assert_allclose(
        np.interp(predicted.get_xdata(), *measured.get_data()), predicted.get_ydata(), atol=1e-9
    )


def test_the_force_error_is_its_root_mean_square_in_millinewtons():
    _, right = panels(draw_estimates(recording(), [estimates()], TRUTH))
    values, edges, _ = right[3].patches[0].get_data()
    in_contact = (edges[:-1] % 2.0) >= 0.5 - 1e-9
    assert values[in_contact] == pytest.approx(4.0)
    assert np.isnan(values[~in_contact]).all()


def test_a_line_is_thin_until_its_estimator_has_converged():
    left, _ = panels(draw_estimates(recording(), [estimates()], TRUTH))
    startup, settled = left[0].lines[:2]
    assert startup.get_linewidth() < 0.5 * settled.get_linewidth()
    assert startup.get_ydata()[0] == -2000.0
    assert np.isnan(settled.get_ydata()[0])


def test_every_estimator_has_its_own_colour():
    names = ["ekf", "ukf", "afekf"]
    left, _ = panels(draw_estimates(recording(), [estimates(name) for name in names], TRUTH))
    drawn = [lines(left[0], name)[0] for name in names]
    assert len({line.get_color() for line in drawn}) == 3


def test_a_recording_without_sites_is_drawn_from_its_beginning():
    whole = Recording(recording().blocks)
    left, right = panels(draw_estimates(whole, [estimates()]))
    assert left[0].get_title().startswith("First second;")
    assert left[3].get_xlim() == pytest.approx((0.0, 1.0))
    assert not right[0].patches


def test_a_picture_without_estimates_can_be_saved_without_a_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        picture = BytesIO()
        draw_estimates(recording(), []).savefig(picture, format="png")
    assert picture.getvalue().startswith(b"\x89PNG")


def test_an_empty_recording_is_refused():
    with pytest.raises(ValueError, match="no samples"):
        draw_estimates(Recording(()), [])


def test_a_truth_of_the_wrong_length_is_refused():
    with pytest.raises(ValueError, match="2 dwells"):
        draw_estimates(recording(), [estimates()], TRUTH[:1])


def test_a_dwell_that_does_not_exist_is_refused():
    with pytest.raises(IndexError):
        draw_estimates(recording(), [estimates()], TRUTH, dwell=2)
