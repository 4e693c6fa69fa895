"""Whether the residual of a fit is white noise, by its cosines.

Contents: two numbers that need no level of the noise, where it is not an upper bound.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tissue_probe.signals import FloatArray

#: The cosines below this share of all, those below a sixteenth of the sampling rate, are judged by
#: the others.
SLOW_PART = 8
SMALL_SHARE = 0.00025


def colour(cosines: Sequence[FloatArray], least: float = 0.0) -> float:
    """Return the rms of slow cosines over that of fast ones: 1 where they are white.

    Parameters
    ----------
    cosines : sequence of array, shape (N,)
        Orthonormal cosines (DCT-II) of each measurement's residual.
    least : float
        Mean square that fast ones count as at least: the expected one, where that is an upper
        bound; by default their level is their own.
    """
    low, high = (float(np.mean(part**2)) for part in _split(cosines))
    return float(np.sqrt(low / max(high, least, np.finfo(float).tiny)))


def unevenness(cosines: Sequence[FloatArray], least: float = 0.0) -> float:
    """Return the largest excess of an octave of slow cosines over fast ones.

    In units of the usual size where noise is white, about a standard deviation; or, where that is
    smaller, in shares ``SMALL_SHARE`` of all energy, so that a tiny departure does not count on a
    long recording. A cause that the model has not is seldom spread over all frequencies as noise
    is.

    Parameters
    ----------
    cosines : sequence of array, shape (N,)
        Orthonormal cosines (DCT-II) of each measurement's residual.
    least : float
        As for ``colour``.
    """
    level = max(float(np.mean(_split(cosines)[1] ** 2)), least, np.finfo(float).tiny)
    total = sum(each.size for each in cosines)
    largest, first = -np.inf, 0
    while first < max(each.size for each in cosines) // SLOW_PART:
        # Octaves: 0 and 1, 2 and 3, 4 to 7, ...
        after = max(2, 2 * first)
        octave = np.concatenate([each[: each.size // SLOW_PART][first:after] for each in cosines])
        excess = float(np.sum(octave**2)) / level - octave.size
        # One more than its standard deviation: the sum of few squares has a long tail.
        usual = 1.0 + np.sqrt(2.0 * octave.size)
        largest = max(largest, excess / max(usual, SMALL_SHARE * total))
        first = after
    return float(largest)


def _split(cosines: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    slow = np.concatenate([each[: each.size // SLOW_PART] for each in cosines])
    return slow, np.concatenate([each[each.size // SLOW_PART :] for each in cosines])
