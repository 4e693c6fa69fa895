"""One cell of a table: a number, a time, a word for a value not known, or text.

Contents: telling them apart, and their values.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Sequence
from enum import Enum

import numpy as np

Cell = object
"""A text, or as a spreadsheet has it: a number, a date, a time of the day, a duration."""


class CellKind(Enum):
    """The kind of a cell's content."""

    NUMBER = "number"
    TIME = "time"
    UNKNOWN = "unknown"
    TEXT = "text"


UNKNOWN_CELLS = (
    "", "nan", "-nan", "+nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "---", "1.#qnan",
    "-1.#ind", "#value!", "#div/0!",
)  # fmt: skip
"""Words that programs write for an unknown value, in lower case."""

UNKNOWN_SPELT = tuple(
    dict.fromkeys(
        form for word in UNKNOWN_CELLS for form in (word, word.upper(), word.title(), "NaN")
    )
)
"""The same as they are spelt, for readers that tell cases apart."""

_NUMBER = {
    ".": re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?|[+-]?inf(inity)?", re.IGNORECASE),
    ",": re.compile(r"[+-]?(\d+(,\d+)?|,\d+)([eEdD][+-]?\d+)?|[+-]?inf(inity)?", re.IGNORECASE),
}
_WHOLE = re.compile(r"[+-]?\d+")
#: Minutes and seconds without hours are told from hours and minutes by their fraction.
_CLOCK = re.compile(r"(?:(\d{1,3}):(?=\d\d:)|(?=\d{1,4}:\d\d[.,]))(\d{1,4}):(\d\d(?:[.,]\d+)?)")
_DATE = re.compile(
    r"(?P<date>\d{1,4}[-./]\d{1,2}[-./]\d{1,4})[T ,]+"
    r"(?P<clock>\d{1,2}:\d\d:\d\d(?:[.,]\d+)?)\s*(?P<half>[AP]M)?"
    r"\s*(?P<zone>Z|UTC|[+-]\d\d:?\d\d)?",
    re.IGNORECASE,
)
_ISO = re.compile(r"\d{4}-\d\d-\d\d")


def kind(cell: Cell, decimal: str = ".") -> CellKind:
    """Return the kind of a cell's content, where ``decimal`` is the decimal mark."""
    if isinstance(cell, str):
        text = cell.strip()
        if text.casefold() in UNKNOWN_CELLS:
            return CellKind.UNKNOWN
        if _NUMBER[decimal].fullmatch(text):
            return CellKind.NUMBER
        return CellKind.TIME if _CLOCK.fullmatch(text) or _DATE.fullmatch(text) else CellKind.TEXT
    if cell is None:
        return CellKind.UNKNOWN
    if isinstance(cell, int | float):
        return CellKind.NUMBER
    return CellKind.TIME


def is_whole(cell: Cell) -> bool:
    """Whether a cell is a whole number, written as such."""
    return isinstance(cell, str) and _WHOLE.fullmatch(cell.strip()) is not None


def number(cell: Cell, decimal: str = ".") -> float | int:
    """Return a cell's number; NaN where it is not known; ValueError where it is neither."""
    if not isinstance(cell, str):
        if isinstance(cell, int | float):
            return cell
        if cell is None:
            return np.nan
        raise ValueError(str(cell))
    text = cell.strip()
    if text.casefold() in UNKNOWN_CELLS:
        return np.nan
    if not _NUMBER[decimal].fullmatch(text):
        raise ValueError(text)
    if _WHOLE.fullmatch(text) and len(text) < 19:
        return int(text)
    return float(text.replace(decimal, ".").upper().replace("D", "E"))


def times(cells: Sequence[Cell]) -> np.ndarray:
    """Return times of the day as ``timedelta64[ns]``, dates as ``datetime64[ns]``; NaT if unknown.

    Dates with a time zone become those of UTC. Those without one keep the clock that they tell.

    Raises
    ------
    ValueError
        If a cell tells no time, or tells it otherwise than the first, as with a zone where that
        has none; the message is the cell.
    """
    first = next((cell for cell in cells if kind(cell) is CellKind.TIME), "")
    dated = not isinstance(first, datetime.time | datetime.timedelta) and not (
        isinstance(first, str) and _CLOCK.fullmatch(first.strip())
    )
    unknown = np.datetime64("NaT") if dated else np.timedelta64("NaT")
    zoned = _has_zone(first)

    def time(cell: Cell) -> np.datetime64 | np.timedelta64:
        if kind(cell) is CellKind.UNKNOWN:
            return unknown
        if _has_zone(cell) is not zoned:
            raise ValueError(str(cell))
        return _date(cell) if dated else _clock(cell)

    values = [time(cell) for cell in cells]
    return np.array(values, dtype="datetime64[ns]" if dated else "timedelta64[ns]")


def _has_zone(cell: Cell) -> bool:
    """Whether a date tells its time zone."""
    if isinstance(cell, datetime.datetime):
        return cell.utcoffset() is not None
    found = _DATE.fullmatch(cell.strip()) if isinstance(cell, str) else None
    return found is not None and found["zone"] is not None


def _clock(cell: Cell) -> np.timedelta64:
    if isinstance(cell, datetime.time):
        cell = datetime.timedelta(
            hours=cell.hour,
            minutes=cell.minute,
            seconds=cell.second,
            microseconds=cell.microsecond,
        )
    if isinstance(cell, datetime.timedelta):
        return np.timedelta64(cell, "ns")
    found = _CLOCK.fullmatch(str(cell).strip())
    if found is None:
        raise ValueError(str(cell))
    return np.timedelta64(_nanoseconds(*found.groups()), "ns")


def _nanoseconds(hours: str | None, minutes: str, seconds: str) -> int:
    whole, _, fraction = seconds.replace(",", ".").partition(".")
    return (int(hours or 0) * 3600 + int(minutes) * 60 + int(whole)) * 10**9 + int(
        (fraction + "0" * 9)[:9]
    )


def _date(cell: Cell) -> np.datetime64:
    if isinstance(cell, datetime.datetime):
        ahead = cell.utcoffset() or datetime.timedelta()
        naive = cell.replace(tzinfo=None)
        return np.datetime64(naive, "ns") - np.timedelta64(ahead, "ns")
    if isinstance(cell, datetime.date):
        return np.datetime64(cell, "ns")
    found = _DATE.fullmatch(str(cell).strip())
    clock = _CLOCK.fullmatch(found["clock"]) if found else None
    if found is None or clock is None:
        raise ValueError(str(cell))
    since = _nanoseconds(*clock.groups())
    if half := found["half"]:
        since += (half.upper() == "PM") * 43_200 * 10**9 - (clock[1] == "12") * 43_200 * 10**9
    zone = found["zone"] or "Z"
    if zone[0] in "+-":
        digits = zone.replace(":", "")
        offset = (int(digits[1:3]) * 60 + int(digits[3:5])) * 60 * 10**9
        since -= offset if digits[0] == "+" else -offset
    return np.datetime64(_day(found["date"]), "ns") + np.timedelta64(since, "ns")


def _day(text: str) -> str:
    """Return a date as ISO 8601 has it; ValueError where day and month may be exchanged."""
    if _ISO.fullmatch(text):
        return text
    parts = re.split(r"[-./]", text)
    if len(parts[0]) == 4:
        year, month, day = parts
    else:
        first, second, year = parts
        if "." in text or int(first) > 12:  # dots: day, month, year
            day, month = first, second
        elif int(second) > 12 or first == second:
            month, day = first, second
        else:
            raise ValueError(text)
    return f"{int(year):04d}-{int(month):02d}-{int(day):02d}"
