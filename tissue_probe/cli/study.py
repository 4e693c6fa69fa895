"""``tissue_probe study``: many recordings, one row each."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

study = typer.Typer(
    help="Answer about many recordings, a row each, in one table.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@study.callback()
def _studies() -> None:
    """Answer about many recordings, a row each, in one table."""


@study.command()
def run(
    plan: Annotated[
        Path,
        typer.Argument(
            metavar="STUDY.yaml",
            help="recordings (data/*.csv, or a table with a column path and one a factor), pattern "
            "({specimen}_{day}.csv), task (estimate, compare, diagnose), question (rig: "
            "rigid_probe, ...), output (a folder).",
        ),
    ],
    workers: Annotated[
        int | None,
        typer.Option(
            metavar="COUNT",
            min=1,
            help="Processes that share the recordings.",
            show_default="as many as there are cores",
        ),
    ] = None,
) -> None:
    """Compute the row of each recording, and keep all in the study's folder.

    The folder has table.csv and table.parquet. A recording that cannot be answered is a row with
    the reason. A second run computes only the recordings that changed; Ctrl-C ends a run, and the
    rows that are done are kept.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    from tissue_probe.studies.plan import read_plan
    from tissue_probe.studies.running import study as compute

    asked = read_plan(plan)
    columns = BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
        bar = shown.add_task("", total=len(asked.recordings))

        def advance(done: int, of: int) -> None:
            shown.update(bar, completed=done, total=of)

        found = compute(asked, workers=workers, progress=advance)
    print(found.text)
    print(f"The table is in {asked.output / 'table.csv'}.")
