"""Columns that are in memory already: arrays by name, or a data frame of pandas or polars.

Contents: turning these into ``Columns``.
"""

from __future__ import annotations

import datetime
from collections.abc import Mapping, Sequence
from decimal import Decimal
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from tissue_probe.recording.columns.cells import CellKind, kind, times
from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError

#: Types that tell a time: texts do, too.
_TIMES = (str, datetime.date, datetime.time, datetime.timedelta)


def columns_in_memory(table: Any, name: str) -> Columns:
    """Return the columns of a data frame, a structured array, or a mapping of arrays.

    Neither pandas nor polars is imported: both give columns by ``table[name]``.

    Parameters
    ----------
    table : mapping of array, structured array, pandas.DataFrame or polars.DataFrame
        Columns of one length; names are texts.
    name : str
        Its name in messages.

    Raises
    ------
    RecordingError
        If it is none of these.
    """
    if isinstance(table, Mapping):
        names = list(table)
    elif isinstance(table, np.ndarray) and table.dtype.names:
        names = list(table.dtype.names)
    elif hasattr(table, "columns") and hasattr(table, "__getitem__"):
        names = list(table.columns)
    else:
        raise RecordingError(
            f"{type(table).__name__} cannot be read: give the path of a file, a data frame, or "
            'arrays by name, such as {"t": ..., "u": ..., "F": ...}'
        )
    if unnamed := [each for each in names if not isinstance(each, str)]:
        raise RecordingError(f"{name}: names of columns are texts, but one is {unnamed[0]!r}")

    def load(wanted: Sequence[str], progress: Progress) -> Loaded:
        return Loaded([_column(table[each], f"{name}: column {each}") for each in wanted])

    return Columns(Path(name), tuple(names), load)


def _column(values: Any, place: str) -> np.ndarray:
    """Return an own copy of a column, as the readers of files give it.

    Masked values are missing. Times with a zone become those of UTC, texts that tell times become
    times.
    """
    array = _missing_told(values, _array(values, place), place)
    if array.ndim != 1:
        raise RecordingError(f"{place} has the shape {array.shape}: give one value a row")
    if array.dtype.kind == "M":
        return _in_nanoseconds(array, place)
    if array.dtype.kind in "OUST":
        return _of_objects(array, place)
    if array.dtype.kind not in "fium":
        called = {"b": "truths", "c": "complex numbers"}.get(array.dtype.kind, "no numbers")
        raise RecordingError(f"{place} holds {called}: give numbers")
    return array


def _array(values: Any, place: str) -> np.ndarray:
    """Return an own copy of any column as an array."""
    typed = getattr(values, "dtype", None)
    if typed is None and not isinstance(values, str):
        try:
            truths = bool in map(type, values)
        except TypeError:
            truths = False
        if truths:  # NumPy would take them for 0 and 1 among numbers
            raise RecordingError(f"{place} holds truths: give numbers")
    # Of pandas: as objects, times with a zone would lose their nanoseconds.
    zoned = str(typed).startswith(("datetime64[", "timestamp["))
    try:
        return np.array(values, dtype="datetime64[ns]" if zoned else None)
    except (TypeError, ValueError, OverflowError):
        raise RecordingError(f"{place} has no column's shape: give one value a row") from None


def _missing_told(values: Any, array: np.ndarray, place: str) -> np.ndarray:
    """Return an array in which masked values are missing."""
    if not np.ma.is_masked(values):
        return array
    kept = array.astype(np.float64) if array.dtype.kind in "iu" else array
    if kept.dtype.kind not in "fmM":
        raise RecordingError(f"{place} is masked, and holds things that are no numbers")
    kept[np.ma.getmaskarray(values)] = np.nan if kept.dtype.kind == "f" else "NaT"
    return kept


def _in_nanoseconds(array: np.ndarray, place: str) -> np.ndarray:
    """Return dates in nanoseconds, in which no others are known than of 1678 to 2261."""
    found = array.astype("datetime64[ns]")
    if not np.array_equal(found.astype(array.dtype), array, equal_nan=True):
        raise RecordingError(f"{place} has dates that no record has: give those of 1678 to 2261")
    return found


def _of_objects(array: np.ndarray, place: str) -> np.ndarray:
    """Return numbers, or times, of a column that holds objects or texts."""
    cells = [None if _is_missing(each) else each for each in array.tolist()]
    told = [each for each in cells if each is not None]
    if told and all(kind(each) is CellKind.TIME and isinstance(each, _TIMES) for each in told):
        try:
            return times(cells)
        except (ValueError, OverflowError) as error:
            raise RecordingError(
                f"{place} tells the time '{error}' otherwise than its first"
            ) from None
    for each in told:
        if isinstance(each, (bool, np.bool_)) or not isinstance(each, (Real, Decimal)):
            raise RecordingError(f"{place} holds {_describe_value(each)}: give numbers")
    try:
        return np.array([np.nan if each is None else each for each in cells], dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise RecordingError(f"{place} holds things that are no numbers") from None


def _is_missing(value: object) -> bool:
    """Whether a value is not known: None, a word that programs write for it, or pandas' own."""
    return kind(value) is CellKind.UNKNOWN or type(value).__name__ in ("NAType", "NaTType")


def _describe_value(value: object) -> str:
    """Describe a value in a column that is no number."""
    if isinstance(value, str):
        return f"texts, such as {value[:20]!r}"
    return f"things that are no numbers ({type(value).__name__})"
