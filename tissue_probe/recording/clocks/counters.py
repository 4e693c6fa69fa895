"""Counters that begin again at their end, as those of encoders and clocks do.

Contents: telling that from a jump, and undoing it.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.signals import FloatArray

BITS = (8, 10, 12, 14, 16, 20, 24, 32, 48)
"""Widths of counters."""

SMALL_ADVANCE = 1 / 8
"""Between two samples a counter goes less than this share of its range: at more its way could as
well be the other way round."""

VALUES_FIRST = 1000
"""Values looked at first: in most columns one of them is no whole number; the rest is spared then.
"""


def unwrap_counter(values: FloatArray) -> tuple[FloatArray, int | None]:
    """Return a counter's values as if it had no end, and its width in bits; None if it has none.

    Parameters
    ----------
    values : array, shape (n,)
        Whole numbers; NaN where not known. Others come back as they are.
    """
    few = values[:VALUES_FIRST]
    if not (np.isnan(few) | (few == np.rint(few))).all():
        return values, None
    known = np.isfinite(values)
    counts = values if known.all() else values[known]
    if counts.size < 2 or (counts.dtype.kind == "f" and (counts != np.rint(counts)).any()):
        return values, None
    low, high = counts.min(), counts.max()
    steps = np.diff(counts.astype(np.float64, copy=False))  # those of narrow integers wrap, too
    del counts  # columns of a long recording fill the memory; below, they are used again
    for bits in BITS:
        size = 2.0**bits
        if not ((low >= 0 and high < size) or (low >= -size / 2 and high < size / 2)):
            continue
        turns = steps / size
        np.rint(turns, out=turns)
        if not turns.any() or not _is_near(steps, turns, size):
            return values, None
        del steps
        np.cumsum(turns, out=turns)
        turns *= size
        found = values.astype(np.float64)
        found[np.flatnonzero(known)[1:]] -= turns
        return found, bits
    return values, None


def _is_near(steps: FloatArray, turns: FloatArray, size: float) -> bool:
    """Whether, but for whole turns, a counter goes only a small way from sample to sample."""
    off = turns * size
    np.subtract(steps, off, out=off)
    np.abs(off, out=off)
    return bool(off.max() <= SMALL_ADVANCE * size)
