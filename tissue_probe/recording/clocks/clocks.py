"""The clocks of a recorded channel, judged by the times at which messages were logged and stamped.

Contents: steps, rollovers, drift, ticks and jitter, found in two arrays of times, and times without
them.

A message has two times: its stamp, when the sensor measured, by the sensor's clock, and its log
time, when the recorder received it, by the recorder's. The delay, log time minus stamp, holds the
difference of the two clocks and the way of the message, which is never negative.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tissue_probe.signals import NANOSECONDS, FloatArray, IntArray

SHIFT_WORTH_TELLING = 1_000_000
"""Shifts in time that matter [ns]: T between force and position shifts the damping by k T, 1 ms at
500 N/m by 0.5 N s/m, which is a tenth of that of soft tissue."""

BLOCK_MESSAGES = 16
"""Messages whose median delay is compared with that of others: the jitter of single messages, much
larger, does not look like a step then."""

STEP_DEVIATIONS = 8.0
"""Standard deviations by which a change of the median delay stands out among all of a recording."""

MESSAGES_AROUND = 8
"""Messages before and after a step back that show whether it lasts, or one message came late."""

BLOCKS_TOGETHER = 2**16
"""Blocks that are looked at together: of a long bag, each array more fills the memory."""

MESSAGES_BESIDE = 256
"""Messages on each side of a step whose median delays tell its size, to a sixteenth of the jitter.
"""

ROLLOVERS = {"2^32 ns": 2**32, "2^32 us": 2**32 * 1000}
"""By how much counters of 32 bits step back when they begin anew [ns]."""

TICKED = 0.1
"""Share of stamps equal to the one before, above which a clock is coarser than the sampling."""

LEAST_QUANTILE = 0.01
"""Quantile of the delays that stands for the least: any delay of a message only adds."""


@dataclass(frozen=True)
class ClockedTimes:
    """Times of a channel's messages, ascending, and how they came about; arrays have shape (n,).

    Attributes
    ----------
    times : array of int
        When each was measured, by the clock of the stamps; by the recorder's where there are none
        [ns].
    rows : array of int, or slice
        Which message each is, in the order stored: a late message is in its place, one that came
        twice is there once. A slice of all where they came in order: arrays of a long bag are
        large.
    stamped : bool
        Whether the times are those of stamps.
    cuts : array of int, shape (k,)
        Where a clock stepped: the time of the first message after each [ns].
    setbacks : array of int, shape (j,)
        By how much each step back of the host's clock, which stamps and log times share, was made
        good [ns].
    setback_cuts : array of int, shape (j,)
        Which of the cuts these are.
    delay : float
        Median of log time minus time [ns]; 0 where there are no stamps.
    least_delay : float
        The delay by the clocks, and the shortest way [ns], at the first message.
    drift : float
        By how much the delay grows over the stamps' time [-].
    drift_error : float
        Its standard error [-].
    jitter : float
        Range of nine tenths of the delays, drift and steps taken out [ns].
    tick : float
        Step of the stamps where it is coarser than the sampling, else 0 [ns].
    even : bool
        Whether even sampling explains coarse stamps: then the times are even.
    doubt : float
        Standard error of the correction of the times, steps or a rate that was not quite the
        one stated: by so much they may be off against the other channel [ns].
    notes : tuple of str
        The findings, in sentences.
    """

    times: IntArray
    rows: IntArray | slice
    stamped: bool
    cuts: IntArray
    setbacks: IntArray
    setback_cuts: IntArray
    delay: float = 0.0
    least_delay: float = 0.0
    drift: float = 0.0
    drift_error: float = 0.0
    jitter: float = 0.0
    tick: float = 0.0
    even: bool = True
    doubt: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """From the first time to the last [ns]."""
        return float(self.times[-1] - self.times[0])


def correct_clocks(name: str, logged: IntArray, stamped: IntArray | None) -> ClockedTimes:
    """Find the faults of a channel's clocks, and return times without them.

    Parameters
    ----------
    name : str
        The channel's name in messages.
    logged : array, shape (n,)
        When each message was recorded, in the order stored [ns].
    stamped : array, shape (n,), optional
        The stamps in its headers [ns].
    """
    notes: list[str] = []
    if stamped is None:
        times, setbacks, places = _without_setbacks(logged)
        notes += _tell_setbacks(name, setbacks, logged, places)
        return _order_messages(name, times, logged, setbacks, places, [], notes, stamped=False)
    stamps = _unroll_counter(name, stamped, logged, notes)
    stamps, steps, known, doubt = _without_steps(name, stamps, logged, notes)
    times, setbacks, places = _without_setbacks(stamps)
    # A step that both clocks share is one of the host's.
    logged, _, _ = _without_setbacks(logged) if setbacks.size else (logged, None, None)
    notes += _tell_setbacks(name, setbacks, stamped, places)
    found = _order_messages(name, times, logged, setbacks, places, steps, notes, stamped=True)
    delays = _difference(logged[found.rows], found.times)
    if known is not None:
        delays -= known[found.rows]
    return replace(_with_delays(name, found, delays), doubt=doubt)


def onto_recorder(clock: ClockedTimes, drift: float | None = None) -> ClockedTimes:
    """Return times by the recorder's clock: those of stamps with the clocks' difference added.

    Parameters
    ----------
    clock : ClockedTimes
        A channel.
    drift : float, optional
        Take out this drift and nothing else, so that channels that share it stay as they are to
        each other [-].
    """
    if not clock.stamped:
        return clock

    def move_times(times: IntArray) -> IntArray:
        shift = (times - clock.times[0]) * (clock.drift if drift is None else drift)
        shift = shift + (clock.least_delay if drift is None else 0.0)
        found: IntArray = times + np.rint(shift).astype(np.int64)
        return found

    return replace(clock, times=move_times(clock.times), cuts=move_times(clock.cuts), drift=0.0)


def space_evenly(clock: ClockedTimes, name: str, logged: IntArray, rate: float) -> ClockedTimes:
    """Return times of messages sent at an even rate [Hz], none lost, of which none came early.

    Their drift is that of the recorder's clock against this rate.
    """
    even = np.arange(logged.size, dtype=float) * (NANOSECONDS / rate)
    delays = logged - logged[0] - even
    drift, error = _slope(even, delays)
    begin = int(np.quantile(delays, LEAST_QUANTILE)) + int(logged[0])
    none = np.array([], dtype=np.int64)
    times = begin + np.rint(even).astype(np.int64)
    said = (
        f"{name} is taken as sampled evenly at {rate:.6g} Hz, none of its {logged.size} messages "
        "lost; it begins where the earliest of them allow, by the recorder's clock"
    )
    return replace(
        clock, times=times, rows=slice(None), cuts=none, setbacks=none, setback_cuts=none,
        drift=drift, drift_error=error, notes=(said,),
    )  # fmt: skip


def usual_step(times: IntArray) -> float:
    """Return the usual time between two messages [ns]."""
    steps = np.diff(times)
    if steps.min(initial=1) <= 0:
        steps = steps[steps > 0]
    return float(np.median(steps, overwrite_input=True)) if steps.size else 0.0


def _difference(logged: IntArray, times: IntArray) -> FloatArray:
    """Return log times less times [ns], without an array between."""
    return np.subtract(logged, times, out=np.empty(times.size))


def _block_medians(values: FloatArray) -> FloatArray:
    """Return the median of each whole block, of a long column piece by piece."""
    blocks = values.size // BLOCK_MESSAGES
    whole = values[: blocks * BLOCK_MESSAGES].reshape(blocks, BLOCK_MESSAGES)
    pieces = [
        np.median(whole[i : i + BLOCKS_TOGETHER], axis=1) for i in range(0, blocks, BLOCKS_TOGETHER)
    ]
    return np.concatenate(pieces) if pieces else np.empty(0)


def _unroll_counter(name: str, stamps: IntArray, logged: IntArray, notes: list[str]) -> IntArray:
    """Count on where a counter of 32 bits began anew."""
    if np.diff(stamps).min(initial=0) > -min(ROLLOVERS.values()) / 2:
        return stamps
    usual = usual_step(stamps)
    steps = np.diff(stamps)
    delays = np.diff(logged - stamps)
    for called, size in ROLLOVERS.items():
        # One goes from the last count to the first; the recorder's clock knows nothing of it.
        rolled = (np.abs(steps + size - usual) < size / 8) & (np.abs(delays - size) < size / 8)
        if rolled.any():
            count = int(np.count_nonzero(rolled))
            notes.append(
                f"the stamps of {name} begin anew at {called} {_times(count)}, and are counted on"
            )
            stamps = stamps + size * np.r_[0, np.cumsum(rolled)]
            steps, delays = np.diff(stamps), np.diff(logged - stamps)
    return stamps


def _without_steps(
    name: str, stamps: IntArray, logged: IntArray, notes: list[str]
) -> tuple[IntArray, list[int], IntArray | None, float]:
    """Take steps of the stamps' clock out of the stamps.

    Returns the stamps, where they stepped, the rest of the delay, which is no property of the
    clocks at the beginning (steps of the recorder's clock, or of the way, shape (n,); None where
    there are none), and how exactly steps were taken out [ns].
    """
    usual = usual_step(stamps)
    steps, known, doubt = [], None, 0.0
    delays = _difference(logged, stamps)
    for first, stop, size, drift in _level_steps(delays):
        place = np.arange(first, stop)
        of_stamps, of_logs = (
            np.diff(each)[first - 1 : stop - 1] - usual for each in (stamps, logged)
        )
        at = int(place[np.argmin(np.abs(of_stamps + size))])
        exact = of_stamps[at - first]
        stepped = (
            abs(exact + size) < abs(size) / 4 or np.abs(of_stamps).max() > np.abs(of_logs).max()
        )
        seconds = (logged[at] - logged[0]) / NANOSECONDS
        if not stepped:
            at = int(place[np.argmax(of_logs * np.sign(size))])
            known = np.zeros(stamps.size, dtype=np.int64) if known is None else known
            known[at:] += round(size)
            notes.append(
                f"{name} comes {_size(size)} {'later' if size > 0 else 'earlier'} from "
                f"{seconds:.4g} s on: the recorder's clock stepped, or the way of its messages "
                "changed; it goes by its stamps, which did not"
            )
            continue
        uneven = 1.4826 * float(np.median(np.abs(of_stamps)))
        shift, error = _exact_shift(delays, at, exact, usual, uneven, drift)
        doubt = float(np.hypot(doubt, error))
        stamps = stamps.copy()
        stamps[at:] += shift
        steps.append(at)
        notes.append(
            f"the clock that stamps {name} steps {'forward' if shift < 0 else 'back'} by "
            f"{_size(shift)}, {seconds:.4g} s after the first message: the step is taken out by "
            "the recorder's clock, and the recording split there"
        )
    return stamps, steps, known, doubt


def _exact_shift(
    delays: FloatArray, at: int, jump: float, usual: float, uneven: float, drift: float
) -> tuple[int, float]:
    """Return the correction of a step in the stamps [ns], from the delays on both sides of it.

    As exact as the stamps are even, where the delays are sure enough of how many are missing there;
    and its standard error [ns]: ``uneven``, that of a step of the stamps, or of the medians of the
    delays else.
    """
    sides = delays[max(at - MESSAGES_BESIDE, 0) : at], delays[at : at + MESSAGES_BESIDE]
    size = float(np.median(sides[1]) - np.median(sides[0]))
    size -= drift * sum(side.size for side in sides) / 2.0
    missing = round((jump + size) / usual) if usual else 0
    exact = missing * usual - jump
    if abs(exact - size) < usual / 4:
        return round(exact), uneven
    spread = [1.4826 * np.median(np.abs(side - np.median(side))) for side in sides]
    of_medians = [
        np.sqrt(np.pi / 2.0 / side.size) * each for side, each in zip(sides, spread, strict=True)
    ]
    return round(size), float(np.hypot(*of_medians))


def _level_steps(delays: FloatArray) -> Iterator[tuple[int, int, float, float]]:
    """Yield where the delay changes for good (between first and stop), and by how much [ns].

    And by how much it grows from message to message otherwise [ns].
    """
    blocks = delays.size // BLOCK_MESSAGES
    if blocks < 3:
        return
    medians = _block_medians(delays)
    changes = medians[2:] - medians[:-2]  # the block between may hold the step
    usual = np.median(changes)
    scatter = 1.4826 * np.median(np.abs(changes - usual))
    far = np.abs(changes - usual) > max(SHIFT_WORTH_TELLING, STEP_DEVIATIONS * scatter)
    bounds = np.flatnonzero(np.diff(np.r_[False, far, False].astype(int)))
    for begin, end in zip(bounds[::2], bounds[1::2], strict=True):
        before, after = medians[begin], medians[end + 1]
        size = after - before - usual * (end + 1 - begin) / 2.0
        if abs(size) <= max(SHIFT_WORTH_TELLING, STEP_DEVIATIONS * scatter):
            continue  # there and back: some messages were slow
        first, stop = int(begin * BLOCK_MESSAGES), int(min((end + 2) * BLOCK_MESSAGES, delays.size))
        high = (delays[first:stop] > (before + after) / 2.0) == (size > 0)
        # Left of the step all are low, right of it high.
        wrong = np.r_[0, np.cumsum(high)] + np.r_[np.cumsum(~high[::-1])[::-1], 0]
        at = first + int(np.argmin(wrong))
        near = max(at - BLOCK_MESSAGES // 2, 1), min(at + BLOCK_MESSAGES // 2, delays.size)
        yield near[0], max(near[1], near[0] + 1), float(size), usual / (2 * BLOCK_MESSAGES)


def _without_setbacks(times: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Make good where a clock steps back for good; return also by how much, and where."""
    steps = np.diff(times)
    if steps.min(initial=0) >= 0:
        none = np.array([], dtype=np.int64)
        return times, none, none
    usual = usual_step(times)
    scatter = 1.4826 * np.median(np.abs(steps - usual)) if steps.size else 0.0
    back = np.flatnonzero(steps < min(0.0, usual - STEP_DEVIATIONS * scatter)) + 1
    # Of one that comes late, those before and behind go on as if nothing was.
    numbers = np.arange(MESSAGES_AROUND)
    after = np.minimum(back[:, None] + numbers, times.size - 1)
    before = np.maximum(back[:, None] - 1 - numbers, 0)
    level = times[after] - usual * (after - back[:, None])
    level_before = times[before] + usual * (back[:, None] - 1 - before)
    jump = np.median(level, axis=1) - np.median(level_before, axis=1) - usual
    lasting = back[jump <= 0.75 * steps[back - 1]]
    # Of neighbours, the largest is the step.
    places = np.array(
        [max(group, key=lambda at: -steps[at - 1]) for group in _neighbours(lasting)],
        dtype=np.int64,
    )
    setbacks = np.rint(usual - steps[places - 1]).astype(np.int64)
    shifted = times.copy()
    for place, size in zip(places, setbacks, strict=True):
        shifted[place:] += size
    return shifted, setbacks, places


