"""Finding the table among the lines of a file: where the numbers are, and their names.

Contents: rows of cells, be they of a text or of a spreadsheet.

The table is the longest run of rows that have as many cells and hold numbers. The rows above name
it, row by row upwards: units, names, groups of columns. All before is a preamble. So an export of a
testing machine, of LabVIEW or of a spreadsheet are one case, and none is known by name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby

from tissue_probe.recording.columns.cells import Cell, CellKind, kind
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.units import bare_unit

COMMENTS = ("#", "%", "//", "*", "!")
"""Beginnings of lines that are for people."""

COMMENT = "comment"  # in lower case: the name of a column that rows need not have
HEADERS = 6  # rows that may stand above a table and name it


@dataclass(frozen=True)
class Row:
    """A line of the file: its number from 1, its cells, and its text where it is one."""

    line: int
    cells: tuple[Cell, ...]
    text: str = ""
    _kinds: dict[str, list[CellKind]] = field(default_factory=dict, compare=False, repr=False)

    @property
    def blank(self) -> bool:
        """Whether nothing is in it."""
        return all(isinstance(cell, str) and not cell.strip() for cell in self.cells)

    @property
    def comment(self) -> bool:
        """Whether it is for people."""
        text = self.text or (self.cells[0] if self.cells else "")
        return isinstance(text, str) and text.lstrip(' "').startswith(COMMENTS)

    def kinds(self, decimal: str) -> list[CellKind]:
        """Return the kinds of its cells; kept, since a table is looked for more than once."""
        if decimal not in self._kinds:
            self._kinds[decimal] = [kind(cell, decimal) for cell in self.cells]
        return self._kinds[decimal]

    def data(self, decimal: str) -> bool:
        """Whether it is a row of numbers."""
        if self.comment and kind(self.cells[0], decimal) is CellKind.TEXT:
            return False
        kinds = self.kinds(decimal)
        told = sum(each in (CellKind.NUMBER, CellKind.TIME) for each in kinds)
        return len(kinds) > 1 and (told > 1 or (told == 1 and CellKind.TEXT not in kinds))


@dataclass(frozen=True)
class FoundTable:
    """A table among rows.

    Attributes
    ----------
    first : int
        Place of its first row of numbers among the rows.
    width : int
        Cells in each row.
    names : tuple of str
        Of its columns, each its own; numbers from 1 where nothing names them.
    units : tuple of str
        Of its columns, by a row of units; empty where there is none.
    headers : tuple of tuple of str
        Rows of names and units, stripped: they may come again.
    named : bool
        Whether the names are the file's own.
    told : tuple of str
        How it was found, in phrases.
    commented : bool
        Whether the header has one name more, of comments that rows may have.
    separator : str
        The separator of cells, where the file is a text.
    """

    first: int
    width: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    headers: tuple[tuple[str, ...], ...]
    named: bool
    told: tuple[str, ...]
    commented: bool = False
    separator: str = ","


@dataclass(frozen=True)
class NumericRows:
    """Rows of numbers that follow one another: places (first, stop), and cells in each."""

    first: int
    stop: int
    width: int
    explained: int


def longest_run(rows: Sequence[Row], decimal: str) -> NumericRows | None:
    """Return the rows of as many cells that explain most characters of the file as numbers."""
    return max(_runs(rows, decimal), key=lambda run: run.explained, default=None)


def _runs(rows: Sequence[Row], decimal: str) -> Iterator[NumericRows]:
    data = [
        (place, len(row.cells) if row.data(decimal) else 0)
        for place, row in enumerate(rows)
        if not row.blank
    ]
    for width, group in groupby(data, key=lambda each: each[1]):
        places = [place for place, _ in group]
        if width:
            explained = sum(_count_explained(rows[place], decimal) for place in places)
            yield NumericRows(places[0], places[-1] + 1, width, explained)


def _count_explained(row: Row, decimal: str) -> int:
    """Return how many characters are in cells that tell something."""
    return sum(
        len(str(cell).strip()) + 1
        for cell, each in zip(row.cells, row.kinds(decimal), strict=True)
        if each is not CellKind.TEXT
    )


def find_table(
    path: str,
    rows: Sequence[Row],
    decimal: str,
    splits: Sequence[Callable[[str], tuple[str, ...]]] = (),
) -> FoundTable:
    """Find the table.

    Parameters
    ----------
    path : str
        The file's name in messages.
    rows : sequence of Row
        The file's first.
    decimal : {".", ","}
        The decimal mark.
    splits : sequence of callable
        Other ways to cut a line into cells, for a header that is written otherwise.

    Raises
    ------
    RecordingError
        If there is none, or its header names more or fewer columns than it has.
    """
    best = longest_run(rows, decimal)
    if best is None:
        raise RecordingError(
            f"{path} is not a table: no line in it has two numbers or more, side by side"
        )
    best = _with_those_before(rows, best, decimal, splits)
    above = _above(rows, best, decimal, splits)
    if not above:
        _refuse_misfit(path, rows, best, decimal)
        names = tuple(str(number + 1) for number in range(best.width))
        before = tuple(_preamble(rows, best.first, decimal))
        return FoundTable(best.first, best.width, names, (), (), False, before)
    texts = tuple(tuple(map(str, row.cells)) for row in above)
    unit_row = _unit_row(texts)
    at = len(texts) - 1 if unit_row is None else unit_row - 1
    named = _find_filled(texts, rows, best)
    at = at if at in named or not named else named[-1]
    names = _distinct(texts[: at + 1])
    told = list(_preamble(rows, rows.index(_row(rows, above[at].line)), decimal))
    units: tuple[str, ...] = ()
    if unit_row is not None:
        units = tuple(bare_unit(cell) or "" for cell in texts[unit_row])
        told.append("units from the row below the names")
    last = [str(cell).strip() for cell in _row(rows, above[at].line).cells]
    commented = len(last) > best.width and last[best.width].casefold() == COMMENT
    return FoundTable(best.first, best.width, names, units, texts, True, tuple(told), commented)


def _row(rows: Sequence[Row], line: int) -> Row:
    return next(row for row in rows if row.line == line)


def _preamble(rows: Sequence[Row], place: int, decimal: str) -> Iterator[str]:
    """Describe the rows above a table: lines that hold no samples, or another table."""
    count = rows[place].line - rows[0].line
    if not count or all(row.blank for row in rows[:place]):
        return
    yield f"{count} line{'s' if count > 1 else ''} of preamble"
    for run in _runs(rows[:place], decimal):
        if run.stop - run.first > 1 and not _has_labels(rows[run.first], decimal):
            first, last = rows[run.first].line, rows[run.stop - 1].line
            yield f"another table, in lines {first} to {last}, is not read"


def _with_those_before(
    rows: Sequence[Row],
    best: NumericRows,
    decimal: str,
    splits: Sequence[Callable[[str], tuple[str, ...]]],
) -> NumericRows:
    """Begin where the table begins: text does not end it where its header comes again below."""
    for run in reversed(list(_runs(rows[: best.first], decimal))):
        if _has_labels(rows[run.first], decimal) and not _has_labels(rows[best.first], decimal):
            continue  # no samples: numbers behind a word, as preambles have them
        if run.width != best.width:
            if run.stop - run.first > 1:
                break
            continue
        header = {fold_cells(row.cells) for row in _above(rows, run, decimal, splits)}
        names = [
            row
            for row in _above(rows, best, decimal, splits)
            if fold_cells(row.cells) not in header
        ]
        if not all(_row(rows, row.line).comment for row in names):
            break  # a table of its own
        best = NumericRows(run.first, best.stop, best.width, best.explained)
    return best


def fold_cells(cells: Sequence[Cell]) -> tuple[str, ...]:
    """Return a row's texts as they are compared with a header: capital letters mean the same."""
    return tuple(str(cell).casefold() for cell in cells)


