"""Signals seen otherwise: spectra, correlations, envelopes, derivatives of noisy samples, peaks.

Contents: textbook transforms of evenly spaced samples.

``scipy.signal`` has them all, under other names, but takes longer to import than a recording to be
fitted, since it imports ``scipy.stats``. The tests hold these to the same numbers.
"""

from __future__ import annotations

from math import factorial

import numpy as np
from scipy import fft

from tissue_probe.call_cache import for_a_call
from tissue_probe.signals import FloatArray, IntArray


def correlation(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the sums of products at all lags, shape (n + m - 1,), by Fourier transform.

    Entry m - 1 + j is the sum over i of one[i + j] other[i]; n and m are the sizes of both.
    """
    size = one.size + other.size - 1
    padded = fft.next_fast_len(size, real=True)
    product = fft.rfft(one, padded) * fft.rfft(other[::-1], padded)
    summed: FloatArray = fft.irfft(product, padded)[:size]
    return summed


def periodogram(values: FloatArray, sample_period: float) -> tuple[FloatArray, FloatArray]:
    """Return frequencies [Hz] and the density of power, shape (n // 2 + 1,).

    Under a Hann window, without the mean; frequencies below zero are counted with those above.
    """
    return _frequencies(values.size, sample_period), _density(values[np.newaxis], sample_period)[0]


def welch(values: FloatArray, sample_period: float, segment: int) -> tuple[FloatArray, FloatArray]:
    """Return frequencies [Hz] and the density of power, the mean of that of segments.

    The segments overlap by half (P. Welch, IEEE Trans. Audio Electroacoust. 15 (1967), 70).
    """
    windows = np.lib.stride_tricks.sliding_window_view(values, segment)
    windows = windows[:: segment - segment // 2]
    return _frequencies(segment, sample_period), _density(windows, sample_period).mean(axis=0)


def _frequencies(size: int, sample_period: float) -> FloatArray:
    return np.arange(size // 2 + 1) / (size * sample_period)


def _density(rows: FloatArray, sample_period: float) -> FloatArray:
    """Return the density of power of each row, its mean taken out, under a Hann window."""
    size = rows.shape[1]
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(size) / size)
    centred = rows - rows.mean(axis=1, keepdims=True)
    scale = sample_period / np.sum(window**2)
    power: FloatArray = np.abs(fft.rfft(centred * window, axis=1)) ** 2 * scale
    power[:, 1 : (size + 1) // 2] *= 2.0
    return power


def analytic(values: FloatArray) -> np.ndarray:
    """Return the analytic signal, complex, shape (n,): its size is the envelope, with its phase."""
    size = values.size
    once = np.zeros(size)
    once[0] = 1.0
    once[1 : (size + 1) // 2] = 2.0
    if size % 2 == 0:
        once[size // 2] = 1.0
    signal: np.ndarray = fft.ifft(fft.fft(values) * once)
    return signal


def without_line(values: FloatArray) -> FloatArray:
    """Return values without the straight line that fits them best."""
    at = np.linspace(-1.0, 1.0, values.size)
    centred = values - values.mean()
    rest: FloatArray = centred - at * (at @ centred) / (at @ at)
    return rest


def smooth_values(
    values: FloatArray, window: int, degree: int, derivative: int = 0, sample_period: float = 1.0
) -> FloatArray:
    """Return values, or a derivative of them, of the polynomial through a window about each.

    At either end it is that of the first or last window (A. Savitzky and M. Golay, Anal. Chem. 36
    (1964), 1627).

    Parameters
    ----------
    values : array, shape (n,)
        n is ``window`` at least.
    window : int
        Samples, an odd number.
    degree : int
        Of the polynomial, below ``window``.
    derivative : int
        0 for the values themselves.
    sample_period : float
        Time between two samples [s].
    """
    rows = _of_window(window, degree, derivative)
    half = window // 2
    inside = np.convolve(values, rows[half][::-1], mode="valid")
    begin, end = rows[:half] @ values[:window], rows[half + 1 :] @ values[-window:]
    return np.concatenate([begin, inside, end]) / sample_period**derivative


@for_a_call(32)
def _of_window(window: int, degree: int, derivative: int) -> FloatArray:
    """Return the matrix from a window's values to the polynomial's derivative at each of them."""
    at = np.arange(window) - window // 2
    powers = at[:, np.newaxis] ** np.arange(degree + 1)
    turned = np.zeros_like(powers)
    for power in range(derivative, degree + 1):
        factor = factorial(power) // factorial(power - derivative)
        turned[:, power] = factor * at ** (power - derivative)
    return turned @ np.linalg.pinv(powers)


def peaks(values: FloatArray, least: float) -> IntArray:
    """Return the places of the local maxima that reach ``least``; of a flat one its middle."""
    first = np.flatnonzero(np.diff(values, prepend=np.nan) != 0.0)
    last = np.append(first[1:], values.size) - 1
    level = values[first]
    inner = np.arange(1, first.size - 1)
    tops = inner[
        (level[inner] > level[inner - 1])
        & (level[inner] > level[inner + 1])
        & (level[inner] >= least)
    ]
    places: IntArray = (first[tops] + last[tops]) // 2
    return places


def lasting_range(values: FloatArray, longest: int) -> float:
    """Return the range of values that stay for longer than so many samples, or begin a record.

    Parameters
    ----------
    values : array, shape (n,)
        One channel, finite.
    longest : int
        Of a disturbance [samples].
    """
    from scipy.ndimage import median_filter  # seldom needed

    return float(np.ptp(median_filter(values, 2 * longest + 1, mode="nearest")))
