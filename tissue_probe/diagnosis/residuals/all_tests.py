"""All tests of a residual, which judge the model that left it.

Contents: tests of measured minus predicted output that need no model.
"""

from __future__ import annotations

from tissue_probe.diagnosis.residuals.drive_tests import drive_correlation, rate_correlation
from tissue_probe.diagnosis.residuals.level_tests import amplitude, level, offset, outliers
from tissue_probe.diagnosis.residuals.line_tests import line_tests
from tissue_probe.diagnosis.residuals.memory_tests import ljung_box, whiteness
from tissue_probe.diagnosis.residuals.residual_test import ResidualTest, check_signals
from tissue_probe.quantities import FORCE, Quantity, other
from tissue_probe.signals import FloatArray


def residual_tests(
    residual: FloatArray,
    drive: FloatArray,
    sample_period: float,
    noise: float,
    output: Quantity = FORCE,
) -> tuple[ResidualTest, ...]:
    """Put every test to a residual.

    Parameters
    ----------
    residual : array, shape (N,)
        Measured minus predicted output, evenly sampled; N >= 64, finite.
    drive : array, shape (N,)
        The input: displacement u of the coil [m], or a force [N] whose answer is the position.
    sample_period : float
        Time between two samples [s].
    noise : float
        Standard deviation of the output's white noise, positive; see `noise_floor`.
    output : Quantity
        The predicted channel.

    Returns
    -------
    tuple of ResidualTest
        A right model with white noise fails each once in 1000 recordings.

    Raises
    ------
    ValueError
        If the arrays differ in length, are too short or not finite, or the noise is not positive.
    """
    residual, drive = check_signals(noise, residual, drive)
    record = (residual, drive, sample_period)
    return (
        level(residual, noise),
        offset(*record, output),
        whiteness(residual),
        ljung_box(residual),
        drive_correlation(*record, other(output)),
        rate_correlation(*record, other(output)),
        *line_tests(*record, noise, output),
        amplitude(*record, noise),
        outliers(residual),
    )