def _neighbours(places: IntArray) -> Iterator[list[int]]:
    bounds = [0, *(np.flatnonzero(np.diff(places) > MESSAGES_AROUND) + 1), places.size]
    for first, stop in pairwise(bounds):
        if first < stop:
            yield places[first:stop].tolist()


def _tell_setbacks(name: str, setbacks: IntArray, times: IntArray, places: IntArray) -> list[str]:
    return [
        f"the host's clock, by which {name} goes, steps back by {_size(size)}, "
        f"{(times[place - 1] - times[0]) / NANOSECONDS:.4g} s after the first message: the "
        "messages behind are treated as later, and the recording split there"
        for place, size in zip(places, setbacks, strict=True)
    ]


def _order_messages(
    name: str,
    times: IntArray,
    logged: IntArray,
    setbacks: IntArray,
    places: IntArray,
    steps: list[int],
    notes: list[str],
    stamped: bool,
) -> ClockedTimes:
    """Put late messages in their place, and leave out those with the time of another."""
    cuts = np.array(sorted(times[[*steps, *places]]), dtype=np.int64)
    setback_cuts = np.searchsorted(cuts, times[places])
    tick, even = 0.0, True
    if stamped and _is_ticked(times):
        steps_up = np.diff(times)
        tick = float(np.median(steps_up[steps_up > 0])) if (steps_up > 0).any() else 0.0
        times, even = _spread(times, tick)
        notes.append(_tell_ticks(name, tick, times, even))
    rows = _rows_in_order(name, times, stamped, even, notes)
    return ClockedTimes(
        times[rows], rows, stamped, cuts, setbacks, setback_cuts, tick=tick, even=even,
        notes=tuple(notes),
    )  # fmt: skip