def _has_labels(row: Row, decimal: str) -> bool:
    return CellKind.TEXT in row.kinds(decimal)


def _above(
    rows: Sequence[Row],
    run: NumericRows,
    decimal: str,
    splits: Sequence[Callable[[str], tuple[str, ...]]],
) -> list[Row]:
    """Return the rows that name a run's columns, from the top."""
    found: list[Row] = []
    for row in reversed(rows[: run.first]):
        if row.blank:
            if found:
                break
            continue
        if len(found) == HEADERS:
            break
        if row.comment:
            if found:
                break
            bare = row.text.strip().lstrip("#%/*! ")
            row = Row(row.line, next((c for s in splits if len(c := s(bare)) == run.width), ()))
        cells = fit_row(row, run.width, splits)
        if cells is None or sum(kind(cell, decimal) is CellKind.NUMBER for cell in cells) > 1:
            break
        if sum(bool(cell) for cell in cells) < min(2, run.width):
            break
        found.insert(0, Row(row.line, cells))
        if row.comment:
            break
    return found


def fit_row(
    row: Row, width: int, splits: Sequence[Callable[[str], tuple[str, ...]]] = ()
) -> tuple[str, ...] | None:
    """Return a row's texts if it has a cell for each column, in one of the ways to cut it."""
    for cells in (row.cells, *(split(row.text) for split in splits if row.text)):
        texts = [str(cell).strip() for cell in cells]
        while len(texts) > width and (not texts[-1] or texts[-1].casefold() == COMMENT):
            texts.pop()  # LabVIEW names a column of comments, and leaves it out where there is none
        if len(texts) == width:
            return tuple(texts)
    return None


