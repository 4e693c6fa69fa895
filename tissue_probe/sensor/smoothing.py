"""The one filter that motion and wrench pass.

A load's columns are made of the poses as they come; they and the wrench then pass the same filter,
which is linear: the load's part of the wrench stays the sum of its columns, to the last digit.
"""

from __future__ import annotations

import numpy as np
from scipy import signal

from tissue_probe.signals import FloatArray

LOAD_CUTOFF = 8.0
"""Half of the amplitude passes at this frequency [Hz]. Arms move below 3 Hz. Above, twice
differentiated poses are noise: of 10 um at 250 Hz with 0.8 kg .003 N up to 8 Hz, .08 N up to 30 Hz,
where the fit takes it for a delay."""
LOAD_TRANSITION = 4.0
"""The filter is as long as two periods of this frequency [Hz]."""


class Smoother:
    """The filter without delay for one period of samples.

    Parameters
    ----------
    period : float
        Between two samples [s].

    Attributes
    ----------
    half : int
        So many samples are lost at either end.
    passed, left, passed_twice_differentiated : float
        Which part of white noise' variance passes; is in the rest; passes of the second
        differences of white noise.
    """

    def __init__(self, period: float) -> None:
        rate = 1.0 / period
        self.half = round(rate / LOAD_TRANSITION)
        weights = signal.firwin(2 * self.half + 1, LOAD_CUTOFF, window=("kaiser", 5.0), fs=rate)
        self.passed = float(np.sum(weights**2))
        rest = -weights
        rest[self.half] += 1.0
        self.left = float(np.sum(rest**2))
        twice, all_of_it = np.diff(np.pad(weights, 2), 2), np.diff(np.pad(rest, 2), 2)
        self.passed_twice_differentiated = float(np.sum(twice**2) / np.sum(all_of_it**2))
        self._weights = weights

    def __call__(self, rows: FloatArray) -> FloatArray:
        """Return rows, shape (n, c), smoothed: shape (n - 2 half, c)."""
        found: FloatArray = signal.oaconvolve(rows, self._weights[:, None], mode="valid", axes=0)
        return found
