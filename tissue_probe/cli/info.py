"""``tissue_probe info``: what is in a recording."""

from __future__ import annotations

from typing import Annotated

import typer

from tissue_probe.cli.arguments import Bag


def info(
    bag: Bag,
    parameters: Annotated[
        bool, typer.Option("--parameters", help="Also show every recorded parameter.")
    ] = False,
) -> None:
    """Show topics, counts, lost samples, sites and run parameters of any ROS 2 recording."""
    from datetime import datetime

    from rich.console import Console
    from rich.table import Table

    from tissue_probe.recording.summary import summarize
    from tissue_probe.signals import NANOSECONDS

    summary = summarize(bag)
    console = Console(highlight=False)
    begin = (
        datetime.fromtimestamp(summary.start / NANOSECONDS).isoformat(" ", "seconds")
        if summary.start is not None
        else "never"
    )
    console.print(f"{bag}: begins {begin}, lasts {summary.duration:.3f} s")
    if summary.truncated:
        console.print("The recording was cut off; everything up to the cut is read.")
    for samples in summary.samples:
        console.print(f"{samples.topic}: {samples.recorded} samples, {samples.lost} lost")
    if summary.sites:
        console.print(f"{len(summary.sites)} sites palpated")
    table = Table("topic", "type", "messages")
    for topic in summary.topics:
        table.add_row(topic.name, topic.typename, str(topic.messages))
    console.print(table)
    for node, values in summary.metadata.items():
        if parameters:
            console.print(f"\n{node}", markup=False)
            for name, value in sorted(values.items()):
                console.print(f"  {name}: {value}", markup=False)
    if summary.metadata and not parameters:
        console.print(f"Parameters of {', '.join(summary.metadata)}; --parameters shows them.")
