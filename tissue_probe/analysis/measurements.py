"""Measurements of one specimen: files of any kind, data frames or arrays, as one object.

Contents: ``read``, and how the result shows itself.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tissue_probe import arguments as take
from tissue_probe.errors import ParameterError
from tissue_probe.likeness import Alike
from tissue_probe.recording.any_file import read_file
from tissue_probe.recording.bags.open_bag import is_bag
from tissue_probe.recording.columns.in_memory import columns_in_memory
from tissue_probe.recording.columns.source import Progress
from tissue_probe.recording.digest import digest
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Clock, ForcePolarity, Layout, PositionPolarity
from tissue_probe.recording.tables.table_file import read_columns
from tissue_probe.signals import NANOSECONDS, FloatArray, Recording

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

#: How messages call a table that is in memory.
IN_MEMORY = "table"


@dataclass(frozen=True, eq=False)
class ReadRecording(Alike):
    """One recording as it was read.

    Attributes
    ----------
    name : str
        Its file as the user gave it, or ``table 1`` and so on.
    path : Path or None
        Its file; None for arrays and data frames.
    recording : Recording
        Its samples and sites.
    notes : tuple of str
        How it was read, in sentences.
    is_own : bool
        Whether this suite recorded it.
    origin : int
        Where its time is zero [ns]: the first sample of a bag, a table's own zero.
    layout : tuple of pairs
        Statements on its signals, by name.
    """

    name: str
    path: Path | None
    recording: Recording
    notes: tuple[str, ...]
    is_own: bool = False
    origin: int = 0
    layout: tuple[tuple[str, Any], ...] = ()

    def is_same(self, other: ReadRecording) -> bool:
        """Whether it has the very samples of another: the same file, by any path, or a copy.

        Two sheets of a file, or two sensors of a bag, are two recordings.
        """
        ours, theirs = self.recording, other.recording
        return len(ours) == len(theirs) and all(
            np.array_equal(getattr(ours, name), getattr(theirs, name), equal_nan=True)
            for name in ("position", "force")
        )

    def digest(self) -> str:
        """Return the SHA-256 of the file's bytes, or of the samples where there is no file."""
        if self.path is not None:
            return digest(self.path)
        found = hashlib.sha256()
        for column in (self.recording.stamps, self.recording.position, self.recording.force):
            found.update(np.ascontiguousarray(column).tobytes())
        return found.hexdigest()


#: The source of ``Measurements``, in words.
READ = "recordings that `tissue_probe.read` returned"


