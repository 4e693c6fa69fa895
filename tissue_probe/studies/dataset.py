"""The rows of a study on disk: a folder of Parquet files, one a batch.

Programs that read such a folder leave out files whose names begin with ``_``.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any
from uuid import uuid4

import pyarrow as pa
import pyarrow.parquet as pq
from pyarrow.csv import write_csv

from tissue_probe.errors import FileError


class Dataset:
    """A folder of rows; a file is there as a whole, or not at all.

    Parameters
    ----------
    folder : path
        It is made with the first batch.

    Attributes
    ----------
    damaged : list of path
        Files that could not be read; they were set aside under another ending.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.damaged: list[Path] = []

    def write(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Add a batch of rows.

        Raises
        ------
        FileError
            If the disk is full, or the folder cannot be written.
        """
        if rows:
            self._put(rows, self.folder / f"rows-{uuid4().hex}.parquet")

    def _put(self, rows: Sequence[Mapping[str, Any]], file: Path) -> None:
        unfinished = self.folder / f"_unfinished-{file.name}"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            pq.write_table(_table(rows), unfinished)
            os.replace(unfinished, file)
        except OSError as error:
            unfinished.unlink(missing_ok=True)
            raise FileError(f"{self.folder}: rows cannot be written: {error}") from error

    def forget(self, paths: Collection[str]) -> None:
        """Take away the rows of some recordings, so that none is there twice."""
        for file in self.folder.glob("rows-*.parquet") if paths else ():
            rows = pq.read_table(file).to_pylist()
            left = [each for each in rows if each["path"] not in paths]
            if not left:
                file.unlink()
            elif len(left) < len(rows):
                self._put(left, file)  # in its place at once: no row is there twice meanwhile

    def read(self) -> list[dict[str, Any]]:
        """Return all rows; a file that is damaged is set aside, and its rows are missing."""
        rows: list[dict[str, Any]] = []
        for file in sorted(self.folder.glob("rows-*.parquet")):
            rows += self._rows(file)
        return [{name: value for name, value in row.items() if value is not None} for row in rows]

    def _rows(self, file: Path) -> list[dict[str, Any]]:
        try:
            rows: list[dict[str, Any]] = pq.read_table(file).to_pylist()
        except (pa.ArrowException, OSError):
            aside = self.folder / f"_damaged-{file.stem}"
            os.replace(file, aside)
            self.damaged.append(aside)
            return []
        return rows


def write_tables(folder: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write all rows as one table, ``table.csv`` and ``table.parquet``.

    Raises
    ------
    FileError
        If they cannot be written.
    """
    table = _table(rows)
    try:
        for name, write in (("table.parquet", pq.write_table), ("table.csv", write_csv)):
            write(table, folder / f"_unfinished-{name}")
            os.replace(folder / f"_unfinished-{name}", folder / name)
    except OSError as error:
        raise FileError(f"{folder}: the table cannot be written: {error}") from error


def _table(rows: Sequence[Mapping[str, Any]]) -> pa.Table:
    """Return rows as columns; a value that a row has not is null."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return pa.table({name: [row.get(name) for row in rows] for name in names})
