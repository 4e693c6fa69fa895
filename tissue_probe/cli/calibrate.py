"""``tissue_probe calibrate``: the instrument's constants, from recordings into one YAML file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from tissue_probe.identification.line import CalibrationLine
    from tissue_probe.signals import FloatArray, Recording, SampleBlock

from tissue_probe.cli.arguments import Bag
from tissue_probe.cli.measurement_options import Samples

calibrate = typer.Typer(
    help="Measure the probe's own constants, kept in a YAML file.\n\n"
    "Each step reads recordings and updates the file, which the driver loads (parameter "
    "calibration_file). A recording gives its volts and counts by the calibration in it.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

File = Annotated[
    Path,
    typer.Option(
        "--calibration",
        metavar="FILE",
        help="YAML file to update; begins with the paper's nominal values if not there.",
    ),
]
Instruments = Annotated[
    list[str] | None,
    typer.Option(
        "--instrument",
        metavar="NAME=SERIAL",
        help="Type and serial number to keep, such as 'load cell=LCL-005 no. 1234'.",
    ),
]
Readings = Annotated[
    list[str],
    typer.Argument(
        metavar="KNOWN=SAMPLES...",
        help="At least three: a known value, and the recording (or table) made there.",
    ),
]
Column = Annotated[str, typer.Option(metavar="COLUMN", help="Of the raw readings in a table.")]

CALIBRATION = Path("calibration.yaml")


@calibrate.command()
def force(
    readings: Readings,
    calibration: File = CALIBRATION,
    instrument: Instruments = None,
    column: Column = "V",
    gravity: Annotated[
        float,
        typer.Option(metavar="M/S2", min=9.7, max=9.9, help="Of the place [m/s^2]."),
    ] = 9.80665,
) -> None:
    """Find volts to newtons and polarity, from known weights.

    KNOWN is the mass [kg] that presses on the load cell, negative where it pulls; the coil is off.
    A straight line through the mean volts [V] gives the gain [N/V], the volts without load, and
    which forces raise the voltage.
    """
    from tissue_probe.analysis.raw import raw_volts
    from tissue_probe.cli.calibration_file import update

    line = _line(readings, raw_volts, column, gravity)
    gain = abs(line.scale)
    low, high = sorted(map(abs, line.scale_interval))
    update(
        calibration,
        instrument or [],
        {
            "force_per_volt": gain,
            "force_offset_volts": line.intercept,
            "force_polarity": "compression" if line.scale > 0.0 else "tension",
        },
        {"force_per_volt": (low, high), "force_offset_volts": line.intercept_interval},
    )
    print(f"Largest deviation from the line: {1e3 * gain * abs(line.residuals).max():.3g} mN")


@calibrate.command()
def position(
    readings: Readings,
    calibration: File = CALIBRATION,
    instrument: Instruments = None,
    column: Column = "counts",
) -> None:
    """Find counts to metres, from a known travel.

    KNOWN is the coil's displacement [m] by a gauge, positive into the tissue; the coil is off.
    """
    from tissue_probe.analysis.raw import raw_counts
    from tissue_probe.cli.calibration_file import update

    line = _line(readings, raw_counts, column)
    update(
        calibration,
        instrument or [],
        {"position_per_count": line.scale},
        {"position_per_count": line.scale_interval},
    )
    largest = abs(line.scale * line.residuals).max()
    print(f"Largest deviation from the line: {1e6 * largest:.3g} um")


@calibrate.command()
def tool(
    samples: Samples,
    tip_mass: Annotated[
        float,
        typer.Option(metavar="KG", min=1e-6, max=1.0, help="Mass m of the tip [kg]."),
    ],
    calibration: File = CALIBRATION,
    instrument: Instruments = None,
    tip_mass_error: Annotated[
        float, typer.Option(metavar="KG", min=0.0, max=0.1, help="Its standard deviation [kg].")
    ] = 0.0,
    column: Annotated[str, typer.Option(metavar="COLUMN", help="Of the force in a table.")] = "F",
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="Picture: .png, .svg or .pdf.")
    ] = Path("ring_down.png"),
) -> None:
    """Find stiffness and damping of the tool, from one impulse.

    With the coil off, in free air, strike the tip once and record until it is at rest. The fit of
    its swing gives k0 [N/m] and beta0 [N s/m]; the unit of the force does not matter.
    """
    from tissue_probe.cli.calibration_file import update
    from tissue_probe.figures.ring_down import draw_ring_down
    from tissue_probe.identification.line import CONFIDENCE_QUANTILE
    from tissue_probe.identification.ring_down import fit_ring_down

    recording = _read(samples, column)
    block = _take_whole(recording, samples)
    found = fit_ring_down(block.force, block.sample_period, tip_mass, tip_mass_error)
    spread = CONFIDENCE_QUANTILE * tip_mass_error
    update(
        calibration,
        instrument or [],
        {
            "tip_mass": tip_mass,
            "load_cell_stiffness": found.stiffness,
            "load_cell_damping": found.damping,
        },
        {
            "tip_mass": (tip_mass - spread, tip_mass + spread),
            "load_cell_stiffness": found.stiffness_interval,
            "load_cell_damping": found.damping_interval,
        },
    )
    draw_ring_down(block.force, block.sample_period, found).savefig(output, dpi=100)
    print(f"Resonance: {found.frequency:.2f} Hz; the fit is drawn in {output}")


@calibrate.command()
def delay(
    samples: Samples, calibration: File = CALIBRATION, instrument: Instruments = None
) -> None:
    """Find the delay of the force channel, from a run in free air.

    The coil moves at 10 Hz or more for 5 s or longer (at 2 Hz, widely, for a minute, where a slow
    decoder allows no more); calibrate the tool before. From the next
    configuration on the driver takes the delay [s] of the force after the position out of its
    samples: 0.1 ms would cost some 3 % of k at 30 Hz. A delay that it took out already counts.
    """
    from tissue_probe.analysis.raw import recalibrate
    from tissue_probe.cli.calibration_file import load, update
    from tissue_probe.identification.delay import force_delay

    before = load(calibration)
    recording = _read(samples)
    if not _is_table(samples):
        recording = recalibrate(recording, before)
    block = _take_whole(recording, samples)
    tool = before.tip_mass, before.load_cell_stiffness, before.load_cell_damping
    found = force_delay(block.position, block.force, block.sample_period, *tool)
    corrected = 0.0 if _is_table(samples) else before.force_delay
    low, high = (corrected + end for end in found.interval)
    update(
        calibration,
        instrument or [],
        {"force_delay": corrected + found.seconds},
        {"force_delay": (low, high)},
    )


@calibrate.command()
def tare(bag: Bag, calibration: File = CALIBRATION) -> None:
    """Find the volts without load, from a run in free air.

    The coil moves at 10 Hz or slower for a second or longer, so that contact can be told from an
    offset; in contact it is refused. The running driver does the same by its service tare.
    """
    from tissue_probe.analysis.raw import raw_counts, raw_volts
    from tissue_probe.cli.calibration_file import load, update
    from tissue_probe.identification.free_air import free_air_zero

    before = load(calibration)
    recording = _read(bag)
    period = _take_whole(recording, bag).sample_period
    # By the file's own numbers: with a wrong sign contact would look like free air.
    position = before.position(raw_counts(recording))
    force = before.force(raw_volts(recording))
    tool = before.tip_mass, before.load_cell_stiffness
    zero = free_air_zero(position, force, period, *tool)
    update(calibration, [], {"force_offset_volts": float(before.volts(zero))}, {})


def _line(
    readings: Sequence[str],
    raw: Callable[[Recording], FloatArray],
    column: str,
    unit: float = 1.0,
) -> CalibrationLine:
    """Fit the mean of the raw readings to the known values, which are given in ``unit``."""
    import numpy as np

    from tissue_probe.identification.line import fit_line

    known, means = [], []
    for reading in readings:
        value, _, path = reading.partition("=")
        try:
            known.append(unit * float(value))
        except ValueError:
            path = ""
        if not path:
            raise ValueError(f"{reading}: write KNOWN=SAMPLES, such as 0.1=hundred_grams.mcap")
        recording = _read(Path(path), column)
        # A table holds the raw readings themselves.
        values = recording.position if _is_table(Path(path)) else raw(recording)
        means.append(float(np.mean(values)))
    return fit_line(np.array(known), np.array(means))


def _read(path: Path, raw: str | None = None) -> Recording:
    """Read a recording; of a table the raw readings in a column, or the signals in SI units."""
    from tissue_probe.cli.measurement_options import read
    from tissue_probe.recording.layout import Layout

    layout = Layout()
    if raw is not None and _is_table(path):
        layout = Layout(raw, raw, position_unit="1", force_unit="1", force_polarity="compression")
    return read([path], layout).parts[0].recording


def _is_table(path: Path) -> bool:
    from tissue_probe.recording.bags.open_bag import is_bag

    return not is_bag(path)


def _take_whole(recording: Recording, path: Path) -> SampleBlock:
    """Return the samples if none is missing between them: a fit needs them so."""
    if len(recording.blocks) > 1:
        raise ValueError(f"{path} has gaps between its samples: record one run without")
    return recording.blocks[0]
