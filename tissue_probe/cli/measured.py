"""Options on measured data, which all commands share, and reading by them.

What belongs here: how the user names the signals in any file, and the stretches that come of it.
What does not: reading files (``recording``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from tissue_probe.recording.layout import Layout
    from tissue_probe.recording.stretches import Stretch
    from tissue_probe.signals import BoolArray, FloatArray, Recording, SampleBlock


LARGE = 2**25
"""Size of a file from which reading takes so long that it is worth showing [bytes]."""


class Polarity(str, Enum):
    """Which forces are positive in a file."""

    compression = "compression"
    tension = "tension"


class Direction(str, Enum):
    """Where positions of a file grow to."""

    into = "into"
    out = "out"


class Starts(str, Enum):
    """Whether the probe had been at rest before the first sample."""

    at_rest = "at-rest"
    moving = "moving"
    auto = "auto"


_FILES = (
    "a recording of this suite, a bag of ROS 1 or 2 (.mcap, .db3, .bag, folder), or columns (text, "
    "spreadsheet, .tdms, .mat, HDF5, .npz, .parquet)"
)

Measurements = Annotated[
    list[Path],
    typer.Argument(
        help=f"Measurements of one specimen: {_FILES}.",
        metavar="MEASUREMENTS...",
    ),
]

Samples = Annotated[Path, typer.Argument(help=f"Measurement: {_FILES}.", metavar="SAMPLES")]

Position = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="Displacement of the coil, or of the tip where a force drives (a velocity is "
        "integrated): a column (by default u, position or a usual name; group/channel, "
        "sheet!column, matrix[:,2], or its number), or a field of a topic, such as "
        "/pose.pose.position.z.",
    ),
]

Force = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="Load-cell force, or the force that drives: a column (by default F, "
        "force or a usual name), or a field of a topic, such as "
        "/ft.wrench.force.z.",
    ),
]

Time = Annotated[
    str | None,
    typer.Option(
        metavar="COLUMN",
        help="Time [s], or in the unit at the name's end (t_ms); by default t, time or a usual "
        "name.",
    ),
]

TimeUnit = Annotated[
    str | None,
    typer.Option(
        metavar="UNIT",
        help="s, ms, us, ns, min or h; by default that at the name's end (t_ms), or s.",
    ),
]

SampleRate = Annotated[
    float | None,
    typer.Option(metavar="HERTZ", help="Samples a second, where there is no column of time."),
]

PositionUnit = Annotated[
    str | None,
    typer.Option(
        metavar="UNIT",
        help="m, cm, mm, um, nm, in, or the size of one in metres; of a velocity mm/s and the "
        "like; by default that of the file (u_mm, a row of units); u alone is in SI units.",
    ),
]

ForceUnit = Annotated[
    str | None,
    typer.Option(
        metavar="UNIT",
        help="N, mN, uN, nN, kN, gf, kgf, lbf, or the size of one in newtons; by default that of "
        "the file (F_mN, a row of units); F alone is in SI units.",
    ),
]


class Clock(str, Enum):
    """Whose clock counts in a bag."""

    stamps = "stamps"
    recorder = "recorder"


ClockOption = Annotated[
    Clock | None,
    typer.Option(
        "--clock",
        help="Of a bag whose clocks disagree: go by the stamps as they are, or by the recorder's.",
        show_default=False,
    ),
]

ForcePolarity = Annotated[
    Polarity | None, typer.Option(help="Which forces are positive in the file.", show_default=False)
]

PositionPolarity = Annotated[
    Direction, typer.Option(help="Whether positions grow into the tissue, or out of it (heights).")
]

SamplesTopic = Annotated[
    str | None,
    typer.Option(
        "--topic", metavar="TOPIC", help="Topic of the samples, where the recording has several."
    ),
]

Site = Annotated[
    int | None,
    typer.Option(metavar="NUMBER", help="Site of a scan; each is another piece of tissue."),
]

Lowpass = Annotated[
    float | None,
    typer.Option(
        metavar="HERTZ",
        help="Take out of position and force alike what is faster, and keep 2.5 samples a cycle "
        "of it.",
    ),
]

StartsOption = Annotated[
    Starts, typer.Option("--starts", help="Whether the probe rested before the first sample.")
]


@dataclass(frozen=True)
class Segment:
    """Evenly spaced samples without a hole.

    Attributes
    ----------
    source : str
        Which file, and which part of it.
    position, force : array, shape (n,)
        Displacement of the coil [m]; load-cell force [N], positive in compression; finite.
    command : array, shape (n,)
        Voltage commanded to the coil [V]; NaN where it is not known.
    measured : array of bool, shape (n,)
        Which samples are as they were measured, and not filled in.
    sample_period : float
        [s].
    starts : Starts
        As the user says.
    run : str
        Which file.
    begins : float
        Time of the first sample after the file's first that is used [s].
    time_doubt : float
        By how much position and force may be apart in time [s].
    notes : tuple of str
        What was done to read it, in sentences; those on a file stand with its first segment.
    """

    source: str
    position: FloatArray
    force: FloatArray
    command: FloatArray
    measured: BoolArray
    sample_period: float
    starts: Starts
    run: str = ""
    begins: float = 0.0
    time_doubt: float = 0.0
    notes: tuple[str, ...] = ()


def layout(
    position: str | None,
    force: str | None,
    time: str | None,
    sample_rate: float | None,
    position_unit: str | None,
    force_unit: str | None,
    time_unit: str | None,
    force_polarity: Polarity | None,
    position_polarity: Direction,
    topic: str | None,
    clock: Clock | None = None,
) -> Layout:
    """Make of the options what the readers take.

    Raises
    ------
    ValueError
        If they contradict each other.
    """
    from tissue_probe.recording.layout import Layout

    return Layout(
        position=position,
        force=force,
        time=time,
        position_unit=position_unit,
        force_unit=force_unit,
        time_unit=time_unit,
        force_polarity=force_polarity.value if force_polarity else None,
        position_polarity=position_polarity.value,
        sample_rate=sample_rate,
        samples_topic=topic,
        clock=clock.value if clock else None,
    )


def read(path: Path, layout: Layout) -> tuple[Recording, tuple[str, ...]]:
    """Read a file of any kind; a large one with a bar that shows how far it is.

    Returns the recording, and how it was read, in sentences.

    Raises
    ------
    RecordingError
        If it cannot be read, or does not tell all that is needed; says which parameter does it.
    """
    from rich.console import Console
    from rich.progress import Progress

    from tissue_probe.recording.any_file import read_any

    files = [each for each in path.rglob("*") if each.is_file()] if path.is_dir() else [path]
    if sum(each.stat().st_size for each in files) < LARGE:
        return read_any(path, layout)
    with Progress(console=Console(stderr=True), transient=True) as shown:
        bar = shown.add_task(f"reading {path.name}", total=1.0)
        return read_any(path, layout, lambda share: shown.update(bar, completed=share))


def read_measured(
    paths: Sequence[Path],
    layout: Layout,
    starts: Starts = Starts.auto,
    site: int | None = None,
    lowpass: float | None = None,
) -> list[Segment]:
    """Read measurements, cut into segments where samples are missing.

    Pieces too short to tell the stiffness are left out where a file has others. Only a file's first
    segment starts at rest, if the user says so.

    Raises
    ------
    RecordingError
        If a file cannot be read, or does not tell all that is needed; says which option does.
    """
    return [segment for path in paths for segment in _segments(path, layout, starts, site, lowpass)]


def _segments(
    path: Path, layout: Layout, starts: Starts, site: int | None, lowpass: float | None
) -> list[Segment]:
    from tissue_probe.recording.errors import RecordingError
    from tissue_probe.recording.lowpass import lowpassed
    from tissue_probe.recording.stretches import dwell_blocks, known_stretches
    from tissue_probe.signals import NANOSECONDS

    recording, notes = read(path, layout)
    blocks = dwell_blocks(recording, site)
    cut = [known_stretches(block) for block in blocks]
    stretches = [stretch for found, _ in cut for stretch in found]
    if not stretches:
        raise RecordingError(f"{path} has no sample whose position and force are both known")
    known = [found for found, _ in cut]
    told = [*notes, *_told_unknown(path, blocks, known), *_told_pieces(path, stretches)]
    chosen = [stretch for stretch in stretches if _is_long(stretch)] or stretches
    segments = []
    for number, piece in enumerate(chosen):
        stretch = lowpassed(piece, lowpass) if lowpass else piece
        every = round(stretch.sample_period / piece.sample_period)
        rested = starts if piece is stretches[0] or starts != Starts.at_rest else Starts.moving
        part = f", part {number + 1}" if len(chosen) > 1 else ""
        segments.append(
            Segment(
                f"{path}{part}",
                stretch.position,
                stretch.force,
                stretch.command,
                piece.measured[::every],
                stretch.sample_period,
                rested,
                str(path),
                (stretch.stamp - chosen[0].stamp) / NANOSECONDS,
                recording.time_doubt,
                tuple(told) if number == 0 else (),
            )
        )
    return segments


def _is_long(block: SampleBlock) -> bool:
    """Whether a piece tells the stiffness by itself, as a whole recording must."""
    from tissue_probe.diagnosis.inspection.information import ENOUGH, stiffness_deviation

    return stiffness_deviation(block.position, block.force, block.sample_period) < ENOUGH


def _told_unknown(
    path: Path, blocks: Sequence[SampleBlock], known: Sequence[Sequence[Stretch]]
) -> list[str]:
    """Say what was filled in, and what is not known for longer."""
    from tissue_probe.recording.stretches import unknown_runs
    from tissue_probe.signals import NANOSECONDS

    told = []
    filled = sum(int((~stretch.measured).sum()) for found in known for stretch in found)
    if filled:
        told.append(
            f"{path}: {filled} missing samples filled in by a cubic spline, and left out of the fit"
        )
    runs = [
        (stop - first, block.stamps[first])
        for block, found in zip(blocks, known, strict=True)
        for first, stop in unknown_runs(block, found)
    ]
    if runs:
        longest, stamp = max(runs, key=lambda run: run[0])
        begun = (stamp - blocks[0].stamp) / NANOSECONDS
        told.append(
            f"{path}: {sum(count for count, _ in runs)} samples in "
            f"{len(runs)} run{'s' if len(runs) > 1 else ''} are not known, {longest} of them "
            f"{begun:.4g} s after the first sample; cut out there"
        )
    return told


def _told_pieces(path: Path, stretches: Sequence[Stretch]) -> list[str]:
    """Say how much was left out with pieces that are too short."""
    sizes = [len(stretch) for stretch in stretches]
    kept = [len(stretch) for stretch in stretches if _is_long(stretch)]
    if not 0 < len(kept) < len(sizes):
        return []
    short = len(sizes) - len(kept)
    pieces = "1 piece between gaps is" if short == 1 else f"{short} pieces between gaps are"
    return [f"{path}: {pieces} too short to be used; {sum(kept)} of {sum(sizes)} samples remain"]
