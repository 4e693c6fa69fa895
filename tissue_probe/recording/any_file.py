"""Reading the measurements of any instrument, from any kind of file.

Contents: choosing the reader by the kind of file. Those of bags are imported only when a bag comes:
they bring all decoders of messages.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from tissue_probe.recording.bags.bag import Bag
from tissue_probe.recording.bags.open_bag import is_bag, open_bag
from tissue_probe.recording.columns.source import Progress
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout
from tissue_probe.recording.tables.table_file import read_table
from tissue_probe.signals import Recording


def read_any(
    path: str | Path, layout: Layout, progress: Progress = lambda share: None
) -> tuple[Recording, tuple[str, ...]]:
    """Read position and force from a recording of this suite, another bag, or columns.

    Returns the recording, and in sentences how it was read.

    Parameters
    ----------
    path : path
        A bag of ROS 1 or 2 (``.mcap``, ``.db3``, ``.bag``, a folder), or a file of columns: text,
        spreadsheet, TDMS, MATLAB, HDF5, NumPy, Parquet.
    layout : Layout
        Where the signals are in it. A recording of this suite needs, and takes, nothing of it.
    progress : callable
        Told the share that is read, from 0 to 1.

    Raises
    ------
    RecordingError
        If it cannot be read, or something that must be stated is not; says which parameter does it.
    """
    recording, notes, _ = read_file(path, layout, progress)
    return recording, notes


class ReadFile(NamedTuple):
    """The contents of a file, how it was read, and whether this suite recorded it."""

    recording: Recording
    notes: tuple[str, ...]
    is_own: bool


def read_file(
    path: str | Path, layout: Layout, progress: Progress = lambda share: None
) -> ReadFile:
    """Read as ``read_any`` does, and tell whether it is a recording of this suite.

    To ask that of the file afterwards would go over all of a bag once more.
    """
    path = Path(path)
    if not is_bag(path):
        if layout.adapter:
            raise RecordingError(f"{path} is no bag of a robot: leave out `adapter`")
        return ReadFile(*read_table(path, layout, progress), is_own=False)
    from tissue_probe.recording.bags.foreign_bag import read_foreign_bag
    from tissue_probe.recording.bags.reader import recording_of

    bag = open_bag(path)
    if layout.adapter:
        from tissue_probe.recording.bags.robot_bag import read_robot_bag
        from tissue_probe.recording.robot.settings import read_settings

        read = read_robot_bag(bag, path, read_settings(layout.adapter), progress)
        return ReadFile(*read, is_own=False)
    if _is_own(bag, layout):
        _refuse_statements(path, layout)
        own = recording_of(bag, path, layout.samples_topic, progress)
        return ReadFile(own, (), is_own=True)
    return ReadFile(*read_foreign_bag(bag, path, layout, progress), is_own=False)


def _is_own(bag: Bag, layout: Layout) -> bool:
    """Whether a bag is a recording of this suite, and is to be read as such."""
    from tissue_probe.recording.bags.reader import has_samples

    return layout.position is None and layout.force is None and has_samples(bag)


def _refuse_statements(path: Path, layout: Layout) -> None:
    if layout.input2:
        raise RecordingError(
            f"{path} is a recording of this suite, which has no further channel: leave out `input2`"
        )
    if layout != Layout(samples_topic=layout.samples_topic):
        raise RecordingError(
            f"{path} is a recording of this suite, in SI units and positive in compression: leave "
            "out the options on units, polarity and rate"
        )
