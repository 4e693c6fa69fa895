"""How a rig was driven, read from its input: the period of repetition and the frequencies.

Contents: properties of the drive that tests of a residual need.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from tissue_probe.diagnosis.transforms import correlation, peaks, periodogram
from tissue_probe.signals import FloatArray

#: A position that comes back to this, as a share of its mean square, repeats.
RETURN = 0.01
#: A frequency with this share of the strongest one's power is driven.
DRIVEN = 1e-6


@dataclass(frozen=True)
class Drive:
    """The drive, as far as its frequencies go.

    Parameters
    ----------
    repetition : float or None
        How often it repeats itself [Hz]: the frequency of a sine, the spacing of a multisine's
        lines. None if it does not, as a sweep.
    driven : array of bool, shape (N // 2,)
        Whether the drive moves at each frequency of `spectrum`.
    """

    repetition: float | None
    driven: NDArray[np.bool_]


def spectrum(values: FloatArray, sample_period: float) -> tuple[FloatArray, FloatArray]:
    """Return frequencies above 0 [Hz] and the periodogram under a Hann window, without the mean.

    Scaled so that white noise of variance s^2 has s^2 in every bin on average; a sine of amplitude
    A has N A^2 / 4 in the bins of its line together.
    """
    frequencies, power = periodogram(values, sample_period)
    return frequencies[1:], power[1:] / (2.0 * sample_period)


def drive_of(position: FloatArray, sample_period: float) -> Drive:
    """Return how a rig was driven.

    Parameters
    ----------
    position : array, shape (N,)
        Displacement u of the coil [m], or the force [N] where that drives.
    sample_period : float
        Time between two samples [s].
    """
    _, power = spectrum(position, sample_period)
    driven = ndimage.binary_dilation(power > DRIVEN * power.max(initial=0.0))
    return Drive(_repetition(position, sample_period), driven)


def _repetition(position: FloatArray, sample_period: float) -> float | None:
    """Return 1 / tau of the first tau for which u(t + tau) = u(t), from its largest multiple.

    The difference function of A. de Cheveigne and H. Kawahara, J. Acoust. Soc. Am. 111 (2002),
    1917, eq. 6, over at most half of the record.
    """
    moving = position - position.mean()
    longest = moving.size // 2
    squares = np.r_[0.0, np.cumsum(moving**2)]
    lags = np.arange(longest)
    products = correlation(moving, moving)[moving.size - 1 :][:longest]
    energy = squares[moving.size - lags] + squares[-1] - squares[lags]
    difference = (energy - 2.0 * products) / np.where(energy > 0.0, energy, 1.0)
    returns = peaks(-difference, -RETURN)
    if returns.size == 0 or difference.max() < 0.5:
        return None
    period = returns[0]
    multiple = np.rint(returns / period)
    close = np.abs(returns - multiple * period) <= 0.1 * period
    last = np.flatnonzero(close)[-1]
    before, here, after = difference[returns[last] - 1 : returns[last] + 2]
    top = returns[last] + 0.5 * (before - after) / (before - 2.0 * here + after)
    return float(multiple[last] / (top * sample_period))


def dominant_period(position: FloatArray, sample_period: float) -> float:
    """Return the period [s] of the drive's strongest frequency."""
    frequencies, power = spectrum(position, sample_period)
    return float(1.0 / frequencies[np.argmax(power)])
