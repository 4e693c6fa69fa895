"""Signals of known lines that repeat, and their derivatives, by a discrete Fourier transform.

Contents: the transform, exact at evenly spaced instants.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tissue_probe.signals import FloatArray


def periodic(
    lines: NDArray[np.int64],
    coefficients: NDArray[np.complex128],
    period: float,
    samples: int,
    count: int,
) -> tuple[FloatArray, FloatArray]:
    """Return a periodic signal and its derivative [1/s] at evenly spaced instants from 0.

    Parameters
    ----------
    lines : array of int
        Numbers of the lines, in whole periods.
    coefficients : array of complex
        Of the discrete Fourier transform over one period, one for each line.
    period : float
        After which the signal repeats [s].
    samples : int
        Instants in a period.
    count : int
        Instants wanted.
    """
    spectrum = np.zeros(samples // 2 + 1, dtype=complex)
    spectrum[lines] = coefficients
    value = np.fft.irfft(spectrum, samples)
    spectrum[lines] *= 2j * np.pi / period * lines
    return np.resize(value, count), np.resize(np.fft.irfft(spectrum, samples), count)
