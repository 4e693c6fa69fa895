"""Which lines of a file are rows of its table, block after block.

Contents: telling rows from headers that come again, from comments, and from text between two blocks
and below the last.

Testing machines write a block for each step of a protocol, each with the table's header: these are
one table. Text ends a block, and only the header begins another.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from tissue_probe.recording.columns.cells import CellKind, kind
from tissue_probe.recording.columns.find_table import FoundTable, Row, fit_row, fold_cells
from tissue_probe.recording.errors import RecordingError


class Blocks:
    """The rows of a table, told one line after the other.

    Parameters
    ----------
    path : Path
        The file's name in messages.
    found : Found
        The table.
    decimal : {".", ","}
        The decimal mark.
    line : str
        The name of a line in such a file.

    Attributes
    ----------
    starts : list of int
        Of each block, how many rows lie before it; the first has none.
    between : list of list of Row
        Lines of text before the second and each further block.
    pending : list of int
        Lines since the last row of a block that are no rows: its end, or a fault in it.
    """

    def __init__(self, path: Path, found: FoundTable, decimal: str, line: str = "line") -> None:
        self._path = path
        self._found = found
        self._decimal = decimal
        self._line = line
        self._headers = {fold_cells(each) for each in found.headers}
        self._left_out: list[int] = []
        self._labelled: bool | None = None  # whether rows begin with a word
        self._text: list[Row] = []
        self.starts = [0]
        self.between: list[list[Row]] = []
        self.pending: list[int] = []

    def takes(self, row: Row, before: int) -> bool:
        """Whether a line is a row of the table, of which ``before`` were taken already.

        Raises
        ------
        RecordingError
            If it has more or fewer cells than the table, or follows text without a header.
        """
        if row.blank:
            return False
        if self._is_header(row):
            self._left_out += [*self.pending, row.line]
            if before > self.starts[-1]:
                self.starts.append(before)
                self.between.append(self._text)
            self.pending, self._text = [], []
            return False
        if row.comment:
            self._left_out.append(row.line)
            return False
        if not self._has_numbers(row):
            self.pending.append(row.line)
            self._text.append(row)
            return False
        if self.pending:
            raise RecordingError(
                f"{self._path}, {self._line} {self.pending[0]}: no row of the table, and rows "
                "follow; take it out, or the rows after it"
            )
        if len(row.cells) != self._found.width and not self._is_commented(row):
            raise RecordingError(
                f"{self._path}, {self._line} {row.line}: {len(row.cells)} cells, but the table has "
                f"{self._found.width} columns"
            )
        return True

    def begins(self, count: int) -> tuple[int, ...]:
        """Return the rows, of ``count``, at which the second and further blocks begin."""
        return tuple(start for start in self.starts[1:] if start < count)

    def describe_blocks(self, count: int) -> Iterator[str]:
        """Say of ``count`` rows in how many blocks they are, and which lines are none."""
        starts = (0, *self.begins(count))
        if len(starts) > 1:
            stops = (*starts[1:], count)
            sizes = [stop - start for start, stop in zip(starts, stops, strict=True)]
            yield f"{len(sizes)} blocks, of {', '.join(map(str, sizes[:-1]))} and {sizes[-1]} rows"
        for lines, place in ((self._left_out, "left out"), (self.pending, "below the table")):
            if lines:
                rows = f"{len(lines)} row{'s' if len(lines) > 1 else ''} {place}"
                yield f"{rows}: {spans(sorted(lines), self._line)}"

    def _is_header(self, row: Row) -> bool:
        """Whether a line names the columns again, be it as a comment."""
        if row.comment:
            bare = row.text.strip().lstrip("#%/*! ")
            row = Row(row.line, tuple(bare.split(self._found.separator)))
        cells = fit_row(row, self._found.width)
        return cells is not None and fold_cells(cells) in self._headers

    def _is_commented(self, row: Row) -> bool:
        """Whether a row has one cell more, of text, where the header ends in a comment's name."""
        more = row.cells[self._found.width :]
        return self._found.commented and len(more) == 1 and kind(more[0]) is CellKind.TEXT

    def _has_numbers(self, row: Row) -> bool:
        """Whether a line may be a row.

        A line that begins with a word is text, unless rows of this table do; where rows are
        expected, a word elsewhere in one is a fault of it.
        """
        kinds = row.kinds(self._decimal)
        numbers = sum(each in (CellKind.NUMBER, CellKind.TIME) for each in kinds)
        words = kinds[0] is CellKind.TEXT
        if self._labelled is None and numbers:
            self._labelled = words
        if words and not self._labelled:
            return False
        if CellKind.TEXT in kinds[: self._found.width]:
            return numbers > 1 and not self.pending
        return bool(numbers) or len(row.cells) == self._found.width


def spans(lines: Sequence[int], line: str) -> str:
    """Write lines as ``lines 3 to 5 and 9``, no more than three of them."""
    found: list[list[int]] = []
    for each in lines:
        if found and each == found[-1][1] + 1:
            found[-1][1] = each
        else:
            found.append([each, each])
    said = [f"{a} to {b}" if a < b else str(a) for a, b in found[:3]]
    more = ", ..." if len(found) > 3 else ""
    return f"{line}{'s' if len(lines) > 1 else ''} {', '.join(said)}{more}"
