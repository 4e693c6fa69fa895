"""``tissue_probe export``: the samples of a recording as a table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli.arguments import Bag, Table, Topic


def export(
    bag: Bag,
    output: Table = Path("samples.csv"),
    topic: Topic = None,
    calibration: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Read force and position again by this calibration, not by the recorded one.",
        ),
    ] = None,
) -> None:
    """Write the samples to CSV or Parquet, every digit kept.

    Columns: time [s] since the first sample, position [m], force [N], command [V], sequence, site.
    """
    from tissue_probe.recording.reader import read_recording
    from tissue_probe.recording.tables import write_samples

    recording = read_recording(bag, topic)
    if calibration is not None:
        from tissue_probe.cli.raw import recalibrated
        from tissue_probe.devices.calibration import Calibration

        recording = recalibrated(recording, Calibration.load(calibration))
    write_samples(output, recording, recording.blocks[0].stamp)
    print(f"{len(recording)} samples written to {output}")
