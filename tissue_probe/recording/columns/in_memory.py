"""Columns that are in memory already: arrays by name, or a data frame of pandas or polars.

What belongs here: turning these into ``Columns``. What does not: files.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError


def columns_in_memory(table: Any, name: str) -> Columns:
    """Return the columns of a data frame, a structured array, or a mapping of arrays.

    Neither pandas nor polars is imported: both give columns by ``table[name]``.

    Parameters
    ----------
    table : mapping of array, structured array, pandas.DataFrame or polars.DataFrame
        Columns of one length; names are texts.
    name : str
        What messages call it.

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

    Masked values are missing.
    """
    array = np.array(values)
    if np.ma.is_masked(values):
        kept = array.astype(np.float64) if array.dtype.kind in "biu" else array.copy()
        if kept.dtype.kind not in "fmM":
            raise RecordingError(f"{place} is masked, and holds things that are no numbers")
        kept[np.ma.getmaskarray(values)] = np.nan if kept.dtype.kind == "f" else "NaT"
        array = kept
    if array.ndim != 1:
        raise RecordingError(f"{place} has the shape {array.shape}: give one value a row")
    if array.dtype.kind == "M":
        return array.astype("datetime64[ns]")
    if array.dtype.kind == "O":
        try:
            return array.astype(np.float64)
        except (TypeError, ValueError):
            raise RecordingError(f"{place} holds things that are no numbers") from None
    return array
