"""``python -m benchmarks``: measure, print, and keep as JSON."""

from __future__ import annotations

import os
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from benchmarks import daq, estimators, estimators_speed, live, machine, offline, report
from tissue_probe.nodes.session import SessionError

RESULTS = Path(__file__).parent / "results"
#: Where nobody else's nodes are heard, nor hear these.
DOMAIN = "87"
#: Of the noise; no test uses seeds from here on.
FIRST_SEED = 1000


class Part(str, Enum):
    """What to measure."""

    live = "live"
    offline = "offline"
    estimators = "estimators"
    speed = "speed"
    daq = "daq"
    all = "all"


def main(
    part: Annotated[Part, typer.Argument(help="What to measure.")] = Part.all,
    seconds: Annotated[
        float, typer.Option(min=1.0, help="Time of each live measurement, and of `daq` [s].")
    ] = 60.0,
    seeds: Annotated[int, typer.Option(min=1, help="Seeds of each row of `estimators`.")] = 20,
) -> None:
    """Measure the live suite, the filters off line, how exact they are, and what a sample costs.

    `daq` counts the samples of the driver on a DAQ, which `all` leaves out.
    """
    os.environ.setdefault("ROS_DOMAIN_ID", DOMAIN)
    RESULTS.mkdir(exist_ok=True)
    bag = RESULTS / "run.mcap"
    results: dict[str, object] = {"machine": machine.describe()}
    try:
        if part == Part.daq:
            bag = RESULTS / "daq.mcap"
            results["daq"] = daq.measure(RESULTS, seconds)
            print(daq.sentence(results["daq"]))
        if part in (Part.live, Part.all):
            results["live"] = live.measure(RESULTS, seconds)
        if part in (Part.offline, Part.all):
            results["offline"] = offline.measure(bag)
        if part in (Part.estimators, Part.all):
            results["estimators"] = estimators.measure(range(FIRST_SEED, FIRST_SEED + seeds))
        if part in (Part.speed, Part.all):
            results["speed"] = estimators_speed.measure()
    except SessionError as error:
        raise SystemExit(f"benchmarks: {error}") from None
    except FileNotFoundError:
        raise SystemExit("benchmarks: nothing is recorded yet; measure `live` first") from None
    if part != Part.daq:
        report.show(results, Console())
    print(f"kept in {report.keep(results, RESULTS)}; the recording is {bag}")


if __name__ == "__main__":
    typer.run(main)
