"""A channel that repeats old values, as one published faster than its sensor measures.

Contents: telling such repeats from those of a coarse converter, of a sensor at its end, and of a
command in steps.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.signals import BoolArray, FloatArray, IntArray

REPEATED = 0.1
"""Share of samples that repeat the one before, above which a channel may be held. Fewer do not
change a fit: a spline through the others would move it by less."""

COARSE_STEPS = 2.5
"""Changes larger than so many of the channel's own steps are not those of a coarse converter, which
repeats a value only where the signal moves less than a step or two between samples."""

REPEATED_BY_CHANCE = 3.0
"""A held channel repeats values more often than so many times the number by chance for its steps.
"""

REGULAR = 0.95
"""Share of values that are held about equally long, as a clock makes them; a sensor at its end, or
a signal at rest, holds few values for long."""

BY_ACCIDENT, FOLLOWS_SIGNAL = 30.0, 0.75
"""The input is felt where it changes. A motion of the other channel after a change, which its past
does not foretell, follows the change: by a sum of squares so many times the variance of the
forecast's error elsewhere (5.5 standard deviations), and by this share of its own sum of squares.
"""

ROWS_AFTER = (1, 2, 4, 8, 16)
"""Rows after a change at which the other channel is looked at: a heavy probe answers late."""


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
    return fresh if _is_held(fresh, changes) else np.ones_like(fresh)


def _is_held(fresh: BoolArray, changes: FloatArray) -> bool:
    repeats = np.count_nonzero(~fresh)
    # So few runs show no share of them: one that is not regular would be more than may be.
    if changes.size < 1.0 / (1.0 - REGULAR) or repeats < REPEATED * fresh.size:
        return False
    step = changes.min()
    if np.median(changes) <= COARSE_STEPS * step:
        return False
    # Of a step up, a step down and none, each is about as likely.
    by_chance = np.count_nonzero(changes < 1.5 * step) / 2.0
    runs = np.diff(np.flatnonzero(np.append(fresh, True)))
    usual = np.median(runs)
    regular = runs <= usual + 1
    if usual > 2:  # a fresh value may be equal to the last
        regular |= np.abs(runs - usual * np.rint(runs / usual)) <= 1
    return bool(
        repeats > REPEATED_BY_CHANCE * by_chance
        and np.count_nonzero(runs > 1) >= REPEATED * runs.size
        and np.mean(regular) >= REGULAR
    )


def drives(values: FloatArray, fresh: BoolArray, other: FloatArray) -> bool:
    """Return whether a channel that is held between changes drives the other one.

    A sensor that is read late holds its values, too, but nothing happens when it is read.

    Parameters
    ----------
    values : array, shape (n,)
        The channel that is held.
    fresh : array of bool, shape (n,)
        See ``fresh_values``.
    other : array, shape (n,)
        The other channel, in the same rows; NaN where it is not known.

    Notes
    -----
    A row of the other channel is foretold by four earlier ones, as evenly spaced, which is exact
    for any one sine beside a constant (G. U. Yule, Phil. Trans. A 226 (1927), 267).
    """
    rows = np.flatnonzero(fresh)
    run = int(np.median(np.diff(rows))) if rows.size > 1 else 0
    changes = np.diff(values, prepend=values[:1])
    return any(
        _follows(changes, rows, other, ahead)
        for ahead in ROWS_AFTER
        if len(ROWS_AFTER) * ahead <= run
    )


def _follows(changes: FloatArray, rows: IntArray, other: FloatArray, ahead: int) -> bool:
    """Return whether the other channel answers changes, which come in these rows, so much later."""
    places = np.arange(3 * ahead + 1, other.size - ahead)
    past = [other[places - 1 - back * ahead] for back in range(4)]
    known = np.stack([*past, np.ones(places.size)], axis=1)
    later = other[places - 1 + ahead]
    since = places - rows[np.searchsorted(rows, places, side="right") - 1]
    upto = np.append(rows, other.size)[np.searchsorted(rows, places, side="right")] - places
    measured = np.isfinite(known).all(axis=1) & np.isfinite(later)
    undisturbed = measured & (since > 3 * ahead) & (upto >= ahead)
    own = measured & (since == 0) & (places > rows[0]) & np.isfinite(changes[places])
    if np.count_nonzero(undisturbed) < 3 * known.shape[1] or np.count_nonzero(own) < 3:
        return False
    weights = np.linalg.lstsq(known[undisturbed], later[undisturbed], rcond=None)[0]
    unforetold = later - known @ weights
    after, change = unforetold[own], changes[places[own]]
    explained = np.dot(after, change) ** 2 / np.dot(change, change)
    chance = np.mean(unforetold[undisturbed] ** 2)
    return bool(explained > max(BY_ACCIDENT * chance, FOLLOWS_SIGNAL * np.dot(after, after)))
