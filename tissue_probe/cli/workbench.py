"""``tissue_probe workbench``: a page in the browser on which models are compared and mended."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli import measurement_options
from tissue_probe.cli.groups import add_groups
from tissue_probe.cli.question_options import OfSamples


@add_groups
def workbench(
    signals: measurement_options.Signals,
    asked: OfSamples,
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[FILES]...",
            help="Recordings of one specimen: the first is fitted, the second is held against it.",
        ),
    ] = None,
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
    study: Annotated[
        Path | None,
        typer.Option(
            metavar="STUDY.yaml",
            help="Show the table of a study that was run; a click opens a recording of it.",
        ),
    ] = None,
    browser: Annotated[
        bool, typer.Option(help="Open the page in the browser; its address is printed in any case.")
    ] = True,
) -> None:
    """Open a page on which models are compared and mended.

    A page on this machine, for this machine only; it needs no network. Files that need more to be
    read (columns, units, polarity), and the rig where nobody gives it, are asked for on the page.
    """
    measurement_options.check_there(files or [])
    if allow_commands and not live:
        raise ValueError("--allow-commands is of the nodes that --live listens to: give both")
    if live and find_spec("rclpy") is None:
        raise SystemExit(
            "tissue_probe: --live listens to ROS 2 nodes, and there is no rclpy; run it where "
            "`make setup` was run, or where ROS 2 is sourced and the packages are built by colcon"
        )
    try:
        from tissue_probe.workbench.serve import serve
    except ModuleNotFoundError as error:
        if error.name not in ("starlette", "uvicorn", "websockets"):
            raise
        raise SystemExit(
            f"tissue_probe: the workbench needs {error.name}: pip install 'tissue_probe[workbench]'"
        ) from None
    paths = [path.resolve() for path in files or []]
    serve(
        paths,
        dict(signals.layout().stated),
        asked.keywords(),
        port,
        browser,
        live,
        allow_commands,
        study,
    )