def _unit_row(texts: Sequence[tuple[str, ...]]) -> int | None:
    """Return which row below another tells units: most of its cells are known ones."""
    for place in range(len(texts) - 1, 0, -1):
        cells = [cell for cell in texts[place] if cell]
        known = sum(bare_unit(cell) is not None for cell in cells)
        if known >= max(1, (len(cells) + 1) // 2):
            return place
    return None


def _find_filled(
    texts: Sequence[tuple[str, ...]], rows: Sequence[Row], run: NumericRows
) -> list[int]:
    """Return which rows name every column that has values."""
    used = [
        any(str(row.cells[c]).strip() for row in rows[run.first : run.stop] if c < len(row.cells))
        for c in range(run.width)
    ]
    unit_row = _unit_row(texts)
    return [
        place
        for place, cells in enumerate(texts)
        if place != unit_row and all(cell or not use for cell, use in zip(cells, used, strict=True))
    ]


def _distinct(texts: Sequence[tuple[str, ...]]) -> tuple[str, ...]:
    """Return the lowest row's names; where two are alike, with the groups above them."""
    names = list(texts[-1])
    for groups in reversed(texts[:-1]):
        if len({name for name in names if name}) == sum(map(bool, names)):
            break
        group = ""
        for place, name in enumerate(names):
            group = groups[place] or group
            names[place] = f"{group} {name}".strip()
    return tuple(names)


def _refuse_misfit(path: str, rows: Sequence[Row], run: NumericRows, decimal: str) -> None:
    """Refuse a table whose header names more or fewer columns than it has."""
    row = next((r for r in reversed(rows[: run.first]) if not r.blank and not r.comment), None)
    if row is None:
        return
    line = rows[run.first].line
    if row.data(decimal):
        raise RecordingError(
            f"{path}: line {row.line} has {len(row.cells)} cells, line {line} has {run.width}; are "
            "commas both between cells and within numbers? Write as many cells in each row, and "
            "another mark between the cells than within numbers"
        )
    texts = [cell for cell in row.cells if kind(cell, decimal) is CellKind.TEXT]
    if len(texts) > 1 and len(texts) == len(row.cells):
        raise RecordingError(
            f"{path}: line {line} has {run.width} cells, the header names {len(row.cells)} columns"
            "; are commas both between cells and within numbers? Write one name for each cell, and "
            "another mark between the cells than within numbers"
        )
