"""Columns of Parquet files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tissue_probe.recording.columns.bounds import check_rows
from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError

if TYPE_CHECKING:
    import pyarrow
    from pyarrow.parquet import ParquetFile

_PIECE = 2**20  # bytes of a column that are read at a time


def open_parquet(path: Path) -> Columns:
    """Open a Parquet file; columns of timestamps become dates.

    Raises
    ------
    RecordingError
        If it is none, or too long.
    """
    from pyarrow import ArrowException, default_memory_pool, parquet

    try:
        # In pieces: by default a row group, which may be all of the file, is in memory as it lies.
        file = parquet.ParquetFile(path, buffer_size=_PIECE, pre_buffer=False)
    except (ArrowException, OSError) as error:
        raise RecordingError(f"{path} is not a Parquet file: {error}") from error
    check_rows(path, file.metadata.num_rows)

    def load(names: Sequence[str], progress: Progress) -> Loaded:
        columns = []
        for number, name in enumerate(names, 1):
            columns.append(_column(path, file, name))
            default_memory_pool().release_unused()  # it keeps a hundred megabytes otherwise
            progress(number / len(names))
        return Loaded(columns)

    return Columns(path, tuple(file.schema_arrow.names), load, _units(file.schema_arrow))


def _units(schema: pyarrow.Schema) -> dict[str, str]:
    """Return the units that the metadata of fields tell, as ``unit`` or ``units``."""
    told = {
        field.name: {key.lower(): value for key, value in (field.metadata or {}).items()}
        for field in schema
    }
    units = {name: each.get(b"units", each.get(b"unit", b"")) for name, each in told.items()}
    return {name: unit.decode(errors="replace") for name, unit in units.items() if unit}


def _column(path: Path, file: ParquetFile, name: str) -> np.ndarray:
    """Read a column piece by piece, so that it is in memory once."""
    import pyarrow

    kind = file.schema_arrow.field(name).type
    dtype: np.dtype[Any] | None
    if pyarrow.types.is_timestamp(kind):
        into, dtype = pyarrow.timestamp("ns"), np.dtype("datetime64[ns]")
    elif pyarrow.types.is_integer(kind):
        into, dtype = None, None
    else:
        into, dtype = pyarrow.float64(), np.dtype(np.float64)
    rows = file.metadata.num_rows
    texts = pyarrow.types.is_string(kind) or pyarrow.types.is_large_string(kind)
    whole: np.ndarray | None = np.empty(rows, dtype=object if texts else dtype) if dtype else None
    first = 0
    try:
        for batch in file.iter_batches(batch_size=2**20, columns=[name], use_threads=False):
            column = batch.column(0)
            if texts:
                part = np.array(column.to_pylist(), dtype=object)
            elif isinstance(column, pyarrow.StructArray | pyarrow.ListArray):
                raise RecordingError(f"{path}: column {name} has no numbers: it is nested")
            else:
                if into is not None and kind != into:
                    column = column.cast(into, safe=dtype == np.float64)
                part = column.to_numpy(zero_copy_only=False)
            if whole is None or (part.dtype.kind == "f" and whole.dtype.kind in "iu"):
                # Whole numbers, until one is not known.
                whole = np.empty(rows, part.dtype) if whole is None else whole.astype(np.float64)
            whole[first : first + part.size] = part
            first += part.size
    except (pyarrow.ArrowException, OSError, ValueError, TypeError) as error:
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(f"{path}: column {name} cannot be read: {error}") from error
    if first != rows:
        raise RecordingError(f"{path}: column {name} has {first} rows, but the file says {rows}")
    return np.empty(0) if whole is None else whole
