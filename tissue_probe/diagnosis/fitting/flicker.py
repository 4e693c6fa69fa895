"""Noise of an amplifier whose power falls as 1/f, and weights that make it white.

What belongs here: how such noise spreads over a recording, and its removal from least squares.
What does not: the white noise beside it (``residuals.noise_floor``).
"""

from __future__ import annotations

import numpy as np
from scipy.fft import dct

from tissue_probe.signals import FloatArray


def flicker_weights(count: int, level: float, white: FloatArray | float = 1.0) -> FloatArray:
    """Return the weight of each cosine of a recording where noise is white and 1/f.

    The k-th of N orthonormal cosines (DCT-II) has k half periods to the recording. White noise of
    variance 1 puts 1 into each; flicker noise of variance v, from one period to a recording up to
    half the sampling rate, puts v N / (k H) there, H being the harmonic sum up to N / 2. A weight
    is one over the root of both.

    Parameters
    ----------
    count : int
        Samples, N.
    level : float
        Rms of the flicker noise over that of the white noise, sqrt(v).
    white : array, shape (N,), or float
        Power of the white noise that is left in each, where it was coloured.

    Returns
    -------
    array, shape (N,)
    """
    harmonics = np.log(max(count, 4) / 2) + np.euler_gamma
    order = np.maximum(np.arange(count), 0.5)  # of the mean as much as twice the first cosine
    return 1.0 / np.sqrt(white + level**2 * count / (order * harmonics))


def evened(columns: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the weighted cosines of columns, shape (N,) or (N, m): their products are GLS's."""
    return (dct(columns, axis=0, norm="ortho").T * weights).T
