"""Tables of text: any separator, decimal mark, encoding; with any text around them.

Contents: decoding, cutting lines into cells, and reading the rows, which may be millions.

The dialect is that in which the numbers explain most characters. Blocks of lines are read by
pyarrow; only where it cannot read one, because something else than a row is in it, its lines are
read one by one: then each is a row, or of another known kind, or refused with its number.
"""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.recording.columns import cells
from tissue_probe.recording.columns.blocks import Blocks
from tissue_probe.recording.columns.bounds import check_rows
from tissue_probe.recording.columns.cells import Cell, CellKind
from tissue_probe.recording.columns.channel_labels import ChannelLabels, channel_labels
from tissue_probe.recording.columns.find_table import (
    FoundTable,
    NumericRows,
    Row,
    find_table,
    longest_run,
)
from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError

if TYPE_CHECKING:
    import pyarrow

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "blanks"}
"""The separators of cells."""

BLOCK_BYTES = 2**23  # bytes read at a time
HEADS = 2**14, 2**18
"""Bytes in which the table is found: in the first, unless it ends there, or is the lesser part."""

_BLANKS = re.compile(r"[^\S\n]+")
_WIDE_BLANKS = re.compile(r"\s{2,}|\t")
_NO_TEXT = re.compile("[\x00-\x08\x0e-\x19\x1b-\x1f\ufffd]")


@dataclass(frozen=True)
class Dialect:
    """How a text is written: encoding, separator of cells, decimal mark."""

    encoding: str
    separator: str
    decimal: str

    def describe_dialect(self) -> tuple[str, ...]:
        """Name the differences from plain CSV."""
        said = [SEPARATORS[self.separator]] if self.separator != "," else []
        if self.decimal == ",":
            said.append("decimal commas")
        said = [", ".join(said)] if said else []
        if self.encoding not in ("utf-8", "utf-8-sig"):
            said.append({"cp1252": "Windows-1252 (Latin-1)"}.get(self.encoding, "UTF-16"))
        return tuple(said)

    def split(self, text: str) -> tuple[str, ...]:
        """Cut a line into cells."""
        if self.separator == " ":
            text = _BLANKS.sub(" ", text.strip())
        if '"' not in text:
            return tuple(text.split(self.separator)) if text.strip() else ()
        return tuple(next(csv.reader([text], delimiter=self.separator), ()))


def open_text(path: Path) -> Columns:
    """Open a table of text.

    Raises
    ------
    RecordingError
        If it is no text, has no table, or its header does not fit.
    """
    encoding = _find_encoding(path)
    rows, dialect = _dialect(path, encoding)
    splits = [Dialect(encoding, mark, ".").split for mark in SEPARATORS if mark != " "]
    splits += [Dialect(encoding, " ", ".").split, _wide]
    found = find_table(str(path), rows, dialect.decimal, splits)
    told = (*dialect.describe_dialect(), *found.told)
    labels = channel_labels(path, rows, found, dialect.decimal)
    found = replace(found, names=labels.names, separator=dialect.separator)

    def load(names: Sequence[str], progress: Progress) -> Loaded:
        return _Reading(path, dialect, found, rows, names, labels).run(progress)

    named = {n: u for n, u in zip(found.names, found.units, strict=False) if u}
    return Columns(
        path,
        tuple(n for n in found.names if n),
        load,
        named | labels.units,
        told,
        labels.periods,
        labels.starts,
        labels.clocks,
        found.named,
        found.names,
    )


def _wide(text: str) -> tuple[str, ...]:
    return tuple(_WIDE_BLANKS.split(text.strip()))


def _find_encoding(path: Path) -> str:
    """Return a text's encoding: a mark tells, else UTF-8 if all of it is, else Latin."""
    with path.open("rb") as file:
        head = file.read(4096)
        if head.startswith(codecs.BOM_UTF8):
            return "utf-8-sig"
        if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
            return "utf-16"
        for encoding, place in (("utf-16-le", 1), ("utf-16-be", 0)):
            if head[place::2].count(0) > len(head) // 4:
                return encoding
        decoder = codecs.getincrementaldecoder("utf-8")()
        try:
            while head:
                decoder.decode(head)
                head = file.read(BLOCK_BYTES)
            decoder.decode(b"", final=True)
        except UnicodeDecodeError:
            return "cp1252"
    return "utf-8"


def _texts(path: Path, encoding: str, size: int, progress: Progress) -> Iterator[str]:
    """Yield a file's text in pieces of whole lines, each ended by a line feed.

    A last line that has no end is a piece of its own.
    """
    whole = max(path.stat().st_size, 1)
    decoder = codecs.getincrementaldecoder(encoding)("replace")
    rest, read = "", 0
    with path.open("rb") as file:
        while piece := file.read(size):
            read += len(piece)
            text = rest + decoder.decode(piece)
            ends = text.endswith("\r")
            text = text[: -1 if ends else None].replace("\r\n", "\n").replace("\r", "\n")
            lines, feed, rest = text.rpartition("\n")
            rest += "\r" if ends else ""
            if len(rest) > BLOCK_BYTES:
                raise RecordingError(f"{path} is not a table of text: a line in it has no end")
            yield lines + feed
            progress(read / whole)
    rest = rest + decoder.decode(b"", final=True)
    ended = rest.endswith("\r")
    rest = rest.replace("\r", "\n").rstrip("\n")
    if rest:
        yield rest + ("\n" if ended else "")


