"""``tissue_probe export``: the samples of a recording as a table."""

from __future__ import annotations

from pathlib import Path

from tissue_probe.cli.arguments import Bag, Table, Topic


def export(bag: Bag, output: Table = Path("samples.csv"), topic: Topic = None) -> None:
    """Write the samples to CSV or Parquet, every digit kept.

    Columns: time [s] since the first sample, position [m], force [N], command [V], sequence, site.
    """
    from tissue_probe.recording.reader import read_recording
    from tissue_probe.recording.tables import write_samples

    recording = read_recording(bag, topic)
    write_samples(output, recording, recording.blocks[0].stamp)
    print(f"{len(recording)} samples written to {output}")
