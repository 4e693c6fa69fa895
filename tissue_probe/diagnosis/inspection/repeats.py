"""Values repeated exactly: a converter at its limit, a channel that got stuck.

Contents: runs of equal samples, and how likely they are.

In a channel with white noise of standard deviation s, two neighbours are equal with a probability
of at most p = erf(step / (2 sqrt(2) s)), which is 0 without steps; a run of L samples comes by
chance at most N p^(L-1) times. In a channel without noise a slow motion leaves a long run, so there
the run must end as a stuck one does: by a jump over the missed samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from tissue_probe.diagnosis.chance import binomial_from
from tissue_probe.diagnosis.inspection.channel import InspectedChannel
from tissue_probe.signals import FloatArray, IntArray

RARE_CHANCE = 1e-4
"""A pattern that comes more rarely than this by chance, in the whole record, is none of chance."""

GENTLE = 0.3
"""A move by less than this share of the seeming noise, next to larger ones, is smooth."""

SHORTEST_REPEAT = 3  # equal samples in a row that count as a run


@dataclass(frozen=True)
class EqualRuns:
    """Runs of equal samples: where each begins, and how many samples it has; shape (k,)."""

    first: IntArray
    length: IntArray

    def __getitem__(self, chosen: NDArray[np.bool_]) -> EqualRuns:
        """Select runs by a mask."""
        return EqualRuns(self.first[chosen], self.length[chosen])

    def spans(self) -> tuple[tuple[int, int], ...]:
        """Return (first, stop) of each."""
        return tuple(
            (int(first), int(first + length))
            for first, length in zip(self.first, self.length, strict=True)
        )


def runs(values: FloatArray) -> EqualRuns:
    """Return the runs of at least 3 equal samples."""
    bounds = np.flatnonzero(np.diff(values) != 0.0) + 1
    first = np.concatenate([[0], bounds])
    length = np.diff(np.concatenate([first, [values.size]]))
    return EqualRuns(first, length)[length >= SHORTEST_REPEAT]


def find_clipped(
    channel: InspectedChannel, other: InspectedChannel
) -> list[tuple[float, EqualRuns]]:
    """Return the limits at which a channel was cut off, each with its runs there.

    Noise makes the extreme value a rare one: then pairs of neighbours that share it are counted
    against chance. Without noise the channel must come to the limit, and leave it, faster than a
    smooth turn does that stays within one step as long; a value of zero is exempt, since a probe
    that lost contact stays there.

    Parameters
    ----------
    channel, other : Channel
        That examined, and the other one, which must move meanwhile.
    """
    found = []
    equal = runs(channel.values)
    for limit in (channel.values.max(), channel.values.min()):
        there = equal[channel.values[equal.first] == limit]
        once_nothing = limit == 0.0 and there.first.size == 1  # a lost reading, not a limit
        if there.first.size == 0 or once_nothing:
            continue
        if _rare_pairs(channel, limit, there) if channel.noisy else _corners(channel, other, there):
            found.append((float(limit), there))
    return found


def find_stuck(channel: InspectedChannel, other: InspectedChannel) -> EqualRuns:
    """Return the runs in which a channel repeated a value instead of measuring.

    Parameters
    ----------
    channel, other : Channel
        That examined, and the other one, which must move meanwhile.
    """
    equal = runs(channel.values)
    by_chance = np.zeros(equal.first.size, dtype=bool)
    if channel.noisy:
        by_chance = (
            channel.values.size * _equal_neighbours(channel) ** (equal.length - 1.0) < RARE_CHANCE
        )
        by_chance &= ~_turns(channel, equal)
    return equal[(by_chance | _jumps(channel, equal)) & _moves(other, equal)]


def _turns(channel: InspectedChannel, equal: EqualRuns) -> NDArray[np.bool_]:
    """Mark runs that a motion comes to and leaves gently: the seeming noise elsewhere is none.

    That is by one step, or by no more than it moves beyond.
    So it is where an interpolated encoder reads almost no motion, once in each of its periods, and
    where a record begins or ends at rest.
    """
    values, stop = channel.values, equal.first + equal.length
    inside = (equal.first >= 2) & (stop + 1 < values.size)
    turns = np.zeros(stop.size, dtype=bool)
    move = np.abs(np.diff(values))
    first, stop = equal.first[inside], stop[inside]
    last, early = np.maximum(move[first - 1], move[stop - 1]), move[first - 2]
    gentle = np.maximum(np.minimum(early, move[stop]), channel.step) + 0.5 * channel.step
    turns[inside] = (last < GENTLE * channel.noise) & (last < gentle)
    rests = (equal.first == 0) & (equal.length < values.size)
    turns[rests] = move[equal.length[rests] - 1] < GENTLE * channel.noise
    settles = (equal.first >= 2) & (equal.first + equal.length == values.size)
    last, early = move[equal.first[settles] - 1], move[equal.first[settles] - 2]
    turns[settles] = (last < GENTLE * channel.noise) & (last < early)
    return turns


def _equal_neighbours(channel: InspectedChannel) -> float:
    return float(erf(channel.grain / (2.0 * np.sqrt(2.0) * channel.noise)))


def _rare_pairs(channel: InspectedChannel, limit: float, there: EqualRuns) -> bool:
    """Whether neighbours share the limit more often than noise has them."""
    at_limit = int(np.count_nonzero(channel.values == limit))
    pairs = int(np.sum(there.length - 1))
    # The extreme of noise lies in its tail, where a second is at most half as likely as usual ...
    rare = binomial_from(pairs, at_limit, 0.5 * _equal_neighbours(channel)) < RARE_CHANCE
    # ... and no step of a tail has more samples than the step before it.
    inside = np.abs(channel.values - limit) < 1.5 * channel.step
    return rare or binomial_from(at_limit, int(np.count_nonzero(inside)), 0.5) < RARE_CHANCE


def _corners(channel: InspectedChannel, other: InspectedChannel, there: EqualRuns) -> bool:
    """Whether a channel without noise comes to a limit, and leaves it, as only clipping does.

    A parabola that stays within one step for L samples has, 2 samples outside, a slope of at most
    8 (L / 2 + 2) / L^2 steps.
    """
    if abs(channel.values[there.first[0]]) <= max(2.0 * channel.step, 3.0 * channel.noise):
        return False
    step = max(channel.step, channel.noise)
    before, after = _slopes(channel.values, there)
    smooth = 8.0 * (there.length / 2.0 + 2.0) / there.length**2.0
    fast = np.minimum(before, after) > (3.0 * smooth + 0.25) * step
    return bool(np.any(fast & (there.length > SHORTEST_REPEAT) & _moves(other, there)))


def _jumps(channel: InspectedChannel, equal: EqualRuns) -> NDArray[np.bool_]:
    """Mark runs that end by a jump over the motion that the neighbours say was missed.

    The jump is larger than the steps about it, as L samples were missed; but not larger than L such
    steps, as that is a motion by steps. A smooth turn within one step for L samples ends by no more
    than 8 (L / 2 + 2) / L^2 steps.
    """
    values, stop = channel.values, equal.first + equal.length
    ends = (equal.first > 0) & (stop < values.size)  # a record may begin at rest
    jump = np.zeros(stop.size)
    jump[ends] = np.abs(values[stop[ends]] - values[stop[ends] - 1])
    before, after = _slopes(values, equal, skip=1)
    slope = np.fmax(before, after)
    smooth = 8.0 * (equal.length / 2.0 + 2.0) / equal.length**2.0
    least = (4.0 * smooth + 3.0) * channel.step + 7.0 * channel.noise + 1e-6 * channel.span
    with np.errstate(invalid="ignore"):
        return (jump > least) & (jump > 2.5 * slope) & (jump < 4.0 * (equal.length + 1) * slope)


def _slopes(values: FloatArray, equal: EqualRuns, skip: int = 0) -> tuple[FloatArray, FloatArray]:
    """Return the mean change a sample over the 4 samples before and after each run, unsigned.

    NaN where the record has no so many; ``skip`` samples next to the run's end are left out.
    """
    first, last = equal.first, equal.first + equal.length - 1 + skip
    before, after = np.full(first.size, np.nan), np.full(first.size, np.nan)
    has_before, has_after = first >= 4, last + 4 < values.size
    begin, end = first[has_before], last[has_after]
    before[has_before] = np.abs(values[begin] - values[begin - 4]) / 4.0
    after[has_after] = np.abs(values[end + 4] - values[end]) / 4.0
    return before, after


def _moves(other: InspectedChannel, equal: EqualRuns) -> NDArray[np.bool_]:
    """Mark runs during which the other channel does not stand still."""
    least = max(3.0 * other.step, 8.0 * other.noise, 1e-4 * other.span)
    return np.array(
        [np.ptp(other.values[first:stop]) > least for first, stop in equal.spans()], dtype=bool
    )
