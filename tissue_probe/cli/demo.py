"""``tissue_probe demo``: the whole suite on a simulated phantom, from probe to map."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from tissue_probe.signals import Recording, TissueEstimates
    from tissue_probe_msgs.action import Palpate

DEMO_ESTIMATORS = ("robust_ekf", "ekf", "ukf", "afekf")
#: The paper's grid over the stock phantom: first site and spacing [m], rows, columns.
DEMO_SITES = ((0.0, 0.0, 0.0), 0.01, 5, 5)


def demo(
    folder: Annotated[
        Path,
        typer.Option(
            "--folder",
            metavar="FOLDER",
            help="Where to leave run.mcap, map.png, estimates.png; an earlier demo's are replaced.",
            file_okay=False,
        ),
    ] = Path(),
    dwell_time: Annotated[
        float,
        typer.Option(
            metavar="SECONDS", min=0.05, max=60.0, help="Longest time in contact at each site [s]."
        ),
    ] = 1.0,
    explore: Annotated[
        bool,
        typer.Option(
            "--explore", help="Choose each site from those before, 25 at most, instead of a grid."
        ),
    ] = False,
    phantom: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="YAML file of the phantom, or table (.csv) of stiffness felt: x, y [m], k [N/m].  "
            "[default: three nodules in soft tissue]",
        ),
    ] = None,
) -> None:
    """Palpate a simulated phantom, from probe to map.

    Scans a 5 x 5 grid at real time, in the processes of a real probe; or explores its area.

    Records run.mcap, draws map.png and estimates.png, and prints the true and the found nodules.
    """
    then = "its area is explored" if explore else "25 sites are palpated"
    _say(f"step 1 of 3: the nodes are loaded and started, then {then}")
    try:
        from tissue_probe.nodes.session import SessionError
    except ModuleNotFoundError as error:
        raise SystemExit(
            f"tissue_probe: the demo runs ROS 2 nodes, and there is no {error.name}; run it by "
            "`make demo`, or where ROS 2 is sourced and the packages are built by colcon"
        ) from None

    folder.mkdir(parents=True, exist_ok=True)
    bag = folder / "run.mcap"
    try:
        print(palpate(bag, dwell_time, phantom, explore))
    except SessionError as error:
        raise SystemExit(f"tissue_probe: {error}") from None
    _say("step 2 of 3: the recording is read")
    evaluate(bag, folder, explore)


def _say(step: str) -> None:
    """Say at once how far the demo is, apart from its printed results."""
    print(step, file=sys.stderr, flush=True)


def palpate(bag: Path, dwell_time: float, phantom: Path | None, explore: bool) -> str:
    """Run the scan into a recording; return how it ended, and how long it took.

    Raises
    ------
    SessionError
        If the suite cannot be started or breaks down.
    """
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    from tissue_probe.mapping.grid import Grid
    from tissue_probe.nodes.conversions import from_time
    from tissue_probe.nodes.session import Session, simulation

    bag.unlink(missing_ok=True)
    grid = Grid(*DEMO_SITES)
    subscribers = {
        "/probe/driver": 3,  # the estimators, which share a process, the scan and the recorder
        "/probe/scan": 5,  # the driver, the estimators, the mapper twice and the recorder
        **{
            f"/probe/{name}": 3 for name in DEMO_ESTIMATORS
        },  # the mapper, the recorder and the scan
    }
    publishers = {
        "/probe/mapper": len(DEMO_ESTIMATORS) + 1,  # and the scan
        **{f"/probe/{name}": 2 for name in DEMO_ESTIMATORS},  # the driver and the scan
    }
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed} of {task.total} sites"),
        TimeRemainingColumn(),
    )
    with (
        Progress(*columns) as progress,
        Session(simulation(DEMO_ESTIMATORS, bag.absolute(), phantom)) as session,
    ):
        task = progress.add_task("starting the nodes", total=len(grid))
        session.activate(subscribers, publishers)

        stamps = []

        def show(feedback: Palpate.Feedback) -> None:
            doing = {0: "approaching", 1: "palpating", 2: "lifting"}[feedback.site.phase]
            progress.update(task, completed=feedback.sites_visited, description=doing)
            stamps.append(from_time(feedback.site.header.stamp))

        if explore:
            corners = list(zip(*_corners().values(), strict=True))
            message = session.explore(corners, len(grid), dwell_time, show).message
        else:
            message = session.scan(grid, dwell_time, show).message
        if stamps:
            message += f"; {1e-9 * (stamps[-1] - stamps[0]):.1f} s of scan"
        progress.update(task, description="done")
        session.deactivate()
    return str(message)


def _corners() -> dict[str, list[float]]:
    """Return the corners of the area that the grid covers [m]."""
    (x, y, _), spacing, rows, columns = DEMO_SITES
    right, top = x + spacing * (columns - 1), y + spacing * (rows - 1)
    return {"x": [x, right, right, x], "y": [y, y, top, top]}


def evaluate(bag: Path, folder: Path, explored: bool) -> None:
    """Draw and print the results of a recorded scan."""
    from tissue_probe.analysis.mapping import map_sites
    from tissue_probe.analysis.recorded_facts import estimate_again
    from tissue_probe.cli.map import summarize
    from tissue_probe.recording.bags.reader import read_recording

    recording = read_recording(bag)
    result = map_sites(bag, within=_corners() if explored else None)
    _say("step 3 of 3: pictures are drawn, the filters run again")
    result.plot().savefig(folder / "map.png", dpi=100)
    draw_course(recording, [estimate_again(recording, name) for name in DEMO_ESTIMATORS], folder)
    summarize(result)
    print(f"Look at {folder / 'map.png'} and {folder / 'estimates.png'}; the run is in {bag}.")


def draw_course(recording: Recording, estimates: list[TissueEstimates], folder: Path) -> None:
    """Draw the estimates over time, beside the truth."""
    import numpy as np

    from tissue_probe.analysis.recorded_facts import find_phantom
    from tissue_probe.figures.estimates import draw_estimates

    phantom = find_phantom(recording)
    places = [site.position for site, _ in recording.dwells()]
    truth = (
        np.array([(phantom.stiffness(x, y), phantom.damping(x, y)) for x, y, _ in places])
        if phantom
        else None
    )
    draw_estimates(recording, estimates, truth).savefig(folder / "estimates.png", dpi=100)
