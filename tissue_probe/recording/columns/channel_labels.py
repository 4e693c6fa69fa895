"""What a LabVIEW measurement file (.lvm) tells of each channel above its table.

What belongs here: units, starts and steps of time by channel, in rows that begin with a tag.
What does not: the table itself, which is found as in any text (``find_table``).

Source: National Instruments (2010), Specification for the LabVIEW Measurement File (.lvm).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tissue_probe.recording.columns import cells
from tissue_probe.recording.columns.find_table import Found, Row
from tissue_probe.signals import NANOSECONDS

MARK = "LabVIEW Measurement"
TIMES, COMMENTS = "X_Value", "Comment"


class ChannelLabels(NamedTuple):
    """Names of a table's columns, and what is told of them, as ``source.Columns`` has it."""

    names: tuple[str, ...]
    units: Mapping[str, str]
    periods: Mapping[str, float]
    starts: Mapping[str, float]
    clocks: Mapping[str, str]


def channel_labels(rows: Sequence[Row], found: Found, decimal: str) -> ChannelLabels:
    """Return what the rows above a table tell of its channels; nothing where it is no .lvm file.

    Parameters
    ----------
    rows : sequence of Row
        The file's first.
    found : Found
        Its table.
    decimal : {".", ","}
        The decimal mark.
    """
    names, clocks = _with_clocks(found.names)
    if not rows or rows[0].text.strip() != MARK:
        return ChannelLabels(found.names, {}, {}, {}, {})
    channels = [name for name in names if name not in ("", COMMENTS, *clocks.values(), TIMES)]
    tags = {
        str(row.cells[0]).strip(): [str(cell).strip() for cell in row.cells[1:]]
        for row in rows[: found.first]
        if row.cells
    }

    def of(tag: str) -> dict[str, str]:
        told = [cell for cell in tags.get(tag, ()) if cell]
        return dict(zip(channels, told, strict=True)) if len(told) == len(channels) else {}

    units = of("Y_Unit_Label")
    if TIMES in names or clocks:
        return ChannelLabels(names, units, {}, {}, clocks)
    periods = {name: float(cells.number(told, decimal)) for name, told in of("Delta_X").items()}
    dates, offsets = _dates(of("Date"), of("Time")), of("X0")
    starts = {
        name: (dates[name] - min(dates.values())) / NANOSECONDS
        + float(cells.number(offsets.get(name, "0"), decimal))
        for name in dates
    }
    return ChannelLabels(names, units, periods, starts, clocks)


def _with_clocks(names: Sequence[str]) -> tuple[tuple[str, ...], dict[str, str]]:
    """Return names of which each column of times has its channel's, and which is whose."""
    if names.count(TIMES) < 2:
        return tuple(names), {}
    own, clocks = list(names), {}
    for place, name in enumerate(names[:-1]):
        if name == TIMES:
            own[place] = f"{TIMES} ({names[place + 1]})"
            clocks[names[place + 1]] = own[place]
    return tuple(own), clocks


def _dates(days: Mapping[str, str], clocks: Mapping[str, str]) -> dict[str, int]:
    """Return when each channel begins [ns]; nothing where the file tells no such times."""
    told = {name: f"{day.replace('/', '-')} {clocks.get(name, '')}" for name, day in days.items()}
    try:
        return {name: int(cells.times([each])[0].astype(np.int64)) for name, each in told.items()}
    except ValueError:
        return {}
