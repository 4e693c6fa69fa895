"""``tissue_probe export``: the samples of any file as a table of this suite."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli import measurement_options
from tissue_probe.cli.arguments import Table
from tissue_probe.cli.groups import add_groups


@add_groups
def export(
    samples: measurement_options.Samples,
    signals: measurement_options.Signals,
    output: Table = Path("samples.csv"),
    site: measurement_options.Site = None,
    calibration: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Read force and position again by this calibration, not by the recorded one.",
        ),
    ] = None,
) -> None:
    """Write the samples to CSV or Parquet, every digit kept.

    Columns: time [s] since the first sample (of a table since its own zero), position [m], force
    [N], command [V], sequence, site and its place. Every command reads the written file.
    """
    from tissue_probe.recording.clocks.stretches import dwell_blocks
    from tissue_probe.recording.writing.tables import write_samples

    if output.exists() and output.samefile(samples):
        raise ValueError(f"{output} holds the samples and would be replaced: give another --output")
    layout = signals.layout()
    (part,) = measurement_options.read([samples], layout).parts
    measurement_options.tell(part.notes)
    recording = part.recording
    if site is not None:
        recording = replace(recording, blocks=dwell_blocks(recording, site))
    if calibration is not None:
        from tissue_probe.analysis.raw import recalibrate
        from tissue_probe.devices.calibration import Calibration

        recording = recalibrate(recording, Calibration.load(calibration))
    write_samples(output, recording, recording.blocks[0].stamp if part.origin else 0)
    print(f"{len(recording)} samples written to {output}")
