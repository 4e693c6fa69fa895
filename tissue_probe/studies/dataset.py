"""The rows of a study on disk: a folder of Parquet files, one a batch.

Programs that read such a folder leave out files whose names begin with ``_``.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from pyarrow.csv import write_csv

from tissue_probe.errors import FileError
from tissue_probe.one_line import sentence


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

        The file's name comes from the recordings in it: a batch that is written a second time, as
        after an interrupt, is there once.

        Raises
        ------
        FileError
            If the disk is full, or the folder cannot be written; the folder is then as before.
        """
        if rows:
            paths = "\n".join(str(each["path"]) for each in rows)
            name = hashlib.sha256(paths.encode()).hexdigest()
            self._put(rows, self.folder / f"rows-{name}.parquet")

    def _put(self, rows: Sequence[Mapping[str, Any]], file: Path) -> None:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(f"{self.folder}: it cannot be made: {sentence(error)}") from error
        _write_whole(pq.write_table, _table(rows), file)

    def amend(self, changed: Mapping[str, Mapping[str, Any] | None]) -> None:
        """Put other rows in the place of some recordings' rows, or take these away (None).

        Each file is replaced at once: meanwhile no row is missing, and none is there twice.

        Raises
        ------
        FileError
            If the disk is full, or a file cannot be written.
        """
        for file in self._files() if changed else ():
            rows = self._rows(file)
            left = [changed.get(each["path"], each) for each in rows]
            if left == rows:
                continue
            if kept := [each for each in left if each is not None]:
                self._put(kept, file)
            else:
                file.unlink()

    def read(self) -> list[dict[str, Any]]:
        """Return all rows; a file that is damaged is set aside, and its rows are missing."""
        return [each for file in self._files() for each in self._rows(file)]

    def _files(self) -> list[Path]:
        return sorted(self.folder.glob("rows-*.parquet"))

    def _rows(self, file: Path) -> list[dict[str, Any]]:
        try:
            # Not by ``read_table``, which looks for a data set of many files each time.
            with pq.ParquetFile(file) as opened:
                table = opened.read(use_threads=False)
        except (pa.ArrowException, OSError):
            aside = self.folder / f"_damaged-{file.stem}"
            os.replace(file, aside)
            self.damaged.append(aside)
            return []
        rows = table.to_pylist()
        return [{name: value for name, value in row.items() if value is not None} for row in rows]


def write_tables(folder: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write all rows as one table, ``table.csv`` and ``table.parquet``.

    Raises
    ------
    FileError
        If they cannot be written.
    """
    table = _table(rows)
    for name, write in (("table.parquet", pq.write_table), ("table.csv", write_csv)):
        _write_whole(write, table, folder / name)


def _write_whole(write: Callable[[pa.Table, Path], None], table: pa.Table, file: Path) -> None:
    """Write a file as a whole, or leave all as it was."""
    unfinished = file.with_name(f"_unfinished-{file.name}")
    try:
        write(table, unfinished)
        os.replace(unfinished, file)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise FileError(
            f"{file} cannot be written: {_reason(error)}; all that was written before is kept: run "
            "the study again once there is room"
        ) from error


def _reason(error: OSError) -> str:
    """Return the system's own words; pyarrow's have its calls around them."""
    return os.strerror(error.errno) if error.errno else sentence(error)


def _table(rows: Sequence[Mapping[str, Any]]) -> pa.Table:
    """Return rows as columns; a value that a row has not is null."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return pa.table({name: [row.get(name) for row in rows] for name in names})
