"""Labels of a LabVIEW measurement file (.lvm): its channels and segments, beside its rows.

Contents: units, starts and steps of time by channel, in rows that begin with a tag.

Source: National Instruments (2010), Specification for the LabVIEW Measurement File (.lvm).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tissue_probe.recording.columns import cells
from tissue_probe.recording.columns.find_table import FoundTable, Row
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import NANOSECONDS

LABVIEW_MARK = "LabVIEW Measurement"
LABVIEW_TIMES, LABVIEW_COMMENTS = "X_Value", "Comment"

Tags = Mapping[str, Sequence[str]]
"""Cells behind each tag of a header."""


@dataclass(frozen=True)
class ChannelLabels:
    """Labels above a table, by channel.

    Parameters
    ----------
    path : Path
        The file.
    found : Found
        Its table, of which the names may be told otherwise (``names``).
    tags : mapping
        Of the header; none where it is no .lvm file.
    decimal : {".", ","}
        The decimal mark.
    """

    path: Path
    found: FoundTable
    tags: Tags
    decimal: str

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the table's columns; a column of times has its channel's, where each has one."""
        names = self.found.names
        if not self.tags:
            return names
        if self._x_columns == "No":
            return tuple("" if name == LABVIEW_TIMES else name for name in names)
        if names.count(LABVIEW_TIMES) < 2:
            return names
        return tuple(
            f"{LABVIEW_TIMES} ({names[place + 1]})"
            if name == LABVIEW_TIMES and place + 1 < len(names)
            else name
            for place, name in enumerate(names)
        )

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels, in the order of their labels."""
        return tuple(
            n for n in self.found.names if n and n not in (LABVIEW_TIMES, LABVIEW_COMMENTS)
        )

    @property
    def clocks(self) -> dict[str, str]:
        """The column of times of each channel, where each has its own."""
        own = {name: f"{LABVIEW_TIMES} ({name})" for name in self.channels}
        return {name: clock for name, clock in own.items() if clock in self.names}

    @property
    def units(self) -> dict[str, str]:
        """The unit of each channel."""
        return _of(self.tags, "Y_Unit_Label", self.channels)

    @property
    def periods(self) -> dict[str, float]:
        """The time between two samples of each channel, where no column tells times [s]."""
        if LABVIEW_TIMES in self.names or self.clocks:
            return {}
        return self._numbers(self.tags, "Delta_X")

    @property
    def starts(self) -> dict[str, float]:
        """When each channel begins after the first, in addition to columns of times [s]."""
        starts = self._relative(self.tags)
        if not starts or self.clocks:
            return starts
        offsets = self._numbers(self.tags, "X0")
        starts = {name: start + offsets.get(name, 0.0) for name, start in starts.items()}
        if LABVIEW_TIMES not in self.names:
            return starts
        if (
            len(set(starts.values())) > 1
            or len(set(self._numbers(self.tags, "Delta_X").values())) > 1
        ):
            raise RecordingError(
                f"{self.path}: its header says that channels begin or are sampled at other times "
                f"than each other, and {LABVIEW_TIMES} tells one time for all; write the file with "
                "X_Columns Multi"
            )
        return {}

    def begins(self, segments: Sequence[Sequence[Row]]) -> tuple[float, ...]:
        """Return when further segments begin after the first [s]; nothing where none tells it.

        Parameters
        ----------
        segments : sequence of sequence of Row
            The lines before each.

        Raises
        ------
        RecordingError
            If one has other units or steps of time than the first.
        """
        if not self.tags:
            return ()
        first = _instants(self.tags, self.channels)
        begins = []
        for lines in segments:
            tags = _tags(lines)
            self._refuse_others(tags, lines)
            own = _instants(tags, self.channels)
            both = [name for name in self.channels if name in first and name in own]
            begins.append((own[both[0]] - first[both[0]]) / NANOSECONDS if both else np.nan)
        return tuple(begins)

    def _refuse_others(self, tags: Tags, lines: Sequence[Row]) -> None:
        """Refuse a segment that is of another kind than the first."""
        compared = ["Y_Unit_Label", "Delta_X"] + (["X0"] if self.periods else [])
        for tag in compared:
            here, first = _of(tags, tag, self.channels), _of(self.tags, tag, self.channels)
            if here and here != first:
                raise RecordingError(
                    f"{self.path}, line {lines[0].line}: the segment that begins here has the "
                    f"{tag} {', '.join(here.values())}, and the first {', '.join(first.values())}; "
                    "write segments of one kind to a file"
                )

    @property
    def _x_columns(self) -> str:
        return next(iter(self.tags.get("X_Columns", ())), "")

    def _numbers(self, tags: Tags, tag: str) -> dict[str, float]:
        told = _of(tags, tag, self.channels)
        return {name: float(cells.number(each, self.decimal)) for name, each in told.items()}

    def _relative(self, tags: Tags) -> dict[str, float]:
        instants = _instants(tags, self.channels)
        first = min(instants.values(), default=0)
        return {name: (each - first) / NANOSECONDS for name, each in instants.items()}


def channel_labels(
    path: Path, rows: Sequence[Row], found: FoundTable, decimal: str
) -> ChannelLabels:
    """Return the channels' labels in the rows above a table; none where it is no .lvm file.

    Parameters
    ----------
    path : Path
        The file.
    rows : sequence of Row
        Its first.
    found : Found
        Its table.
    decimal : {".", ","}
        The decimal mark.
    """
    marked = bool(rows) and bool(rows[0].cells) and str(rows[0].cells[0]).strip() == LABVIEW_MARK
    return ChannelLabels(path, found, _tags(rows[: found.first]) if marked else {}, decimal)


def _tags(rows: Sequence[Row]) -> dict[str, list[str]]:
    """Return the cells behind each tag; the last counts, which is that of the segment."""
    return {
        str(row.cells[0]).strip(): [str(cell).strip() for cell in row.cells[1:]]
        for row in rows
        if row.cells
    }


def _of(tags: Tags, tag: str, channels: Sequence[str]) -> dict[str, str]:
    """Return a tag's cells by channel; nothing where it has another number of them."""
    told = [cell for cell in tags.get(tag, ()) if cell]
    return dict(zip(channels, told, strict=True)) if len(told) == len(channels) else {}


def _instants(tags: Tags, channels: Sequence[str]) -> dict[str, int]:
    """Return when each channel begins [ns]; nothing where no such times are told."""
    days, clocks = _of(tags, "Date", channels), _of(tags, "Time", channels)
    told = {n: f"{day.replace('/', '-')} {clocks[n]}" for n, day in days.items() if n in clocks}
    try:
        return {name: int(cells.times([each])[0].astype(np.int64)) for name, each in told.items()}
    except ValueError:
        return {}
