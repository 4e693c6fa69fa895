"""Columns of Parquet files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tissue_probe.recording.columns.bounds import check_rows
from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError


def open_parquet(path: Path) -> Columns:
    """Open a Parquet file; columns of timestamps become dates.

    Raises
    ------
    RecordingError
        If it is none, or too long.
    """
    from pyarrow import ArrowException, parquet

    try:
        file = parquet.ParquetFile(path)
    except (ArrowException, OSError) as error:
        raise RecordingError(f"{path} is not a Parquet file: {error}") from error
    check_rows(path, file.metadata.num_rows)

    def load(names: Sequence[str], progress: Progress) -> Loaded:
        return Loaded([_column(path, file, name) for name in names])

    return Columns(path, tuple(file.schema_arrow.names), load)


def _column(path: Path, file, name: str) -> np.ndarray:
    """Read a column, one group of rows after the other, so that it is in memory once."""
    import pyarrow

    kind = file.schema_arrow.field(name).type
    if pyarrow.types.is_timestamp(kind):
        into, dtype = pyarrow.timestamp("ns"), "datetime64[ns]"
    elif pyarrow.types.is_integer(kind):
        into, dtype = None, None
    else:
        into, dtype = pyarrow.float64(), np.float64
    parts = []
    try:
        for batch in file.iter_batches(batch_size=2**20, columns=[name], use_threads=False):
            column = batch.column(0)
            if isinstance(column, pyarrow.StructArray | pyarrow.ListArray):
                raise RecordingError(f"{path}: column {name} has no numbers: it is nested")
            if pyarrow.types.is_string(kind) and dtype is np.float64:
                parts.append(np.array(column.to_pylist(), dtype=object))
                continue
            if into is not None and kind != into:
                column = column.cast(into, safe=False) if dtype != np.float64 else column.cast(into)
            parts.append(column.to_numpy(zero_copy_only=False))
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(f"{path}: column {name} cannot be read: {error}") from error
    whole = np.concatenate(parts) if parts else np.empty(0)
    if whole.dtype == object:
        return whole
    return whole.astype(dtype) if dtype else whole
