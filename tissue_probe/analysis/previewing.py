"""The contents of a file before it is known which of its signals are meant.

Contents: names, units and first values, as a user looks at them to tell which column is the force.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tissue_probe import arguments as take
from tissue_probe.recording.bags.open_bag import is_bag
from tissue_probe.recording.columns.open_columns import open_columns
from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.units import bare_unit_in
from tissue_probe.signals import FloatArray

#: First rows that are shown, and points of a signal's sketch: more than its picture has pixels.
FIRST_ROWS, SKETCH_POINTS = 8, 240
#: Columns that are read for a sketch: a table of more is no measurement of one probe.
COLUMNS_READ = 64


@dataclass(frozen=True)
class PreviewColumn:
    """A column, or a field of a topic.

    Attributes
    ----------
    name, unit : str
        As the file has them; the unit is empty where it tells none.
    count : int
        How many values; 0 where they are no numbers, or not read.
    first : tuple of str
        The first values, as text.
    sketch : tuple of float
        Values along the whole column: the lowest and highest of each piece, as they come.
    """

    name: str
    unit: str
    count: int
    first: tuple[str, ...]
    sketch: tuple[float, ...]


@dataclass(frozen=True)
class Preview:
    """The contents of a file.

    Attributes
    ----------
    kind : {"table", "bag", "recording"}
        Columns; a bag of another recorder; a recording of this suite, which tells all itself.
    columns : tuple of PreviewColumn
        Columns of numbers or times, or fields of a bag that may be meant.
    notes : tuple of str
        How the file is read, in phrases.
    """

    kind: Literal["table", "bag", "recording"]
    columns: tuple[PreviewColumn, ...]
    notes: tuple[str, ...]


@take.checks(path=take.path)
def preview(path: str | Path) -> Preview:
    """Show the contents of a file.

    Raises
    ------
    RecordingError
        If it cannot be read at all.
    """
    path = Path(path)
    return _of_bag(path) if is_bag(path) else _of_table(open_columns(path))


def _of_table(source: Columns) -> Preview:
    columns, told = [], list(source.told)
    for name in source.names[:COLUMNS_READ]:
        try:
            (values,), said, *_ = source.read([name])
        except RecordingError:
            columns.append(PreviewColumn(name, "", 0, (), ()))
            continue
        told += [each for each in said if each not in told]
        unit = source.units.get(name) or bare_unit_in(name) or ""
        columns.append(_column(name, unit, values))
    return Preview("table", tuple(columns), tuple(told))


def _column(name: str, unit: str, values: np.ndarray[Any, Any]) -> PreviewColumn:
    numbers = values.astype(np.float64) if values.dtype.kind in "iufb" else np.arange(0.0)
    first = tuple(str(value) for value in values[:FIRST_ROWS].tolist())
    return PreviewColumn(name, unit, values.size, first, tuple(_sketch(numbers)))


def _sketch(values: FloatArray) -> Sequence[float]:
    known = values[np.isfinite(values)]
    if known.size <= SKETCH_POINTS:
        return [float(value) for value in known]
    pieces = np.array_split(known, SKETCH_POINTS // 2)
    return [float(value) for piece in pieces for value in (piece.min(), piece.max())]


def _of_bag(path: Path) -> Preview:
    from tissue_probe.recording.bags.open_bag import open_bag
    from tissue_probe.recording.bags.reader import has_samples
    from tissue_probe.recording.bags.topic_field import FORCE_FIELDS, POSITION_FIELDS, candidates

    bag = open_bag(path)
    if has_samples(bag):
        return Preview("recording", (), ("a recording of this suite",))
    fields = candidates(bag, FORCE_FIELDS | POSITION_FIELDS)
    columns = tuple(PreviewColumn(name, "", 0, (), ()) for name in fields)
    topics = ", ".join(f"{topic.name} ({topic.typename})" for topic in bag.topics)
    return Preview("bag", columns, (f"its topics are {topics or 'none'}",))
