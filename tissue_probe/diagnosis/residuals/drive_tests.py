"""Whether a residual follows the drive: that of a right model is independent of the motion.

Contents: correlation with the input and its rate of change, at the same time and later.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.diagnosis.chance import normal_beyond
from tissue_probe.diagnosis.residuals.residual_test import ResidualTest, judge_test
from tissue_probe.diagnosis.transforms import correlation
from tissue_probe.quantities import Quantity
from tissue_probe.signals import FloatArray

LONGEST_RESPONSE = 0.05  # s by which a residual may follow its cause


def drive_correlation(
    residual: FloatArray, drive: FloatArray, sample_period: float, quantity: Quantity
) -> ResidualTest:
    """Test the correlation of the residual with the input, up to 50 ms earlier or later.

    ``statistic`` is the correlation coefficient of largest size; Bonferroni over the lags.
    """
    return _correlation(
        quantity.name,
        residual,
        drive,
        sample_period,
        "a linear part of the answer to the motion is missing: relaxation "
        "(standard_linear_solid, generalized_maxwell, springpot), inertia (added_mass, "
        "structural_mode), a stiffness that changes (stiffness_step, stiffness_ramp), scale "
        "(force_gain, load_cell_stiffness_error) or timing (force_lag, channel_delay)",
    )


def rate_correlation(
    residual: FloatArray, drive: FloatArray, sample_period: float, quantity: Quantity
) -> ResidualTest:
    """Test the correlation with the rate of the input, as `drive_correlation` does."""
    return _correlation(
        quantity.rate,
        residual,
        np.gradient(drive, sample_period),
        sample_period,
        "the model's damper does not take all the energy: relaxation (standard_linear_solid, "
        "generalized_maxwell, springpot), friction (coulomb_friction, stribeck_friction, "
        "bouc_wen_hysteresis), damping that grows with depth (hunt_crossley) or timing "
        "(force_lag, channel_delay; encoder_quantization looks alike)",
    )


def _correlation(
    name: str, residual: FloatArray, cause: FloatArray, sample_period: float, hint: str
) -> ResidualTest:
    """Test independence of two signals neither of which need be white.

    The sum of products then has the variance N sum over k of R_r(k) R_u(k), with the
    autocovariances R (L. Ljung, System Identification, 2nd ed. (1999), eq. 16.73).
    """
    error, moving = residual - residual.mean(), cause - cause.mean()
    size = residual.size
    most = min(round(LONGEST_RESPONSE / sample_period), size - 1)
    products = correlation(error, moving)[size - 1 - most : size + most]
    largest = int(np.argmax(np.abs(products)))
    coloured = np.sum(correlation(error, error) * correlation(moving, moving)) / size
    white = np.sum(error**2) * np.sum(moving**2) / size
    score = abs(products[largest]) / np.sqrt(max(coloured, white) or 1.0)
    scale = np.sqrt(np.sum(error**2) * np.sum(moving**2)) or 1.0
    delay = 1e3 * (largest - most) * sample_period
    return judge_test(
        name,
        products[largest] / scale,
        min(1.0, 2.0 * products.size * normal_beyond(score)),
        f"correlation with the {name} reaches {products[largest] / scale:+.2f}, "
        f"{delay:+.3g} ms after it",
        hint,
    )
