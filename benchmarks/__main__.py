"""``python -m benchmarks``: measure, print, and keep as JSON."""

from __future__ import annotations

import os
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from benchmarks import live, machine, offline, report
from tissue_probe.nodes.session import SessionError

RESULTS = Path(__file__).parent / "results"
#: Where nobody else's nodes are heard, nor hear these.
DOMAIN = "87"


class Part(str, Enum):
    """What to measure."""

    live = "live"
    offline = "offline"
    all = "all"


def main(
    part: Annotated[Part, typer.Argument(help="What to measure.")] = Part.all,
    seconds: Annotated[
        float, typer.Option(min=1.0, help="Time of each live measurement [s].")
    ] = 60.0,
) -> None:
    """Measure losses, latency and processor time of the live suite, and the filters off line."""
    os.environ.setdefault("ROS_DOMAIN_ID", DOMAIN)
    RESULTS.mkdir(exist_ok=True)
    bag = RESULTS / "run.mcap"
    results: dict[str, object] = {"machine": machine.describe()}
    try:
        if part != Part.offline:
            results["live"] = live.measure(RESULTS, seconds)
        if part != Part.live:
            results["offline"] = offline.measure(bag)
    except SessionError as error:
        raise SystemExit(f"benchmarks: {error}") from None
    except FileNotFoundError:
        raise SystemExit("benchmarks: nothing is recorded yet; measure `live` first") from None
    report.show(results, Console())
    print(f"kept in {report.keep(results, RESULTS)}; the recording is {bag}")


if __name__ == "__main__":
    typer.run(main)
