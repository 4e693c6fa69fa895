"""A sensor's line, and how sure of it one may be."""

from __future__ import annotations

import numpy as np
import pytest

from tissue_probe.identification.line import fit_line

LOADS = np.array([0.0, 0.5, 1.0, 2.0, 4.0])


def test_an_exact_line_is_found_exactly():
    line = fit_line(LOADS, -0.02 + 0.5 * LOADS)
    assert line.scale == pytest.approx(2.0)
    assert line.intercept == pytest.approx(-0.02)
    assert np.abs(line.residuals).max() < 1e-12


def test_readings_that_fall_give_a_negative_scale():
    line = fit_line(LOADS, 0.1 - 0.5 * LOADS)
    assert line.scale == pytest.approx(-2.0)
    assert line.scale_interval[0] <= line.scale <= line.scale_interval[1]


def test_the_intervals_hold_the_truth_as_often_as_they_say():
    rng = np.random.default_rng(1)
    hits = np.zeros(2)
    for _ in range(400):
        line = fit_line(LOADS, -0.02 + 0.5 * LOADS + 0.01 * rng.standard_normal(LOADS.size))
        hits += [
            line.scale_interval[0] <= 2.0 <= line.scale_interval[1],
            line.intercept_interval[0] <= -0.02 <= line.intercept_interval[1],
        ]
    assert np.all(hits / 400 > 0.92)
    assert np.all(hits / 400 < 0.98)


@pytest.mark.parametrize(
    ("known", "readings", "said"),
    [
        ([0.0, 1.0], [0.0, 1.0], "2 readings: give at least 3"),
        ([1.0, 1.0, 1.0], [0.0, 1.0, 2.0], "every reading is at 1"),
        ([0.0, 1.0, 2.0], [0.5, 0.5, 0.5], "do not follow the known values"),
        ([0.0, 1.0, 2.0], [0.0, 1.0, 0.0], "do not follow the known values"),
    ],
)
def test_what_is_no_calibration_is_refused(known, readings, said):
    with pytest.raises(ValueError, match=said):
        fit_line(np.array(known), np.array(readings))
