"""Where samples jump: a step that is not the slope of either side.

Contents: finding jumps in samples.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.signals import FloatArray, IntArray


def jumps(steps: FloatArray) -> IntArray:
    """Return the first samples after jumps.

    A step is one where those before and after it go less than half as far the same way. A sine has
    none from six samples a period on.

    Parameters
    ----------
    steps : array, shape (n - 1,)
        From each sample to the next; over the time between them where that differs.
    """
    same_way = np.pad(steps, 1)
    same_way = np.maximum(same_way[:-2] * np.sign(steps), same_way[2:] * np.sign(steps))
    return 1 + np.flatnonzero((steps != 0.0) & (same_way < np.abs(steps) / 2.0))
