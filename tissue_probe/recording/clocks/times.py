"""Times as files tell them, in seconds.

Contents: dates, clocks, epochs in any unit, counters of time; and times that are ambiguous.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from tissue_probe.recording.clocks.counters import unwrap_counter
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.units import TIME_UNITS
from tissue_probe.signals import NANOSECONDS, FloatArray

EPOCH = 6e8, 4.2e9
"""Seconds since 1970 of the dates that are taken for such, 1989 to 2103. In ms, us and ns they lie
in other ranges, so that a number tells its unit."""

LATEST_DATE = 1e10
"""More seconds than any date has: three centuries."""

_TURNS = {86_400.0: "midnight", 3_600.0: "a full hour"}
"""After how long a clock begins anew [s]. One set back in autumn goes on as if it had not been."""
_TELLING = ("s", "ms", "us", "ns")


class Times(NamedTuple):
    """Times [s] since ``origin`` [ns since the epoch, 0 where the file has a zero of its own].

    NaN where not known. Their reading is told in phrases.
    """

    origin: int
    seconds: FloatArray
    told: tuple[str, ...] = ()


def times(column: np.ndarray, name: str, unit: str | None, certain: bool, where: str) -> Times:
    """Return a column of times in seconds.

    Parameters
    ----------
    column : array, shape (n,)
        Floats, whole numbers, ``datetime64`` or ``timedelta64``.
    name : str
        Of the column.
    unit : str, optional
        A name in ``TIME_UNITS``, where the name or the user tells one.
    certain : bool
        Whether the unit cannot be wrong: the user states it, or this suite wrote the file.
    where : str
        The file's name in messages.

    Raises
    ------
    RecordingError
        If the unit is ambiguous, or cannot be that of the name, or all times are the same.
    """
    if column.dtype.kind == "M":
        return _dates(column)
    if column.dtype.kind == "m":
        return _clock(column)
    _refuse_standing(column, name, where)
    told = []
    whole = column.dtype.kind in "iu"
    if unit is None:
        unit = _telling_epoch(column)
        if unit:
            told.append(f"{name} in {unit} since 1970")
        elif whole and not certain:
            raise RecordingError(
                f"{where}: column {name} counts whole numbers and tells no unit: seconds, "
                "milliseconds, samples? state `time_unit` "
                f"({', '.join(TIME_UNITS)}), or `sample_rate`"
            )
    size = TIME_UNITS[unit or "s"]
    latest = _latest(column)
    if not certain and size * latest > LATEST_DATE:
        raise RecordingError(
            f"{where}: column {name} would be in {unit or 's'}, but {latest:.6g} of these are "
            f"{size * latest / 3.156e7:.3g} years; state `time_unit` ({', '.join(TIME_UNITS)})"
        )
    if not whole:
        column, bits = unwrap_counter(column)
    elif bool((column[1:] < column[:-1]).any()):
        column, bits = unwrap_counter(column.astype(np.float64))
    else:
        bits = None
    if bits:
        told.append(f"{name} began again at 2^{bits} and is counted on")
    return _since(column, size, tuple(told))


def following_on(times: Times, blocks: Sequence[int], begins: Sequence[float] = ()) -> Times:
    """Return times of which those of each block follow on those of the block before.

    A block begins when the file says. Where its times begin anew and nothing tells how long the
    pause before it was, it is taken to begin one step of time after the block before, as machines
    run the steps of a protocol. A first row that repeats the last time of the block before has no
    time of its own.

    Parameters
    ----------
    times : Times
        Of all blocks.
    blocks : sequence of int
        First rows of the second block and of those after it.
    begins : sequence of float
        When these began after the first, where the file tells it [s].
    """
    if not blocks:
        return times  # a long column is not copied for nothing
    seconds, anew, twice, paused = times.seconds.copy(), 0, 0, 0
    for number, first in enumerate(blocks):
        known = np.isfinite(seconds)
        before, after = seconds[:first][known[:first]], seconds[first:][known[first:]]
        if not (before.size and after.size):
            continue
        begin = begins[number] if number < len(begins) else 0.0
        if np.isfinite(begin) and begin > 0.0 and after[0] + begin > before[-1]:
            stop = blocks[number + 1] if number + 1 < len(blocks) else seconds.size
            seconds[first:stop] += begin
            paused += 1
        elif after[0] == before[-1]:
            seconds[first:][np.argmax(known[first:])] = np.nan
            twice += 1
        elif after[0] < before[-1]:
            seconds[first:] += before[-1] + _step(before, after) - after[0]
            anew += 1
    told = [
        f"the times of {count} block{'s' if count > 1 else ''} {said}"
        for count, said in (
            (anew, "begin anew, and are taken to go on"),
            (paused, "count from when it began, as the file says"),
            (twice, "begin with the last one before, which is left out"),
        )
        if count
    ]
    return Times(times.origin, seconds, (*times.told, *told))


def _step(before: FloatArray, after: FloatArray) -> float:
    """Return the step of time at the end of a block, or where that has none, after it [s]."""
    if before.size > 1:
        return float(before[-1] - before[-2])
    return float(after[1] - after[0]) if after.size > 1 else 0.0


def _refuse_standing(column: np.ndarray, name: str, where: str) -> None:
    """Refuse times that are all the same."""
    known = column[np.isfinite(column)]
    if known.size > 1 and bool((known == known[0]).all()):
        raise RecordingError(
            f"{where}: time stands still: column {name} is {known[0]:g} in every row; give another "
            "column by `time`, or `sample_rate`"
        )


def _since(column: np.ndarray, size: float, told: tuple[str, ...]) -> Times:
    """Subtract the first of large times before they are scaled: digits would be lost."""
    known = np.isfinite(column)
    first = column[np.argmax(known)] if known.any() else 0
    if abs(float(first)) * size < EPOCH[0]:
        seconds = column.astype(np.float64, copy=False)
        return Times(0, seconds if size == 1.0 else seconds * size, told)
    origin = int(first) * round(size * NANOSECONDS)
    seconds = (column - int(first)).astype(np.float64)
    seconds *= size
    return Times(origin, seconds, told)


def _latest(column: np.ndarray) -> float:
    """Return the largest time that is known; minus infinity where none is."""
    return _extreme(np.max, column, -np.inf)


def _extreme(function: Callable[..., float], column: np.ndarray, otherwise: float) -> float:
    """Return the least or largest time that is known, of a column of any type."""
    known = np.isfinite(column)
    if not known.any():
        return otherwise
    return float(function(column, where=known, initial=column[np.argmax(known)]))


def _telling_epoch(column: np.ndarray) -> str | None:
    low = _extreme(np.min, column, np.inf)
    high = _latest(column)
    for unit in _TELLING:
        if EPOCH[0] <= low * TIME_UNITS[unit] and high * TIME_UNITS[unit] <= EPOCH[1]:
            return unit if high > 0.0 else None
    return None


def _dates(column: np.ndarray) -> Times:
    known = np.flatnonzero(~np.isnat(column))
    if not known.size:
        return Times(0, np.full(column.size, np.nan))
    first = column[known[0]].astype("datetime64[ns]")
    seconds = (column.astype("datetime64[ns]") - first) / np.timedelta64(1, "s")
    return Times(int(first.astype(np.int64)), seconds.astype(np.float64))


def _clock(column: np.ndarray) -> Times:
    """Return times of a clock that begins anew: at midnight, or each hour where it shows none."""
    seconds = (column / np.timedelta64(1, "s")).astype(np.float64)
    known, told = np.flatnonzero(np.isfinite(seconds)), []
    for turn, word in _TURNS.items():
        back = -np.diff(seconds[known])
        turns = np.cumsum((back > turn / 2.0) & (back <= turn))
        if turns.size and turns[-1]:
            seconds[known[1:]] += turn * turns
            told.append(f"the clock passed {word}")
    return Times(0, seconds, tuple(told))
