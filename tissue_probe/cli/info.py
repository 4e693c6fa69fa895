"""``tissue_probe info``: the contents of a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tissue_probe.cli import measurement_options
from tissue_probe.cli.groups import add_groups

if TYPE_CHECKING:
    from tissue_probe.recording.layout import Layout


@add_groups
def info(
    samples: measurement_options.Samples,
    signals: measurement_options.Signals,
    parameters: Annotated[
        bool, typer.Option("--parameters", help="Show every recorded parameter too.")
    ] = False,
) -> None:
    """Show the contents of a recording.

    Its topics, begin and length [s], samples and how many were lost, sites palpated, and the run's
    parameters; of any ROS 2 recording, by any program. Of a table: its columns, their
    units, how many values they have, and how it is read. Where options say which signals are meant,
    also how these are read, or why not.
    """
    from tissue_probe.recording.bags.open_bag import is_bag
    from tissue_probe.recording.layout import Layout

    layout = signals.layout()
    if is_bag(samples):
        _tell_bag(samples, parameters)
    else:
        _tell_table(samples)
    if layout != Layout():
        _tell_signals(samples, layout)


def _tell_signals(path: Path, layout: Layout) -> None:
    """Print how position and force are read by the options."""
    (part,) = measurement_options.read([path], layout).parts
    measurement_options.tell(part.notes)
    recording = part.recording
    rate = 1.0 / recording.blocks[0].sample_period
    parts = "" if len(recording.blocks) == 1 else f", in {len(recording.blocks)} parts"
    print(f"Position and force: {len(recording)} samples at {rate:.6g} Hz{parts}")


def _tell_bag(samples: Path, parameters: bool) -> None:
    """Print the contents of a bag."""
    from datetime import datetime

    from rich.console import Console
    from rich.table import Column, Table

    from tissue_probe.recording.bags.summary import summarize
    from tissue_probe.signals import NANOSECONDS

    summary = summarize(samples)
    if summary.truncated and not summary.topics and not summary.metadata:
        raise ValueError(
            f"{samples}: nothing in it can be read: it was cut off before its first message; give "
            "another recording"
        )
    begin = (
        datetime.fromtimestamp(summary.start / NANOSECONDS).isoformat(" ", "seconds")
        if summary.start is not None
        else "never"
    )
    print(f"{samples}: begins {begin}, lasts {summary.duration:.3f} s")
    if summary.truncated:
        print("The recording was cut off; everything up to the cut is read.")
    for each in summary.samples:
        late = f", recorded from sample {each.first} on" if each.first else ""
        print(f"{each.topic}: {each.recorded} samples, {each.lost} lost{late}")
    if summary.sites:
        print(f"{len(summary.sites)} sites palpated")
    # Names are to be copied: they are folded, never cut.
    names = (Column(title, overflow="fold") for title in ("topic", "type"))
    table = Table(*names, "messages")
    for topic in summary.topics:
        table.add_row(topic.name, topic.typename, str(topic.messages))
    Console(markup=False).print(table)
    for node, values in summary.metadata.items():
        if parameters:
            print(f"\n{node}")
            for name, value in sorted(values.items()):
                print(f"  {name}: {value}")
    if summary.metadata and not parameters:
        print(f"Parameters of {', '.join(summary.metadata)}; --parameters shows them.")


def _tell_table(path: Path) -> None:
    """Print a table's columns, their units and first values, and how it is read."""
    from rich.console import Console
    from rich.table import Column, Table

    from tissue_probe.recording.columns.open_columns import open_columns
    from tissue_probe.recording.errors import RecordingError
    from tissue_probe.recording.units import bare_unit_in

    source = open_columns(path)
    table = Table(
        *(Column(title, overflow="fold") for title in ("column", "unit", "values", "first"))
    )
    told = list(source.told)
    for name in source.names:
        try:
            (column,), said, *_ = source.read([name])
        except RecordingError:
            table.add_row(name, "", "", "no numbers")
            continue
        told += [each for each in said if each not in told]
        unit = source.units.get(name) or bare_unit_in(name) or ""
        table.add_row(name, unit, str(column.size), str(column[0]))
    print(f"{path}: {'; '.join(told) or 'a table'}")
    Console(markup=False).print(table)
