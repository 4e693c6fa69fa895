"""A sensor's straight line: its readings under known loads or at known places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from tissue_probe.signals import FloatArray

#: Two numbers of a line, and at least one reading more to know how well it fits.
FEWEST_POINTS = 3
CONFIDENCE = 0.95
#: So many standard deviations hold 95 % of a normal distribution, either way.
CONFIDENCE_QUANTILE = float(stats.norm.ppf(0.5 + CONFIDENCE / 2.0))

Interval = tuple[float, float]


@dataclass(frozen=True)
class CalibrationLine:
    """reading = intercept + known / scale, with 95 % confidence intervals.

    ``scale`` is in known units for each unit of reading, so the factor of a reading; ``residuals``
    are the readings minus the line, shape (n,).
    """

    scale: float
    scale_interval: Interval
    intercept: float
    intercept_interval: Interval
    residuals: FloatArray


def fit_line(known: FloatArray, readings: FloatArray) -> CalibrationLine:
    """Fit readings, in which alone is error, to known values by least squares.

    Parameters
    ----------
    known : array, shape (n,)
        Forces, displacements: any unit.
    readings : array, shape (n,)
        The sensor's reading of each: any unit.

    Returns
    -------
    Line
        Intervals by Student's t with n - 2 degrees of freedom.

    Raises
    ------
    ValueError
        If there are fewer than three points, the known values do not differ, or the readings do
        not certainly follow them.
    """
    if known.size < FEWEST_POINTS:
        raise ValueError(f"there are {known.size} readings: give at least {FEWEST_POINTS}")
    if np.ptp(known) == 0.0:
        raise ValueError(f"every reading is at {known[0]:g}: give readings at different values")
    fit = stats.linregress(known, readings)
    quantile = stats.t.ppf(0.5 + CONFIDENCE / 2.0, known.size - 2)
    low, high = fit.slope - quantile * fit.stderr, fit.slope + quantile * fit.stderr
    # With readings all alike the interval is no number.
    if not (low > 0.0 or high < 0.0):
        raise ValueError(
            "the readings do not follow the known values: check the order of the recordings, and "
            "the wiring"
        )
    spread = quantile * fit.intercept_stderr
    return CalibrationLine(
        scale=float(1.0 / fit.slope),
        scale_interval=(float(1.0 / high), float(1.0 / low)),
        intercept=float(fit.intercept),
        intercept_interval=(float(fit.intercept - spread), float(fit.intercept + spread)),
        residuals=readings - fit.intercept - fit.slope * known,
    )