@dataclass(frozen=True, eq=False, repr=False)
class Measurements(Alike):
    """Recordings of one specimen, which are fitted together.

    Attributes
    ----------
    parts : tuple of ReadRecording
        One a file or table, in the order given.
    """

    parts: tuple[ReadRecording, ...]

    def __post_init__(self) -> None:
        recordings = take.several(take.instance(ReadRecording, READ), READ)
        object.__setattr__(self, "parts", recordings("parts", self.parts))

    @property
    def notes(self) -> tuple[str, ...]:
        """How everything was read, in sentences."""
        return tuple(note for part in self.parts for note in part.notes)

    @property
    def time(self) -> FloatArray:
        """Time of each sample [s], of a bag since its first sample, of a table since its zero."""
        return np.concatenate([(p.recording.stamps - p.origin) / NANOSECONDS for p in self.parts])

    @property
    def position(self) -> FloatArray:
        """Displacement of the coil, or of the tip where a force drives, at each sample [m]."""
        return np.concatenate([part.recording.position for part in self.parts])

    @property
    def force(self) -> FloatArray:
        """Force at each sample [N], positive in compression."""
        return np.concatenate([part.recording.force for part in self.parts])

    def __len__(self) -> int:
        return sum(len(part.recording) for part in self.parts)

    def __repr__(self) -> str:
        lines = [_describe_part(part) for part in self.parts[:20]]
        lines += [f"... and {len(self.parts) - 20} more"] if len(self.parts) > 20 else []
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes[:15])])

    def to_frame(self) -> pd.DataFrame:
        """Return time [s], position [m] and force [N] as a pandas data frame, a row a sample.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        import pandas as pd

        return pd.DataFrame({"time": self.time, "position": self.position, "force": self.force})

    def plot(self) -> Figure:
        """Draw position and force over time, one below the other."""
        from tissue_probe.figures.samples import draw_samples

        recordings = [
            ((p.recording.stamps - p.origin) / NANOSECONDS, p.recording.position, p.recording.force)
            for p in self.parts
        ]
        return draw_samples(recordings, [part.name for part in self.parts])


#: Anything that ``read`` takes: a file's path, arrays by name, a data frame, or its own result.
Source = Any


@take.checks(progress=take.optional(take.function))
def read(
    *sources: Source,
    position: str | None = None,
    force: str | None = None,
    time: str | None = None,
    sample_rate: float | None = None,
    position_unit: str | None = None,
    force_unit: str | None = None,
    time_unit: str | None = None,
    force_polarity: ForcePolarity | None = None,
    position_polarity: PositionPolarity = "into",
    samples_topic: str | None = None,
    clock: Clock | None = None,
    input2: str | None = None,
    adapter: str | None = None,
    progress: Progress | None = None,
) -> Measurements:
    """Read measurements of one specimen.

    Parameters
    ----------
    *sources : path, data frame, or mapping of arrays
        A recording of this suite, a bag of ROS 1 or 2, columns in text, a spreadsheet, TDMS,
        MATLAB, HDF5, NumPy or Parquet; a data frame of pandas or polars; arrays by name.
    position, force, time : str, optional
        Names of columns, or fields of topics; by default usual names, such as ``u_mm``.
    sample_rate : float, optional
        Samples a second [Hz], where there is no column of time.
    position_unit, force_unit, time_unit : str, optional
        By default that at the name's end, or told by the file, or SI.
    force_polarity : {"compression", "tension"}, optional
        Which forces are positive in the file.
    position_polarity : {"into", "out"}
        Whether positions grow into the tissue, or out of it.
    samples_topic : str, optional
        Topic of the samples, where a recording of this suite has several.
    clock : {"stamps", "recorder"}, optional
        Whose clock counts in a bag whose clocks disagree.
    input2 : str, optional
        Name of a column, or field of a topic, of a further channel that may drive the force: a
        pressure, a voltage, a temperature. In its own unit, finite; ``second_input`` is a candidate
        then, and a second recording needs the channel as well.
    adapter : str, optional
        Parameter file of the node ``adapter``: a robot's bag is read as that node hears the robot,
        to the last bit.
    progress : callable, optional
        Told the share that is read, from 0 to 1; an exception that it raises ends the reading.

    Raises
    ------
    RecordingError
        If something cannot be read, or does not tell all that is needed; names the parameter.
    ParameterError
        If a recording is given twice.
    """
    if not sources:
        raise TypeError("read() needs a file or a table")
    layout = Layout(
        position=position,
        force=force,
        time=time,
        position_unit=position_unit,
        force_unit=force_unit,
        time_unit=time_unit,
        force_polarity=force_polarity,
        position_polarity=position_polarity,
        sample_rate=sample_rate,
        samples_topic=samples_topic,
        clock=clock,
        input2=input2,
        adapter=adapter,
    )
    layout.check_signals()
    return read_by(layout, sources, progress)


def read_by(
    layout: Layout, sources: Sequence[Source], progress: Progress | None = None
) -> Measurements:
    """Read measurements as ``read`` does, by a layout of their signals."""
    told = progress or (lambda share: None)
    count = len(sources)
    parts = []
    for number, source in enumerate(sources):

        def advance(share: float, before: int = number) -> None:
            told((before + share) / count)

        parts += _read_one(source, layout, advance, f"{IN_MEMORY} {number + 1}")
    _refuse_repeats(parts)
    return Measurements(tuple(parts))


def _refuse_repeats(parts: Sequence[ReadRecording]) -> None:
    """Refuse a recording that is given twice: it would count twice, and look surer than it is."""
    for one, other in combinations(parts, 2):
        if one.is_same(other):
            raise ParameterError(
                f"{other.name} has the same samples as {one.name}, which would count twice: leave "
                "one of them out"
            )


def measurements_of(
    source: Source | Sequence[Source], like: Measurements | None = None
) -> Measurements:
    """Return measurements as they are; read anything else as others were read, if there are any.

    Raises
    ------
    RecordingError
        If it cannot be read; says that it is ``read`` that takes more on it.
    """
    if isinstance(source, Measurements) and source.parts:
        return source
    several = isinstance(source, Sequence) and not isinstance(source, str)
    if isinstance(source, Measurements) or (several and not len(source)):
        raise ParameterError("no recording is given: give a file, a table or several of these")
    stated = dict(like.parts[0].layout) if like and like.parts else {}
    try:
        return read_by(Layout(**stated), list(source) if several else [source])
    except RecordingError as error:
        if "`" not in str(error):
            raise
        raise RecordingError(f"{error} (all of it in `tissue_probe.read`, not here)") from error


def _read_one(source: Source, layout: Layout, progress: Progress, name: str) -> list[ReadRecording]:
    if isinstance(source, Measurements):
        return list(source.parts)
    if isinstance(source, (str, os.PathLike)):
        path = Path(source)
        recording, notes, own = read_file(path, layout, progress)
        origin = recording.blocks[0].stamp if is_bag(path) and recording.blocks else 0
        return [ReadRecording(str(path), path, recording, notes, own, origin, layout.stated)]
    recording, notes = read_columns(columns_in_memory(source, name), layout, progress)
    return [ReadRecording(name, None, recording, notes, layout=layout.stated)]


def _describe_part(part: ReadRecording) -> str:
    recording = part.recording
    period = recording.blocks[0].sample_period if recording.blocks else float("nan")
    text = (
        f"{part.name}: {len(recording)} samples, {1.0 / period:.6g} a second, position "
        f"{_span(1e3 * recording.position)} mm, force {_span(recording.force)} N"
    )
    if len(recording.blocks) > 1:
        text += f", in {len(recording.blocks)} pieces"
    return text


def _span(values: FloatArray) -> str:
    known = values[np.isfinite(values)]
    return f"{known.min():.4g} to {known.max():.4g}" if known.size else "not known"
