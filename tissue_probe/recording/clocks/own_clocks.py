"""Position and force that have times of their own, brought together.

Contents: channels of two starts or two rates, and rows in which only one of both stands.

The force keeps its times, since errors are judged by its noise; the position moves
smoothly, and is brought to these by a cubic spline.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.recording.clocks.even_grid import BRIDGED, interpolate
from tissue_probe.signals import BoolArray, FloatArray

OWN_ROWS = 0.5
"""Share of a channel's rows in which the other is known, below which each has rows of its own: by
gaps alone most of a recording would be missing."""

FEWEST_ROWS = 12
"""Values of a channel that is brought to the times of the other: the inspection asks for
as many."""

BROUGHT = "the position is brought to the times of the force by a cubic spline"


def rows_of_their_own(
    time: FloatArray, position: FloatArray, force: FloatArray
) -> BoolArray | None:
    """Return the rows of the force, where position and force stand in rows of their own.

    So do two topics that were merged by their times, and two channels of two rates. None where
    they share their rows. Times that do not ascend are told as such elsewhere.

    Parameters
    ----------
    time, position, force : array, shape (n,)
        NaN where not known.
    """
    moved, felt = np.isfinite(position), np.isfinite(force)
    both = np.count_nonzero(moved & felt)
    apart = both < OWN_ROWS * max(np.count_nonzero(moved), np.count_nonzero(felt))
    enough = min(np.count_nonzero(moved), np.count_nonzero(felt)) >= FEWEST_ROWS
    return felt if apart and enough and bool(np.all(np.diff(time) >= 0.0)) else None


def at_times(time: FloatArray, position: FloatArray, at: FloatArray) -> FloatArray:
    """Return a position at other times; NaN outside its own, and in its gaps.

    Parameters
    ----------
    time, position : array, shape (n,)
        Ascending times [s], and the position at them [m]; NaN where not known.
    at : array, shape (k,)
        Times to tell it at [s].
    """
    known = np.isfinite(position) & np.isfinite(time)
    if np.count_nonzero(known) < FEWEST_ROWS:
        return np.full(at.size, np.nan)
    return interpolate(time[known], position[known], at, reach=BRIDGED)


def compare_clocks(position: FloatArray, force: FloatArray) -> str | None:
    """Say how the times of position and force [s] differ; None where they are the same."""
    if position.size == force.size and bool(np.all(position == force)):
        return None
    late = 1e3 * float(force[0] - position[0])
    if late == 0.0 and position.size != force.size:
        sizes = f"{position.size} samples, the force {force.size}"
        return f"the position has {sizes}, so the file may be cut; {BROUGHT}"
    said = f"the force begins {abs(late):.4g} ms {'after' if late > 0 else 'before'} the position"
    rates = [1.0 / float(np.median(np.diff(times))) for times in (position, force)]
    if abs(rates[0] - rates[1]) > 1e-6 * rates[1]:
        said = f"the position has {rates[0]:.6g} samples a second, the force {rates[1]:.6g}"
    return f"{said}; {BROUGHT}"