def _numbers(array: pyarrow.Array) -> np.ndarray:
    """Return a copy of pyarrow's array; NaN where it is null.

    Not by ``to_numpy``, which imports pandas where that is installed: half a second.
    """
    if not array.null_count:
        return np.from_dlpack(array).copy()
    known = np.from_dlpack(array.is_valid().cast("uint8")).astype(bool)
    floats = array.cast("float64", safe=False)
    values = np.frombuffer(floats.buffers()[1], np.float64)[floats.offset :][: len(floats)].copy()
    values[~known] = np.nan
    return values


def _end_text(text: str) -> str:
    return text if text.endswith("\n") else text + "\n"


def _dialect(path: Path, encoding: str) -> tuple[list[Row], Dialect]:
    """Return the first lines' rows, in the dialect in which numbers explain most of them."""
    lines: list[str] = []
    for size in HEADS:
        text = next(filter(None, _texts(path, encoding, size, lambda share: None)), "")
        if _NO_TEXT.search(text):
            raise RecordingError(f"{path} is not a table of text: it holds characters of no text")
        lines = _end_text(text).split("\n")[:-1]
        if found := _best(lines, encoding):
            rows, dialect, run = found
            if run.stop == len(rows) and 2 * (run.stop - run.first) > len(rows):
                break
    if found:
        return rows, dialect
    names = next((line for line in lines if line.strip()), "")
    if any(len(names.split(mark)) > 1 for mark in SEPARATORS):
        raise RecordingError(
            f"{path} has a header line perhaps, but no rows below it: no line in it has two "
            "numbers or more, side by side"
        )
    raise RecordingError(f"{path} is not a table: no line in it has two numbers side by side")


def _best(lines: Sequence[str], encoding: str) -> tuple[list[Row], Dialect, NumericRows] | None:
    """Return rows, dialect and table of lines, for the best dialect; None where none fits."""
    best: tuple[list[Row], Dialect, NumericRows] | None = None
    for separator in SEPARATORS:
        cut = Dialect(encoding, separator, ".").split
        try:
            parts = [cut(line) for line in lines]
        except csv.Error:
            continue
        if all(len(each) < 2 for each in parts):
            continue  # a separator that cuts no line makes no table, of either decimal mark
        numbered = enumerate(zip(parts, lines, strict=True), 1)
        rows = [Row(n, each, line) for n, (each, line) in numbered]
        commas = any("," in cell for each in parts for cell in each)
        for decimal in (".", ",") if commas else ".":  # without any, points read all that they do
            run = longest_run(rows, decimal)
            if run is not None and (best is None or run.explained > best[2].explained):
                best = rows, Dialect(encoding, separator, decimal), run
    return best