def _rows_in_order(
    name: str, times: IntArray, stamped: bool, even: bool, notes: list[str]
) -> IntArray | slice:
    """Return which messages to take, in the order of their times."""
    steps = np.diff(times)
    if steps.min(initial=1) > 0:
        return slice(None)
    rows = np.argsort(times, kind="stable")
    if (steps < 0).any():
        latest = np.maximum.accumulate(times)
        notes.append(
            f"{np.count_nonzero(latest > times)} messages of {name} were stored out of order, by "
            f"up to {_size((latest - times).max())}; put in the order of their "
            f"{'stamps' if stamped else 'log times'}"
        )
    first = np.r_[True, np.diff(times[rows]) > 0]
    if even and not first.all():
        notes.append(
            f"{np.count_nonzero(~first)} messages of {name} have the time of the one before, and "
            "are left out"
        )
        rows = rows[first]
    return rows


def _is_ticked(times: IntArray) -> bool:
    return times.size > 1 and bool(np.mean(times[1:] == times[:-1]) > TICKED)


def _spread(times: IntArray, tick: float) -> tuple[IntArray, bool]:
    """Return even times where all stamps lie within one tick of them."""
    numbers = np.arange(times.size)
    since = (times - times[0]).astype(np.float64)
    slope, offset = np.polyfit(numbers, since, 1)
    line = slope * numbers + offset
    if tick == 0.0 or np.ptp(since - line) > 1.5 * tick:
        return times, False
    return times[0] + np.rint(line).astype(np.int64), True


