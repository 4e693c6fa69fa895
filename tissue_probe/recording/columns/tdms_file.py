"""Channels of TDMS files, which LabVIEW and DIAdem write."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tissue_probe.recording.columns.bounds import check_rows
from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import NANOSECONDS


def open_tdms(path: Path) -> Columns:
    """Open a TDMS file; channels are named ``group/channel``, in the units of ``unit_string``.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    from nptdms import TdmsFile

    try:
        with TdmsFile.open(path) as file:
            channels = {
                f"{group.name}/{channel.name}": (group.name, channel.name, dict(channel.properties))
                for group in file.groups()
                for channel in group.channels()
            }
            for group, channel, _ in channels.values():
                check_rows(path, len(file[group][channel]))
    except RecordingError:
        raise
    except Exception as error:  # npTDMS lets errors of struct and NumPy through
        raise RecordingError(f"{path} is not a TDMS file that can be read: {error}") from error

    def load(names: Sequence[str], progress: Progress) -> Loaded:
        try:
            with TdmsFile.open(path) as file:
                columns = [file[channels[n][0]][channels[n][1]][:] for n in names]
        except Exception as error:
            raise RecordingError(f"{path} is not a TDMS file that can be read: {error}") from error
        return Loaded([np.asarray(column) for column in columns])

    units = {n: str(p["unit_string"]) for n, (_, _, p) in channels.items() if p.get("unit_string")}
    periods = {
        n: float(p["wf_increment"])
        for n, (_, _, p) in channels.items()
        if isinstance(p.get("wf_increment"), float | int)
        and 1.0 / NANOSECONDS < p["wf_increment"] < float("inf")
    }
    return Columns(path, tuple(channels), load, units, periods=periods, starts=_starts(channels))


def _starts(channels: Mapping[str, tuple[str, str, Mapping[str, Any]]]) -> dict[str, float]:
    """Return when each channel begins [s]: ``wf_start_time`` and ``wf_start_offset``.

    NaN where nothing tells it of a channel, and it is told of another.
    """
    dates = {n: p["wf_start_time"] for n, (_, _, p) in channels.items() if "wf_start_time" in p}
    dates = {n: date for n, date in dates.items() if isinstance(date, np.datetime64)}
    first = min(dates.values(), default=None)
    found = {}
    for name, (_, _, properties) in channels.items():
        offset = properties.get("wf_start_offset", 0.0)
        offset = float(offset) if isinstance(offset, float | int) else float("nan")
        if name in dates:
            offset += float((dates[name] - first) / np.timedelta64(1, "ns")) / NANOSECONDS
        elif dates:
            offset = float("nan")  # nothing tells it
        if dates or "wf_start_offset" in properties:
            found[name] = offset
    return found