class _Reading:
    """One pass over the rows of a table.

    Parameters
    ----------
    path : Path
        The file.
    dialect, found
        How it is written, and where the table is.
    rows : sequence of Row
        Its first lines.
    names : sequence of str
        Of the columns to read.
    labels : ChannelLabels
        The channels' labels beside the rows.
    """

    def __init__(
        self,
        path: Path,
        dialect: Dialect,
        found: FoundTable,
        rows: Sequence[Row],
        names: Sequence[str],
        labels: ChannelLabels,
    ) -> None:
        self._labels = labels
        self._path = path
        self._dialect = dialect
        self._found = found
        self._names = names
        self._places = [found.names.index(name) for name in names]
        first = [r for r in rows[found.first :] if len(r.cells) == found.width and not r.comment]
        kinds = [row.kinds(dialect.decimal) for row in first]
        self._timed = [
            any(each[place] is CellKind.TIME for each in kinds)
            and not any(each[place] is CellKind.NUMBER for each in kinds)
            for place in self._places
        ]
        self._whole = [
            all(cells.is_whole(row.cells[place]) for row in first) for place in self._places
        ]
        self._line = 0  # read so far
        self._cut: list[str] = []
        self._begins = rows[found.first].line
        self._shortest = min((len(row.text) for row in first), default=0)
        self._blocks = Blocks(path, found, dialect.decimal)
        self._pieces: list[tuple[int, int, Blocks]] = []  # of each: line, rows, and blocks before

    def run(self, progress: Progress) -> Loaded:
        parts: list[list[np.ndarray]] = [[] for _ in self._names]
        count = 0
        for text in _texts(self._path, self._dialect.encoding, BLOCK_BYTES, progress):
            self._pieces.append((self._line + 1, count, deepcopy(self._blocks)))
            if self._line + text.count("\n") + 1 < self._begins:
                self._line += text.count("\n")
                continue
            if not text.endswith("\n"):
                if self._is_cut(text):
                    self._cut.append(f"line {self._line + 1}, the last, is cut short, and left out")
                    break
                self._cut.append(
                    f"line {self._line + 1}, the last, has no end; its last number may be cut"
                )
            for part, column in zip(parts, self._piece(_end_text(text), count), strict=True):
                part.append(column)
            count += parts[0][-1].size
            check_rows(self._path, count)
        columns = []
        for part in parts:
            columns.append(np.concatenate(part) if part else np.empty(0))
            part.clear()
        told = (*self._blocks.describe_blocks(count), *self._cut)
        blocks = self._blocks.begins(count)
        begins = self._labels.begins(self._blocks.between[: len(blocks)])
        return Loaded(columns, told, self._place, blocks, begins)

    def _is_cut(self, text: str) -> bool:
        """Whether a last line without an end lacks some of a row's characters."""
        if text.count('"') % 2:
            return True
        cells_of = self._dialect.split(text)
        begins = cells_of and cells.kind(cells_of[0], self._dialect.decimal) is not CellKind.TEXT
        short = len(cells_of) < self._found.width or len(text) < self._shortest
        return bool(begins) and short

    def _place(self, row: int) -> str:
        """Say in which line a row is; its piece is read again, as which rows it has is not kept."""
        number = max(n for n, (_, first, _) in enumerate(self._pieces) if first <= row)
        texts = _texts(self._path, self._dialect.encoding, BLOCK_BYTES, lambda share: None)
        line, before, blocks = self._pieces[number]
        lines = _end_text(next(islice(texts, number, None))).split("\n")[:-1]
        rows = [Row(line + n, self._dialect.split(each), each) for n, each in enumerate(lines)]
        rows = [each for each in rows if each.line >= self._begins and blocks.takes(each, before)]
        return f"line {rows[row - before].line}"

    def _piece(self, text: str, before: int) -> list[np.ndarray]:
        lines = text.count("\n")
        skipped = max(0, self._begins - 1 - self._line)
        for _ in range(skipped):
            text = text[text.index("\n") + 1 :]
        columns = None if self._blocks.pending else self._at_once(text)
        if columns is None:
            columns = self._line_by_line(text, self._line + skipped, before)
        self._line += lines
        return columns

    def _at_once(self, text: str) -> list[np.ndarray] | None:
        """Read a piece of nothing but rows; None if it is something else."""
        columns = self._as_kinds(text)
        if columns is None and any(self._whole):  # whole numbers at first need not stay so
            kept, self._whole = self._whole, [False] * len(self._whole)
            if (columns := self._as_kinds(text)) is None:
                self._whole = kept
        return columns

    def _as_kinds(self, text: str) -> list[np.ndarray] | None:
        import pyarrow
        from pyarrow import csv as arrow_csv

        separator = self._dialect.separator
        if separator == " ":
            text = _BLANKS.sub(" ", text).replace("\n ", "\n").replace(" \n", "\n").lstrip(" ")
        data = text.encode()
        kinds = [
            pyarrow.string() if timed else pyarrow.int64() if whole else pyarrow.float64()
            for timed, whole in zip(self._timed, self._whole, strict=True)
        ]
        wanted = [str(place) for place in self._places]
        try:
            table = arrow_csv.read_csv(
                pyarrow.BufferReader(data),
                arrow_csv.ReadOptions(
                    use_threads=False,
                    block_size=len(data) + 1,
                    column_names=[str(number) for number in range(self._found.width)],
                ),
                arrow_csv.ParseOptions(delimiter=separator),
                arrow_csv.ConvertOptions(
                    include_columns=wanted,
                    column_types=dict(zip(wanted, kinds, strict=True)),
                    null_values=list(cells.UNKNOWN_SPELT),
                    decimal_point=self._dialect.decimal,
                ),
            )
            columns = []
            for name, timed in zip(wanted, self._timed, strict=True):
                column = table.column(name)
                if timed:
                    columns.append(cells.times(column.to_pylist()))
                else:
                    columns.append(_numbers(column.combine_chunks()))
        except (pyarrow.ArrowException, ValueError):
            return None
        return columns

    def _line_by_line(self, text: str, above: int, before: int) -> list[np.ndarray]:
        found: list[list[Cell]] = [[] for _ in self._names]
        for line, each in enumerate(text.split("\n")[:-1], above + 1):
            try:
                row = Row(line, self._dialect.split(each), each)
            except csv.Error as error:
                raise RecordingError(f"{self._path}, line {line}: {error}") from None
            if not self._blocks.takes(row, before + len(found[0])):
                continue
            for values, place, name, timed in zip(
                found, self._places, self._names, self._timed, strict=True
            ):
                cell = row.cells[place]
                values.append(cell if timed else self._number(row, name, cell))
        try:
            return [
                cells.times(values) if timed else np.array(values, dtype=None if values else float)
                for values, timed in zip(found, self._timed, strict=True)
            ]
        except ValueError as error:
            raise RecordingError(f"{self._path}: '{error}' is no time as the first is") from None

    def _number(self, row: Row, name: str, cell: Cell) -> float | int:
        try:
            return cells.number(cell, self._dialect.decimal)
        except ValueError:
            raise RecordingError(
                f"{self._path}, line {row.line}: column {name} is '{cell}'; give a number"
            ) from None
