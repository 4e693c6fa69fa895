"""``tissue_probe workbench``: a page in the browser on which models are compared and mended."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli import measured


def workbench(
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[FILES]...",
            help="Recordings of one specimen: the first is fitted, the second is held against it.",
        ),
    ] = None,
    position: measured.Position = None,
    force: measured.Force = None,
    time: measured.Time = None,
    sample_rate: measured.SampleRate = None,
    position_unit: measured.PositionUnit = None,
    force_unit: measured.ForceUnit = None,
    time_unit: measured.TimeUnit = None,
    force_polarity: measured.ForcePolarity = None,
    position_polarity: measured.PositionPolarity = measured.Direction.into,
    port: Annotated[
        int | None,
        typer.Option(min=1, max=65535, help="Where to listen.", show_default="one that is free"),
    ] = None,
    live: Annotated[
        bool, typer.Option("--live", help="Listen to the nodes of a running suite, too (ROS).")
    ] = False,
    allow_commands: Annotated[
        bool,
        typer.Option(
            "--allow-commands", help="Let the page start and stop the driver, excite and scan."
        ),
    ] = False,
    browser: Annotated[
        bool, typer.Option(help="Open the page in the browser; its address is printed in any case.")
    ] = True,
) -> None:
    """Open a page on which models are compared and mended.

    A page on this machine, for this machine only; it needs no network. Files that need more to be
    read (columns, units, polarity) ask for it on the page.
    """
    measured.check_there(files or [])
    if allow_commands and not live:
        raise ValueError("--allow-commands is of the nodes that --live listens to: give both")
    if live and find_spec("rclpy") is None:
        raise SystemExit(
            "tissue_probe: --live listens to ROS 2 nodes, and there is no rclpy; run it where "
            "`make setup` was run, or where ROS 2 is sourced and the packages are built by colcon"
        )
    layout = {
        "position": position, "force": force, "time": time, "sample_rate": sample_rate,
        "position_unit": position_unit, "force_unit": force_unit, "time_unit": time_unit,
        "force_polarity": force_polarity and force_polarity.value,
        "position_polarity": None if position_polarity.value == "into" else position_polarity.value,
    }  # fmt: skip
    try:
        from tissue_probe.workbench.serve import serve
    except ModuleNotFoundError as error:
        if error.name not in ("starlette", "uvicorn", "websockets"):
            raise
        raise SystemExit(
            f"tissue_probe: the workbench needs {error.name}: pip install 'tissue_probe[workbench]'"
        ) from None
    stated = {name: value for name, value in layout.items() if value is not None}
    serve([path.resolve() for path in files or []], stated, port, browser, live, allow_commands)
