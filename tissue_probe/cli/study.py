"""``tissue_probe study``: many recordings, one row each."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from tissue_probe.studies.result import StudyResult

study = typer.Typer(
    help="Answer about many recordings, a row each, in one table.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


Plan = Annotated[
    Path,
    typer.Argument(
        metavar="STUDY.yaml",
        help="recordings (data/*.csv, or a table with a column path and one a factor), pattern "
        "({specimen}_{day}.csv), task (estimate, compare, diagnose), question (rig: "
        "NAME, ...), output (a folder).",
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(
        metavar="COUNT",
        min=1,
        help="Processes that share the recordings.",
        show_default="as many as there are cores",
    ),
]
Value = Annotated[str, typer.Option(metavar="COLUMN", help="Of the table, such as damping.")]
Specimen = Annotated[str, typer.Option(metavar="FACTOR", help="Which specimen a recording is of.")]
By = Annotated[str | None, typer.Option(metavar="FACTOR", help="Compare its groups.")]


@study.command()
def run(plan: Plan, workers: Workers = None) -> None:
    """Compute the row of each recording, and keep all in the study's folder.

    The folder has table.csv and table.parquet. A recording that cannot be answered is a row with
    the reason. A second run computes only the recordings that changed; Ctrl-C ends a run, and the
    rows that are done are kept.
    """
    _computed(plan, workers)


@study.command()
def summary(
    plan: Plan,
    value: Value = "stiffness",
    specimen: Specimen = "specimen",
    by: By = None,
    agree: Annotated[
        str | None,
        typer.Option(metavar="FACTOR", help="Say how its two values (instruments, ...) agree."),
    ] = None,
    workers: Workers = None,
) -> None:
    """Say how a value spreads over specimens and repeats, and which effects are missing how often.

    Recordings that are not done yet are computed first.
    """
    found, _ = _computed(plan, workers)
    print(f"\n{value} [SI]: {found.spread(value, specimen=specimen, by=by)}")
    if agree is not None:
        print(f"\n{agree}: {found.agreement(value, of=agree, specimen=specimen)}")
    if any("verdict" in each for each in found.rows):
        print("\nmissing in a share of the recordings:")
        for name, share in found.missing().items():
            print(f"{name}: {share}")


@study.command()
def report(
    plan: Plan,
    value: Value = "stiffness",
    specimen: Specimen = "specimen",
    by: By = None,
    workers: Workers = None,
) -> None:
    """Write the study as one HTML page, report.html in its folder, which works off line.

    It tells the work done, the recordings left out and why, values with their intervals, factors,
    and effects that are missing; it links to table.csv, table.parquet and the recordings' own
    reports. Recordings that are not done yet are computed first.
    """
    found, folder = _computed(plan, workers)
    path = folder / "report.html"
    found.report(path, value=value, specimen=specimen, by=by)
    print(f"The report is {path}.")


def _computed(plan: Path, workers: int | None) -> tuple[StudyResult, Path]:
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
    return found, asked.output
