"""A small table as results show it: text, HTML in a notebook, records, a data frame.

Contents: showing.
"""

from __future__ import annotations

import html
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd

#: Rows that are shown at most: with title and heads a result keeps within forty lines.
ROWS_SHOWN = 30


@dataclass(frozen=True)
class Column:
    """A column: its name for programs, its head for people, and how a value is written.

    Attributes
    ----------
    name : str
        In ``to_dict`` and ``to_frame``, where values stand as they are (SI units).
    head : str
        In print; empty where the column is for programs alone.
    write : callable
        From a value to its text.
    right : bool
        Whether texts stand to the right.
    """

    name: str
    head: str
    write: Callable[[Any], str] = str
    right: bool = False


@dataclass(frozen=True, repr=False)
class ResultTable:
    """Rows of values under named columns.

    Attributes
    ----------
    title : str
        Above the table.
    columns : tuple of Column
        From the left.
    rows : tuple of tuple
        A value a column each.
    """

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Any, ...], ...]

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return iter(self.to_dict())

    def __repr__(self) -> str:
        heads, rows = self.heads, self.texts(ROWS_SHOWN)
        widths = [
            max(len(head), *(len(row[i]) for row in rows), 0) if rows else len(head)
            for i, head in enumerate(heads)
        ]
        lines = [self.title] if self.title else []
        lines += [self._line(heads, widths), *(self._line(row, widths) for row in rows)]
        if len(self) > ROWS_SHOWN:
            lines.append(f"... and {len(self) - ROWS_SHOWN} more")
        return "\n".join(line.rstrip() for line in lines)

    def _repr_html_(self) -> str:
        heads = "".join(f"<th>{html.escape(head)}</th>" for head in self.heads)
        rows = "".join(
            "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>"
            for row in self.texts(ROWS_SHOWN)
        )
        title = f"<caption>{html.escape(self.title)}</caption>" if self.title else ""
        return f"<table>{title}<thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"

    @property
    def heads(self) -> list[str]:
        """Return the heads of the columns for people."""
        return [column.head for column in self.shown]

    @property
    def shown(self) -> list[Column]:
        """Return the columns for people."""
        return [column for column in self.columns if column.head]

    def texts(self, most: int | None = None) -> list[list[str]]:
        """Return the rows as written, at most so many."""
        return [
            [
                "" if value is None else column.write(value)
                for column, value in zip(self.columns, row, strict=True)
                if column.head
            ]
            for row in self.rows[:most]
        ]

    def to_dict(self) -> list[dict[str, Any]]:
        """Return a dictionary a row, values in SI units."""
        names = [column.name for column in self.columns]
        return [dict(zip(names, row, strict=True)) for row in self.rows]

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas data frame, values in SI units.

        Raises
        ------
        ImportError
            If pandas is not installed; says how to install it.
        """
        try:
            import pandas as pd
        except ModuleNotFoundError as error:
            raise ImportError("a data frame needs pandas: pip install pandas") from error

        return pd.DataFrame(self.to_dict(), columns=[column.name for column in self.columns])

    def _line(self, cells: Sequence[str], widths: Sequence[int]) -> str:
        return "  ".join(
            cell.rjust(width) if column.right else cell.ljust(width)
            for cell, width, column in zip(cells, widths, self.shown, strict=True)
        )


@dataclass(frozen=True)
class number:  # noqa: N801 - it is called as a function is, and compared and sent as data
    """How a number is written: so many digits, in a unit of which ``factor`` make one SI."""

    digits: int
    factor: float = 1.0

    def __call__(self, value: float) -> str:
        """Return a value as it is written."""
        return f"{self.factor * value:.{self.digits}g}"


def write_mark(value: bool) -> str:
    """Return how a mark is written that is there or not."""
    return "yes" if value else ""


def write_settled(value: bool) -> str:
    """Return how it is written whether a fit settled: it is told where it did not."""
    return "" if value else "no"


def two_decimals(value: float) -> str:
    """Return how a share is written."""
    return f"{value:.2f}"


def probability(value: float) -> str:
    """Return how a probability is written: never as 0, which nothing is after a measurement."""
    if value < 1e-3:
        return "< 0.001"
    return f"{value:.{3 if value < 0.01 else 2}f}"
