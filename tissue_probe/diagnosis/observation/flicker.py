"""Noise of an amplifier whose power falls as 1/f, beside any other: weights that make it white.

Contents: how such noise spreads over a recording, and its removal from least squares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import dct

from tissue_probe.signals import FloatArray


@dataclass(frozen=True)
class Evening:
    """Weights of a recording's cosines that make its noise even over the frequencies.

    Attributes
    ----------
    weights : array, shape (n,), or ()
        Of each cosine; one number where the noise is white already.
    """

    weights: FloatArray

    @classmethod
    def of(cls, count: int, level: float, white: FloatArray) -> Evening:
        """Return the weights where noise is white and 1/f.

        The k-th of N orthonormal cosines (DCT-II) has k half periods to the recording. White noise
        of variance 1 puts 1 into each; flicker noise of variance v, from one period to a recording
        up to half the sampling rate, puts v N / (k H) there, H being the harmonic sum up to N / 2.
        A weight is one over the root of both.

        Parameters
        ----------
        count : int
            Samples, N.
        level : float
            Rms of the flicker noise over that of the white noise, sqrt(v).
        white : array, shape (N,) or ()
            Power of the white noise that is left in each, where it was coloured.
        """
        if not level and not white.ndim:
            return cls(1.0 / np.sqrt(white))
        harmonics = np.log(max(count, 4) / 2) + np.euler_gamma
        order = np.maximum(np.arange(count), 0.5)  # of the mean as much as twice the first cosine
        return cls(1.0 / np.sqrt(white + level**2 * count / (order * harmonics)))

    def even(self, columns: FloatArray) -> FloatArray:
        """Return columns, shape (N,) or (N, m), whose products are those of all weighted cosines.

        They are the cosines, or the samples where all weights are one.
        """
        return self.cosines(columns) if self.weights.ndim else columns

    def cosines(self, columns: FloatArray) -> FloatArray:
        """Return the weighted cosines of columns, shape (N,) or (N, m): products are as of GLS."""
        weighted: FloatArray = (dct(columns, axis=0, norm="ortho").T * self.weights).T
        return weighted
