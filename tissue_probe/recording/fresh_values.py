"""A channel that repeats old values, as one published faster than its sensor measures.

What belongs here: telling such repeats from those of a coarse converter or a sensor at its end.
What does not: what is done with the fresh values (``foreign_bag``, ``table_file``).
"""

from __future__ import annotations

import numpy as np

from tissue_probe.signals import BoolArray, FloatArray

REPEATED = 0.1
"""Share of samples that repeat the one before, above which a channel may be held. Fewer do not
change a fit: a spline through the others would move it by less."""

STEPS = 2.5
"""Changes larger than so many of the channel's own steps are not those of a coarse converter, which
repeats a value only where the signal moves less than a step or two between samples."""

BY_CHANCE = 3.0
"""A held channel repeats values more often than so many times what chance gives one of its steps.
"""

REGULAR = 0.95
"""Share of values that are held about equally long, as a clock makes them; a sensor at its end, or
a signal at rest, holds few values for long."""


def fresh_values(values: FloatArray) -> BoolArray:
    """Return which values are fresh: all, but for a channel that repeats old ones.

    A channel repeats old values if many of its samples are equal to the one before, bit for bit,
    in runs of about one length, while it changes by more than its own step between runs. The
    first of each run is fresh. Values that are not known (NaN) count as repeats of no other.

    Parameters
    ----------
    values : array, shape (n,)
        In the order they were taken.

    Returns
    -------
    array of bool, shape (n,)
    """
    if np.count_nonzero(values[1:] == values[:-1]) < REPEATED * values.size:
        return np.ones(values.size, dtype=bool)
    fresh = np.ones(values.size, dtype=bool)
    fresh[1:] = values[1:] != values[:-1]  # NaN differs from everything
    changes = np.abs(np.diff(values[fresh & np.isfinite(values)]))
    return fresh if _held(fresh, changes) else np.ones_like(fresh)


def _held(fresh: BoolArray, changes: FloatArray) -> bool:
    repeats = np.count_nonzero(~fresh)
    if changes.size < 2 or repeats < REPEATED * fresh.size:
        return False
    step = changes.min()
    if np.median(changes) <= STEPS * step:
        return False
    # Of a step up, a step down and none, each is about as likely.
    by_chance = np.count_nonzero(changes < 1.5 * step) / 2.0
    runs = np.diff(np.flatnonzero(np.append(fresh, True)))
    usual = np.median(runs)
    regular = runs <= usual + 1
    if usual > 2:  # a fresh value may be equal to the last
        regular |= np.abs(runs - usual * np.rint(runs / usual)) <= 1
    return bool(
        repeats > BY_CHANCE * by_chance
        and np.count_nonzero(runs > 1) >= REPEATED * runs.size
        and np.mean(regular) >= REGULAR
    )
