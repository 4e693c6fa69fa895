"""How large a residual is: over the noise, on average, with the amplitude, in single samples.

Contents: tests for which the order of the samples in time hardly matters.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from tissue_probe.diagnosis.chance import (
    MEDIAN_SIZE,
    mean_is_zero,
    normal_at,
    normal_beyond,
)
from tissue_probe.diagnosis.residuals.drive import dominant_period
from tissue_probe.diagnosis.residuals.residual_test import (
    SIGNIFICANCE,
    ResidualTest,
    judge_test,
    untold,
)
from tissue_probe.diagnosis.transforms import analytic
from tissue_probe.quantities import Quantity
from tissue_probe.signals import FloatArray

#: How well the noise is known at best, as a share of it; of few samples `noise_floor` knows it to
#: one over the root of their number.
NOISE_UNCERTAINTY = 0.02
#: Amplitudes must differ by this factor before a power of the amplitude can be read from them.
AMPLITUDE_RANGE = 1.5
BATCHES = 8  # windows at least, where the residual is judged by windows
LEVEL_TERMS = 4  # constant, position, speed, acceleration
LEVEL_NEIGHBOURS = 4  # samples to either side that count with an outlier


def level(residual: FloatArray, noise: float) -> ResidualTest:
    """Test whether the residual's rms is that of the noise (sum of squares ~ chi^2(N)).

    The noise counts as known within 2 %, or as well as `noise_floor` tells it.
    """
    ratio = np.sqrt(np.mean(residual**2)) / noise
    spread = np.hypot(NOISE_UNCERTAINTY, residual.size**-0.5)
    return judge_test(
        "level",
        ratio,
        normal_beyond((ratio - 1.0) / spread),
        f"rms is {ratio:.3g} times the noise",
        "something is missing; the other tests say of which kind",
    )


def offset(
    residual: FloatArray, drive: FloatArray, sample_period: float, output: Quantity
) -> ResidualTest:
    """Test whether the residual's mean is zero: Student's t over the means of whole periods.

    Batch means, since a residual that is not white is not independent from sample to sample.
    """
    period = round(dominant_period(drive, sample_period) / sample_period)
    size = max(1, min(period, residual.size // BATCHES))
    count = residual.size // size
    means = residual[: count * size].reshape(count, size).mean(axis=1)
    mean = means.mean()
    return judge_test(
        "offset",
        mean,
        mean_is_zero(means) if means.any() else 1.0,
        f"mean is {output.tell(mean)}",
        "a force that is off by a constant (force_bias) or wanders (force_drift), tissue that "
        "relaxes under the preload (standard_linear_solid, generalized_maxwell, springpot), a "
        "force that is not symmetrical in the motion (hertz_contact, exponential_stiffening, "
        "contact_loss, adhesion), or a preload that is read wrongly (force_gain, "
        "load_cell_stiffness_error)",
    )


def amplitude(
    residual: FloatArray, position: FloatArray, sample_period: float, noise: float
) -> ResidualTest:
    """Test for a nonlinear residual within a period, and how it grows with the local amplitude.

    In windows as long as the drive's strongest period, a constant and the parts linear in position,
    speed and acceleration are taken out of the residual: a fit of stiffness and damping to the
    whole record leaves such parts of either sign. Left is a mean square q, to be compared with the
    noise, beside the amplitude A (of the position's analytic signal). ``statistic`` is the power n
    of the gamma law with mean noise^2 + c A^(2 n) that fits q best.
    """
    name = "amplitude"
    size = max(2 * LEVEL_TERMS, round(dominant_period(position, sample_period) / sample_period))
    count = residual.size // size
    if count < BATCHES:
        return untold(name, f"fewer than {BATCHES} periods of the drive")
    windows = (count, size)
    moving = position[: count * size].reshape(windows)
    envelope = np.abs(analytic(position - position.mean()))
    amplitudes = envelope[: count * size].reshape(windows).mean(axis=1)
    if np.quantile(amplitudes, 0.9) < AMPLITUDE_RANGE * np.quantile(amplitudes, 0.1):
        return untold(name, "the drive has one amplitude; vary it by a factor of two")
    squares = _not_linear(residual[: count * size].reshape(windows), moving) / noise**2
    power = _power(amplitudes / amplitudes.max(), squares)
    freedom = count * (size - LEVEL_TERMS)
    ratio = np.sqrt(squares.mean())
    return judge_test(
        name,
        power,
        normal_beyond((ratio - 1.0) / np.hypot(NOISE_UNCERTAINTY, np.sqrt(0.5 / freedom))),
        f"the nonlinear residual within a period is {ratio:.3g} times the noise and grows as "
        f"amplitude to the {power:.1f}",
        _meaning_of_power(power),
    )


def _not_linear(residual: FloatArray, position: FloatArray) -> FloatArray:
    """Return each window's mean square once its part linear in the motion is taken out."""
    speed = np.gradient(position, axis=1)
    terms = (np.ones_like(position), position, speed, np.gradient(speed, axis=1))
    columns = np.stack([term / (np.abs(term).max() or 1.0) for term in terms], axis=2)
    basis = np.linalg.qr(columns)[0]
    linear = basis @ (np.swapaxes(basis, 1, 2) @ residual[:, :, None])
    variance: FloatArray = np.sum((residual - linear[:, :, 0]) ** 2, axis=1) / (
        residual.shape[1] - LEVEL_TERMS
    )
    return variance


def _power(amplitudes: FloatArray, squares: FloatArray) -> float:
    """Return n of the mean square 1 + c A^(2 n) that fits best."""
    from scipy import optimize  # only where a drive has several amplitudes

    def deviance(parameters: FloatArray) -> float:
        log_scale, power = parameters
        mean = 1.0 + np.exp(log_scale) * amplitudes ** (2.0 * power)
        return float(np.sum(squares / mean + np.log(mean)))

    start = (np.log(max(squares.max() - 1.0, 0.1)), 1.0)
    limits = ((-20.0, 40.0), (0.0, 8.0))
    return float(optimize.minimize(deviance, start, method="L-BFGS-B", bounds=limits).x[1])


def _meaning_of_power(power: float) -> str:
    if power < 0.5:
        return (
            "hardly changed by the amplitude: friction (coulomb_friction, stribeck_friction, "
            "bouc_wen_hysteresis), backlash or encoder_interpolation"
        )
    if power < 1.5:
        return (
            "in proportion to the amplitude: contact that is lost at every amplitude "
            "(contact_loss); under a drive of many frequencies also a linear effect (relaxation, "
            "structural_mode, force_lag, channel_delay)"
        )
    return (
        "faster than the amplitude: stiffening (exponential_stiffening, hertz_contact, "
        "hunt_crossley as the square, cubic_stiffening as the cube)"
    )


def outliers(residual: FloatArray) -> ResidualTest:
    """Count samples that stand out of their neighbours; smooth motion is left aside.

    By the fourth difference, r[n-2] - 4 r[n-1] + 6 r[n] - 4 r[n+1] + r[n+2], in which a single
    sample stands highest; the limit is the height that one in a record of white noise reaches with
    `SIGNIFICANCE`, for differences of the size that the median of them all has.
    """
    rough = np.diff(residual, 4)
    usual = np.median(np.abs(rough - np.median(rough))) / MEDIAN_SIZE
    scores = np.abs(rough) / (usual or 1.0)
    peaks = scores == ndimage.maximum_filter1d(scores, 2 * LEVEL_NEIGHBOURS + 1)
    far = normal_at(0.5 * SIGNIFICANCE / residual.size)
    count = int(np.sum(peaks & (scores > far)))
    return judge_test(
        "outliers",
        count,
        min(1.0, 2.0 * residual.size * normal_beyond(scores.max())),
        f"{count} of {residual.size} samples stand alone",
        "disturbed or lost samples, a force at its limit (adc_saturation), a channel that repeats "
        "values (stuck_samples), or impacts (backlash, or contact lost and regained: contact_loss, "
        "adhesion)",
    )
