"""Values between samples, from the two on either side alone.

What belongs here: the cubic through four samples (Lagrange). What does not: the spline through all
of a recording (``even_grid``), a fixed delay of even samples (``alignment``).
"""

from __future__ import annotations

import numpy as np

from tissue_probe.signals import FloatArray, IntArray


def local_cubic(stamps: IntArray, rows: FloatArray, at: IntArray) -> FloatArray:
    """Return rows at other times, each by the cubic through the two rows before and the two after.

    A value depends on these four to the last bit, and on nothing else: not on which others are
    known, nor on how many are asked for. Of a sine of n samples a period it is within
    9 / 384 (2 pi / n)^4 of the amplitude: .4 % at 10.

    Parameters
    ----------
    stamps : array of int, shape (n,)
        Ascending [ns].
    rows : array, shape (n, c)
        Values there.
    at : array of int, shape (m,)
        Times [ns], after the second stamp and up to the last but one.

    Returns
    -------
    array, shape (m, c)
    """
    before = np.searchsorted(stamps, at, "left") - 1
    four = [before + offset for offset in (-1, 0, 1, 2)]
    # Differences of whole numbers are exact, and small enough for floats to be.
    times = [(stamps[each] - stamps[before]).astype(np.float64) for each in four]
    since = (at - stamps[before]).astype(np.float64)
    values = np.zeros((at.size, rows.shape[1]))
    for own, index in enumerate(four):
        weight = np.ones(at.size)
        for other in range(4):
            if other != own:
                weight *= (since - times[other]) / (times[own] - times[other])
        values += weight[:, None] * rows[index]
    return values
