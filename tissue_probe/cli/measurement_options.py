"""Options on measured data, which all commands share, and reading by them.

Contents: how the user names the signals in any file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tissue_probe.analysis.choices import OWN_RIG, FilteredRig
from tissue_probe.cli.options_named import with_options

if TYPE_CHECKING:
    from tissue_probe.analysis.measurements import Measurements as MeasurementsRead
    from tissue_probe.recording.layout import Layout


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


_FILES = (
    "a recording of this suite, a bag of ROS 1 or 2 (.mcap, .db3, .bag, folder), or columns (text, "
    "spreadsheet, .tdms, .mat, HDF5, .npz, .parquet)"
)


def check_there(paths: Sequence[Path]) -> None:
    """Refuse files that are not there, before anything is imported that reads or fits.

    Raises
    ------
    OSError
        If one cannot be found.
    """
    for path in paths:
        path.stat()


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


AdapterFile = Annotated[
    str | None,
    typer.Option(
        "--adapter",
        metavar="FILE",
        help="Parameter file of the node adapter: read a robot's bag as that node hears the robot, "
        "to the last bit.",
        show_default=False,
    ),
]


Input2 = Annotated[
    str | None,
    typer.Option(
        "--input2",
        metavar="NAME",
        help="A further channel that may drive the force, such as a pressure, a voltage or a "
        "temperature: a column, or a field of a topic; in its own unit.",
        show_default=False,
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


FilteredRigOption = Annotated[
    FilteredRig | None,
    typer.Option(
        "--rig",
        help="How the instrument couples to the tissue; a filter takes no force that drives.",
        show_default=f"the recording's own, else {OWN_RIG}",
    ),
]


@dataclass
class Signals:
    """Options on where the signals are in a file, and how they are written there."""

    position: Position = None
    force: Force = None
    time: Time = None
    sample_rate: SampleRate = None
    position_unit: PositionUnit = None
    force_unit: ForceUnit = None
    time_unit: TimeUnit = None
    force_polarity: ForcePolarity = None
    position_polarity: PositionPolarity = Direction.into
    topic: SamplesTopic = None
    clock: ClockOption = None
    input2: Input2 = None
    adapter: AdapterFile = None

    def layout(self) -> Layout:
        """Make the readers' layout of the options.

        Raises
        ------
        ValueError
            If they contradict each other.
        """
        from tissue_probe.recording.layout import Layout

        found = Layout(
            position=self.position,
            force=self.force,
            time=self.time,
            position_unit=self.position_unit,
            force_unit=self.force_unit,
            time_unit=self.time_unit,
            force_polarity=self.force_polarity.value if self.force_polarity else None,
            position_polarity=self.position_polarity.value,
            sample_rate=self.sample_rate,
            samples_topic=self.topic,
            clock=self.clock.value if self.clock else None,
            input2=self.input2,
            adapter=self.adapter,
        )
        found.check_signals()
        return found


def read(paths: Sequence[Path], layout: Layout) -> MeasurementsRead:
    """Read files of any kind; large ones with a bar that shows how far it is.

    Raises
    ------
    RecordingError
        If one cannot be read, or does not tell all that is needed; says which parameter does it.
    """
    from rich.console import Console
    from rich.progress import Progress

    from tissue_probe.analysis.measurements import read_by

    files = (f for path in paths for f in (path.rglob("*") if path.is_dir() else [path]))
    if sum(each.stat().st_size for each in files if each.is_file()) < LARGE:
        return read_by(layout, paths)
    with Progress(console=Console(stderr=True), transient=True) as shown:
        bar = shown.add_task(f"reading {', '.join(path.name for path in paths)}", total=1.0)
        return read_by(layout, paths, lambda share: shown.update(bar, completed=share))


def tell(notes: Sequence[str]) -> None:
    """Print how samples were read, and their faults."""
    for note in notes:
        print(f"note: {with_options(note)}")


@contextmanager
def under_way() -> Iterator[Callable[[str], None]]:
    """Show the step under way: on a terminal in one line that changes, else a line each."""
    from rich.console import Console
    from rich.live import Live

    console = Console(stderr=True, highlight=False, markup=False)
    if not console.is_terminal:
        yield lambda doing: console.print(f"... {doing}", soft_wrap=True)
        return
    # Refreshed by nobody else: a search makes no copy of a process that has other threads.
    with Live(console=console, auto_refresh=False, transient=True) as shown:
        yield lambda doing: shown.update(f"... {doing}", refresh=True)
