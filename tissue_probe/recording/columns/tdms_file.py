"""Channels of TDMS files, which LabVIEW and DIAdem write."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tissue_probe.recording.columns.bounds import check_rows
from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError


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
    except Exception as error:  # npTDMS lets through what struct, NumPy and itself raise
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
        if isinstance(p.get("wf_increment"), float | int) and p["wf_increment"] > 0.0
    }
    return Columns(path, tuple(channels), load, units, periods=periods)