def _tell_ticks(name: str, tick: float, times: IntArray, even: bool) -> str:
    said = f"the stamps of {name} come in steps of {_size(tick)}, several messages to a step"
    if not even:
        return said
    rate = NANOSECONDS * (times.size - 1) / max(float(times[-1] - times[0]), 1.0)
    return (
        f"{said}: they are taken as even, {rate:.6g} Hz, and known to half a step, which may shift "
        f"the damping by {tick / 2 / NANOSECONDS:.3g} s times the stiffness"
    )


def _with_delays(name: str, found: ClockedTimes, delays: FloatArray) -> ClockedTimes:
    """Add the estimates from the delays: level, drift, jitter."""
    drift, error = _slope(found.times, delays)
    delay = float(np.median(delays))
    for first in range(0, delays.size, BLOCKS_TOGETHER):
        piece = slice(first, first + BLOCKS_TOGETHER)
        delays[piece] -= drift * (found.times[piece] - found.times[0])
    least, low, high = np.quantile(delays, [LEAST_QUANTILE, 0.05, 0.95], overwrite_input=True)
    notes = list(found.notes)
    if high - low > SHIFT_WORTH_TELLING:
        notes.append(
            f"the delays of {name} vary by {_size(high - low)}; it goes by its stamps, which do not"
        )
    return replace(
        found,
        delay=delay,
        least_delay=float(least),
        drift=drift,
        drift_error=error,
        jitter=float(high - low),
        notes=tuple(notes),
    )


def _slope(times: IntArray | FloatArray, delays: FloatArray) -> tuple[float, float]:
    """Return the slope of the median delays of blocks, and its standard error."""
    blocks = delays.size // BLOCK_MESSAGES
    if blocks < 4:
        return 0.0, np.inf
    # Blocks of times have their middle between two of them, which is their median.
    middle = times[: blocks * BLOCK_MESSAGES].reshape(blocks, BLOCK_MESSAGES)[
        :, BLOCK_MESSAGES // 2 - 1 : BLOCK_MESSAGES // 2 + 1
    ]
    t, d = (middle - times[0]).mean(axis=1), _block_medians(delays)
    t = t - t.mean()
    power = float(t @ t)
    if power == 0.0:
        return 0.0, np.inf
    slope = float(t @ (d - d.mean())) / power
    rest = d - d.mean() - slope * t
    return slope, float(np.sqrt(rest @ rest / (blocks - 2) / power))


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _size(nanoseconds: float) -> str:
    milliseconds = abs(nanoseconds) / 1e6
    return f"{milliseconds / 1e3:.4g} s" if milliseconds >= 1e3 else f"{milliseconds:.4g} ms"
