"""Named columns of numbers out of CSV, Parquet and MATLAB files.

What belongs here: the formats.
What does not: what the columns mean (``csv_file``, ``table_file``).
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import FloatArray

FORMATS = (".csv", ".parquet", ".mat")
"""How the names of files with columns end."""

# pyarrow, scipy.io and h5py are imported where they are used: they take long to load


def column_names(path: str | Path) -> list[str]:
    """Return the names of a file's columns, for MATLAB those of its vectors of numbers.

    Fields of a structure have dotted names: ``run.force``.

    Raises
    ------
    RecordingError
        If the file is not what its name's end says.
    """
    path = Path(path)
    match path.suffix.lower():
        case ".csv":
            return _csv_names(path)
        case ".parquet":
            return _parquet_names(path)
        case _:
            return list(_matlab_vectors(path))


def read_columns(path: str | Path, names: Sequence[str]) -> list[FloatArray]:
    """Read columns by their names, each of shape (n,), all of one length.

    An empty cell is NaN.

    Parameters
    ----------
    path : path
        Ends in ``.csv`` (UTF-8, cells separated by commas, decimal points, a header line),
        ``.parquet`` or ``.mat`` (any version).
    names : sequence of str
        Columns, as in the file.

    Raises
    ------
    RecordingError
        If the file is not what its name's end says, a column is missing, has another length than
        the others or no numbers, or there are no rows.
    """
    path = Path(path)
    match path.suffix.lower():
        case ".parquet":
            return _parquet(path, names)
        case ".mat":
            return _matlab(path, names)
        case _:
            return _csv(path, names)


def require_columns(path: Path, names: Sequence[str], available: Sequence[str]) -> None:
    """Check that a file has columns of these names.

    Raises
    ------
    RecordingError
        If one is not among those available.
    """
    if missing := [name for name in names if name not in available]:
        raise RecordingError(
            f"{path} has no column {', '.join(missing)}; "
            f"its columns are {', '.join(available) or 'none: it is empty'}"
        )


def _csv_names(path: Path) -> list[str]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return _header(path, csv.reader(file))
    except (UnicodeDecodeError, csv.Error) as error:
        raise RecordingError(f"{path} is not a CSV file in UTF-8: {error}") from error


def _header(path: Path, rows: Iterator[list[str]]) -> list[str]:
    names = [name.strip() for name in next(rows, [])]
    for other, called in ((";", "semicolons"), ("\t", "tabs")):
        if len(names) == 1 and other in names[0]:
            raise RecordingError(
                f"{path} separates its cells by {called}; write it with commas, and numbers with "
                "decimal points"
            )
    return names


def _csv(path: Path, names: Sequence[str]) -> list[FloatArray]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return _numbers(path, csv.reader(file), names)
    except (UnicodeDecodeError, csv.Error) as error:
        raise RecordingError(f"{path} is not a CSV file in UTF-8: {error}") from error


def _numbers(path: Path, rows: Iterator[list[str]], names: Sequence[str]) -> list[FloatArray]:
    header = _header(path, rows)
    require_columns(path, names, header)
    places = [header.index(name) for name in names]
    numbers = [
        [_number(path, line, header, row, place) for place in places]
        for line, row in enumerate(rows, start=2)
        if row
    ]
    if not numbers:
        raise RecordingError(f"{path} has a header line, but no rows below it")
    return list(np.array(numbers).T.copy())


def _number(path: Path, line: int, header: list[str], row: list[str], place: int) -> float:
    if place >= len(row):
        raise RecordingError(
            f"{path}, line {line}: {len(row)} cells, but the header names {len(header)} columns"
        )
    try:
        return float(row[place]) if row[place].strip() else np.nan
    except ValueError:
        raise RecordingError(
            f"{path}, line {line}: column {header[place]} is '{row[place]}'; give a number"
        ) from None


def _parquet_names(path: Path) -> list[str]:
    from pyarrow import ArrowException, parquet

    try:
        return list(parquet.read_schema(path).names)
    except ArrowException as error:
        raise RecordingError(f"{path} is not a Parquet file: {error}") from error


def _parquet(path: Path, names: Sequence[str]) -> list[FloatArray]:
    from pyarrow import ArrowException, float64, parquet

    require_columns(path, names, _parquet_names(path))
    columns = []
    for name in names:
        try:
            column = parquet.read_table(path, columns=[name]).column(0).cast(float64())
        except ArrowException as error:
            raise RecordingError(f"{path}: column {name} has no numbers: {error}") from error
        columns.append(column.to_numpy().astype(np.float64))
    if not columns[0].size:
        raise RecordingError(f"{path} has columns, but no rows")
    return columns


def _matlab(path: Path, names: Sequence[str]) -> list[FloatArray]:
    vectors = _matlab_vectors(path)
    require_columns(path, names, list(vectors))
    columns = [vectors[name] for name in names]
    if len({column.size for column in columns}) > 1:
        lengths = ", ".join(f"{name} has {vectors[name].size}" for name in names)
        raise RecordingError(f"{path}: columns must have one length, but {lengths} values")
    return columns


def _matlab_vectors(path: Path) -> dict[str, FloatArray]:
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        content = loadmat(path, simplify_cells=True)
    except NotImplementedError:  # version 7.3 is HDF5
        content = _hdf5(path)
    except (MatReadError, ValueError, TypeError) as error:
        raise RecordingError(f"{path} is not a MATLAB file: {error}") from error
    return dict(_vectors(content))


def _hdf5(path: Path) -> dict[str, object]:
    from h5py import Dataset, File

    content: dict[str, object] = {}

    def collect(name: str, found: object) -> None:
        if isinstance(found, Dataset) and not name.startswith("#"):
            content[name.replace("/", ".")] = found[()]

    try:
        with File(path) as file:
            file.visititems(collect)
    except OSError as error:
        raise RecordingError(f"{path} is not a MATLAB file: {error}") from error
    return content


def _vectors(content: Mapping[str, object], inside: str = "") -> Iterator[tuple[str, FloatArray]]:
    """Yield the vectors of more than one number, those of structures too."""
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _vectors(value, f"{inside}{name}.")
        elif isinstance(value, np.ndarray) and _is_vector(value):
            yield inside + name, value.ravel().astype(np.float64)


def _is_vector(array: np.ndarray) -> bool:
    return array.dtype.kind in "fiub" and array.size > 1 and array.size == max(array.shape)
