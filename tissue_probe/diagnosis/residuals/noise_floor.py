"""The white noise in a channel, estimated from the channel alone: a right model's residual.

Contents: its standard deviation.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from tissue_probe.errors import MeasurementError
from tissue_probe.signals import FloatArray, IntArray

#: Samples to a window within which the force counts as smooth, and the degree that is smooth.
SMOOTH_WINDOW, SMOOTH_DEGREE = 12, 7
#: A channel's noise is that of rounding alone below so many steps: from there on it changes from
#: sample to sample also at rest. Or it is that of arithmetic, below such a share of the span.
NOISY, EXACT = 0.6, 1e-6
#: Likeness with the force from which a rough position is motion, and not noise.
FELT = 0.3
#: Likeness by chance, times the root of the number of samples: that of white noises has a standard
#: deviation of 2.25, from 64 samples to 4000, and four of them are not met by chance.
BY_CHANCE = 9.0
#: Windows that tell the noise well enough where each needs a projection of its own.
ENOUGH_WINDOWS = 10_000


def noise_floor(
    force: FloatArray, position: FloatArray | None = None, numbers: IntArray | None = None
) -> float:
    """Estimate the standard deviation of the white noise in a force, from the force alone.

    Of any other channel likewise, ``position`` being its input.

    A polynomial of degree p = 7 is taken out of every n = 12 consecutive samples. Of white noise
    it leaves a sum of squares RSS ~ sigma^2 chi^2(n - p - 1), so that

        sigma^2 = median over windows of RSS / median of chi^2(n - p - 1)

    The median passes over windows with an impact, an outlier or a slip in them, as long as most
    have none: where contact or play rattles at 60 Hz, too much is found. Noise of quantisation
    counts; a force that comes in steps has at least step / sqrt(12).

    Where the motion itself is too quick for such polynomials (probing step by step), their residual
    of the force is no noise as far as a cubic of the position leaves the same; with the position
    given it is taken out, if that lowers the floor.

    Parameters
    ----------
    force : array, shape (N,)
        Evenly sampled force [N]; N >= 12, finite. Of a sine at a 16th of the sample rate
        (125 Hz at 2 kHz) 6e-5 of the amplitude passes for noise, at a 33rd 2e-7.
    position : array, shape (N,), optional
        Where each sample was taken [m].
    numbers : array of int, shape (N,), optional
        Which samples these are, where some between them are left out; ascending.

    Returns
    -------
    float
        Standard deviation [N]; of white noise on 4000 samples right to 2 % (one sigma).

    Raises
    ------
    MeasurementError
        If there are too few samples, or some are not finite.

    Notes
    -----
    Local residuals: T. Gasser, L. Sroka, C. Jennen-Steinmetz, "Residual variance and residual
    pattern in nonlinear regression", Biometrika 73 (1986), 625-633, there with a straight line
    through three samples. Scale by a median: P. Rousseeuw, C. Croux, JASA 88 (1993), 1273.
    """
    steps = np.diff(np.unique(force))
    step = steps.min() if steps.size else 0.0
    return float(max(noise_beside_steps(force, position, numbers), step / np.sqrt(12.0)))


def noise_beside_steps(
    force: FloatArray, position: FloatArray | None = None, numbers: IntArray | None = None
) -> float:
    """Estimate the same, but none where the values of most windows are equal (see ``noise_floor``).

    A channel that rests between a few quick motions seems to come in steps, and does not.
    """
    from tissue_probe.diagnosis.chance import chi_squared_median

    force = np.asarray(force, dtype=np.float64)
    if force.size < SMOOTH_WINDOW or not np.isfinite(force).all():
        raise MeasurementError(
            f"the noise of {force.size} samples cannot be estimated; give at least "
            f"{SMOOTH_WINDOW}, all finite"
        )
    rough = _roughness(np.arange(force.size) if numbers is None else numbers)
    left = [rough(force)]
    if position is not None and np.ptp(position) > 0:
        at = (position - np.mean(position)) / np.ptp(position)
        moved = np.stack([rough(at**power).ravel() for power in (1, 2, 3)], axis=1)
        told = moved @ np.linalg.lstsq(moved, left[0].ravel(), rcond=None)[0]
        left.append(left[0] - told.reshape(left[0].shape))
    squares = min(float(np.median(np.sum(each**2, axis=1))) for each in left)
    return float(np.sqrt(squares / chi_squared_median(left[0].shape[1])))


def noise_not_felt(position: FloatArray, force: FloatArray) -> tuple[float, float]:
    """Estimate the white noise of a position where the force feels least of the motion.

    Noise of a position is not felt by a force; a motion that is too quick for the samples is, and
    so is a corner between two samples. So the windows count in which the force is the smoother
    half, see ``noise_beside_steps``.

    Returns
    -------
    float
        Standard deviation [unit of the position]; 0 where most windows' values are equal.
    float
        How alike the two channels are there beyond a polynomial, from -1 to 1: the median.
    """
    from tissue_probe.diagnosis.chance import chi_squared_median

    rough = _roughness(np.arange(position.size))
    left, right = rough(position), rough(force)
    felt = np.linalg.norm(right, axis=1)
    quiet = felt <= np.median(felt)
    left, right, felt = left[quiet], right[quiet], felt[quiet]
    sizes = np.linalg.norm(left, axis=1)
    noise = np.sqrt(np.median(sizes**2) / chi_squared_median(left.shape[1]))
    known = sizes * felt > 0.0
    alike = np.sum(left * right, axis=1)[known] / (sizes * felt)[known]
    return float(noise), float(np.median(alike)) if known.any() else 0.0


def _roughness(numbers: IntArray) -> Callable[[FloatArray], FloatArray]:
    """Return the projection of windows onto the residual of a polynomial, (windows, n - p - 1)."""
    windows = sliding_window_view(numbers, SMOOTH_WINDOW)
    steps = np.diff(numbers)
    if steps.min() == steps.max():
        rough = _left_by_polynomial(windows[0])
        return lambda values: sliding_window_view(values, SMOOTH_WINDOW) @ rough
    few = slice(None, None, 1 + len(windows) // ENOUGH_WINDOWS)
    each = _left_by_polynomial(windows[few])
    return lambda values: np.einsum(
        "wn,wnr->wr", sliding_window_view(values, SMOOTH_WINDOW)[few], each
    )


def _left_by_polynomial(times: IntArray) -> FloatArray:
    """Return an orthonormal basis, (..., n, n - p - 1), orthogonal to polynomials of times."""
    first, last = times[..., :1], times[..., -1:]
    at = (2.0 * times - first - last) / (last - first)
    powers = at[..., np.newaxis] ** np.arange(SMOOTH_WINDOW)
    return np.linalg.qr(powers)[0][..., SMOOTH_DEGREE + 1 :]
