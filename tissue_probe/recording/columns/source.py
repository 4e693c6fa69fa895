"""Named columns, as every container gives them.

Contents: the one form in which the readers of files hand over columns.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tissue_probe.arguments import LARGEST_NUMBER
from tissue_probe.recording.errors import RecordingError

Progress = Callable[[float], None]
"""Told the share of a file that is read, from 0 to 1."""


MOST_TOLD = 40
"""Names of columns that a sentence tells: more are no sentence."""


def row_place(row: int) -> str:
    """Say where a row is, in a file that has nothing but rows."""
    return f"row {row + 1}"


class Loaded(NamedTuple):
    """Columns of one length, and the changes made to read them, in phrases.

    A column is of floats, of whole numbers, of ``datetime64[ns]``, or of texts that tell times.
    ``place`` says where in the file a row (from 0) is, as its user finds it. ``blocks`` are the
    rows (from 0) at which the second and further blocks of a table begin; ``begins`` is when each
    of these began after the first, where the file tells it [s].
    """

    columns: list[np.ndarray]
    told: tuple[str, ...] = ()
    place: Callable[[int], str] = row_place
    blocks: tuple[int, ...] = ()
    begins: tuple[float, ...] = ()


def _is_boundless(column: np.ndarray) -> bool:
    """Whether a column has numbers too large to be measured; infinite ones count as not known."""
    if column.dtype.kind != "f" or not column.size:
        return False
    farthest = max(np.fmax.reduce(column), -np.fmin.reduce(column))
    return bool(
        farthest > LARGEST_NUMBER and np.any(np.abs(column[np.isfinite(column)]) > LARGEST_NUMBER)
    )


@dataclass(frozen=True)
class Columns:
    """The columns of a file, read when they are asked for.

    Attributes
    ----------
    path : Path
        The file.
    names : tuple of str
        Of the columns; numbers from 1 where the file names none.
    load : callable
        Takes names and a ``Progress``, returns ``Loaded``; raises RecordingError.
    units : mapping of str to str
        Units that the file tells beside the names, by column.
    told : tuple of str
        How the file is read, in phrases.
    periods : mapping of str to float
        Time between two samples of a column, where the file tells it [s].
    starts : mapping of str to float
        When a column begins, where the file tells it [s]; from any time, the same for all.
    clocks : mapping of str to str
        The column of times that a column goes by, where each has its own.
    named : bool
        Whether the names are the file's own.
    numbered : tuple of str
        Names in the order of the file's columns, empty where one has none; ``names`` if not given.
    """

    path: Path
    names: tuple[str, ...]
    load: Callable[[Sequence[str], Progress], Loaded]
    units: Mapping[str, str] = field(default_factory=dict)
    told: tuple[str, ...] = ()
    periods: Mapping[str, float] = field(default_factory=dict)
    starts: Mapping[str, float] = field(default_factory=dict)
    clocks: Mapping[str, str] = field(default_factory=dict)
    named: bool = True
    numbered: tuple[str, ...] = ()

    def read(self, names: Sequence[str], progress: Progress = lambda share: None) -> Loaded:
        """Read columns by their names, at least two rows of one length each.

        Raises
        ------
        RecordingError
            If one is missing, has no numbers or another length than the others, or has no rows.
        """
        self.require(names)
        if not names:
            raise RecordingError(f"{self.path} has no columns of numbers")
        once = list(dict.fromkeys(names))
        loaded = self.load(once, progress)
        if len(once) < len(names):
            columns = dict(zip(once, loaded.columns, strict=True))
            loaded = loaded._replace(columns=[columns[name].copy() for name in names])
        sizes = [column.size for column in loaded.columns]
        if len(set(sizes)) > 1:
            lengths = ", ".join(f"{n} has {size}" for n, size in zip(names, sizes, strict=True))
            raise RecordingError(f"{self.path}: columns must have one length, but {lengths} values")
        if not sizes[0]:
            raise RecordingError(f"{self.path} has columns, but no rows")
        for name, column in zip(names, loaded.columns, strict=True):
            if _is_boundless(column):
                raise RecordingError(
                    f"{self.path}: column {name} has numbers beyond {LARGEST_NUMBER:g}, which are "
                    "no measurement; take them out"
                )
        return loaded

    def require(self, names: Sequence[str]) -> None:
        """Check that there are columns of these names.

        Raises
        ------
        RecordingError
            If one is not among those available.
        """
        if missing := [name for name in names if name not in self.names]:
            raise RecordingError(f"{self.path} has no column {', '.join(missing)}; {self.has()}")

    def has(self) -> str:
        """Say which columns there are."""
        more = f" and {len(self.names) - MOST_TOLD} more" if len(self.names) > MOST_TOLD else ""
        told = ", ".join(self.names[:MOST_TOLD]) or "none: it is empty"
        return f"its columns are {told}{more}"
