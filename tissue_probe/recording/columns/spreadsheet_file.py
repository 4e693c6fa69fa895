"""Columns of spreadsheets: ``.xlsx``, ``.xls``, ``.ods`` and their kin."""

from __future__ import annotations

import re
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tissue_probe.recording.columns import cells
from tissue_probe.recording.columns.blocks import Blocks
from tissue_probe.recording.columns.bounds import check_size, check_zip
from tissue_probe.recording.columns.cells import CellKind
from tissue_probe.recording.columns.find_table import FoundTable, Row, find_table, longest_run
from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError


def open_spreadsheet(path: Path, members: zipfile.ZipFile | None) -> Columns:
    """Open a workbook: columns of the only table by their names, of several ``sheet!column``.

    Parameters
    ----------
    path : Path
        The file.
    members : ZipFile, optional
        The archive that it is.

    Raises
    ------
    RecordingError
        If it is none, expands to too much, or no sheet has a table.
    """
    if members is not None:
        check_zip(path, members)
        _check_repeats(path, members)
    sheets = _sheets(path)
    tables: dict[str, tuple[list[Row], FoundTable]] = {}
    for name, rows in sheets.items():
        if longest_run(rows, ".") is not None:
            tables[name] = (rows, find_table(f"{path}, sheet {name}", rows, "."))
    if not tables:
        raise RecordingError(f"{path} has no sheet with a table of numbers")
    several = len(tables) > 1
    names = {
        f"{sheet}!{column}" if several else column: (sheet, place)
        for sheet, (_, found) in tables.items()
        for place, column in enumerate(found.names)
        if column
    }
    units = {
        name: tables[sheet][1].units[place]
        for name, (sheet, place) in names.items()
        if tables[sheet][1].units and tables[sheet][1].units[place]
    }

    def load(wanted: Sequence[str], progress: Progress) -> Loaded:
        chosen = {names[name][0] for name in wanted}
        if len(chosen) > 1:
            raise RecordingError(
                f"{path}: the columns {', '.join(wanted)} are on several sheets, so that nothing "
                "tells which rows belong together; name columns of one sheet"
            )
        rows, found = tables[chosen.pop()]
        return _values(path, rows, found, {name: names[name][1] for name in wanted})

    told = () if several else next(iter(tables.values()))[1].told
    named = all(found.named for _, found in tables.values())
    return Columns(path, tuple(names), load, units, told, named=named)


def _sheets(path: Path) -> dict[str, list[Row]]:
    from python_calamine import CalamineError, CalamineWorkbook

    try:
        with CalamineWorkbook.from_path(str(path)) as book:
            return {
                name: [
                    Row(line, tuple(row))
                    for line, row in enumerate(
                        book.get_sheet_by_name(name).to_python(skip_empty_area=False), 1
                    )
                ]
                for name in book.sheet_names
            }
    except (CalamineError, OSError, ValueError) as error:
        raise RecordingError(f"{path} is not a spreadsheet that can be read: {error}") from error
    except BaseException as error:  # a panic of the reader is no Exception
        if type(error).__name__ != "PanicException":
            raise
        raise RecordingError(f"{path} is not a spreadsheet that can be read: {error}") from error


def _check_repeats(path: Path, members: zipfile.ZipFile) -> None:
    """Count the cells that an OpenDocument sheet repeats: a few bytes may stand for billions."""
    if "content.xml" not in members.namelist():
        return
    try:
        content = members.read("content.xml")
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise RecordingError(f"{path} is damaged: {error}") from error
    total = 0
    for row in re.split(rb"<table:table-row", content)[1:]:
        opening, _, inside = row.partition(b">")
        if b"office:value" not in inside and b"<text:p" not in inside:
            continue
        rows = re.search(rb'number-rows-repeated="(\d+)"', opening)
        columns = re.findall(rb'number-columns-repeated="(\d+)"[^>]*office:value', inside)
        total += int(rows[1] if rows else 1) * (1 + sum(map(int, columns))) * 50
        check_size(path, total)


def _values(path: Path, rows: Sequence[Row], found: FoundTable, places: dict[str, int]) -> Loaded:
    kept: list[Row] = []
    blocks = Blocks(path, found, ".", "row")
    for row in rows[found.first :]:
        if blocks.takes(row, len(kept)):
            kept.append(row)
    columns = [_column(path, name, place, kept) for name, place in places.items()]
    told = tuple(blocks.describe_blocks(len(kept)))
    return Loaded(columns, told, lambda row: f"row {kept[row].line}", blocks.begins(len(kept)))


def _column(path: Path, name: str, place: int, rows: Sequence[Row]) -> np.ndarray:
    values = [row.cells[place] for row in rows]
    kinds = {cells.kind(value) for value in values}
    if CellKind.TIME in kinds and CellKind.NUMBER not in kinds:
        try:
            return cells.times(values)
        except ValueError as error:
            raise RecordingError(
                f"{path}: column {name} tells the time '{error}' otherwise than its first"
            ) from None
    return np.array([_number(path, name, row, place) for row in rows], dtype=np.float64)


def _number(path: Path, name: str, row: Row, place: int) -> float:
    try:
        return cells.number(row.cells[place])
    except ValueError:
        raise RecordingError(
            f"{path}, row {row.line}: column {name} is '{row.cells[place]}'; give a number"
        ) from None
