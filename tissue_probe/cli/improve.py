"""``tissue_probe improve``: add the missing effects, and watch the error fall."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tissue_probe.cli import measurement_options
from tissue_probe.cli.groups import add_groups
from tissue_probe.cli.options_named import with_options
from tissue_probe.cli.question_options import Asked, Json, Validate, write_json

if TYPE_CHECKING:
    from rich.table import Table

    from tissue_probe.analysis.result_table import ResultTable


@add_groups
def improve(
    files: measurement_options.Measurements,
    signals: measurement_options.Signals,
    asked: Asked,
    add: Annotated[
        list[str] | None,
        typer.Option(metavar="EFFECT", help="Add this effect, instead of the missing ones."),
    ] = None,
    validate: Validate = None,
    json: Json = None,
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="FOLDER",
            file_okay=False,
            help="Where model.yaml, pictures and report go.",
        ),
    ] = Path("improved"),
    free_form: Annotated[
        bool,
        typer.Option(
            "--free-form",
            help="Where no law explains the record, write my_effect.py, an effect of the shape "
            "that was learnt, and add that.",
        ),
    ] = False,
) -> None:
    """Add the missing effects, one by one, while the error falls.

    The ladder's errors are root mean squares; the whitened one counts 1/f noise and an encoder's
    rounding as noise, where they are known, and is 1 where nothing is left to explain.

    Writes model.yaml, which estimators and the simulated probe take, story.png with all on one
    page, ladder.png, compare.png of the base model and report.html, which works off line.
    """
    measurement_options.check_there([*files, *(validate or [])])
    layout, keywords = signals.layout(), asked.keywords()
    fitted = measurement_options.read(files, layout)
    tried = measurement_options.read(validate, layout) if validate else None
    # Only now: fits take longer to import than a file takes to be refused.
    from rich.console import Console

    from tissue_probe.analysis.diagnosing import diagnose, with_free_form

    diagnosed = partial(with_free_form, folder=output) if free_form else diagnose
    with measurement_options.under_way() as progress:
        result = diagnosed(fitted, validate=tried, add=add or [], **keywords, progress=progress)
    measurement_options.tell(result.notes)
    print(with_options(result.asked.head))
    console = Console(markup=False, highlight=False)  # units stand in square brackets
    console.print(_table(result.ladder))
    console.print(_table(result.values))
    if result.exhaustion:
        print(with_options(result.exhaustion))
    print(with_options(result.text))
    replace(result, wording=with_options).save(output)
    print(f"{', '.join(_files(output, free_form))} and report.html are in {output}.")
    if json:
        write_json(json, result.to_dict())


def _files(output: Path, free_form: bool) -> list[str]:
    shape = ["shape.png"] if (output / "shape.png").exists() else []
    effect = ["my_effect.py"] if free_form else []
    return ["model.yaml", *effect, "story.png", "ladder.png", "compare.png", *shape]


def _table(shown: ResultTable) -> Table:
    """Lay a table out for the terminal: the first column and units stay on one line."""
    from rich.table import Table

    table = Table(title=shown.title, title_justify="left")
    for column in shown.shown:
        whole = column.name in ("step", "name", "unit")
        table.add_column(
            column.head.strip(), no_wrap=whole, justify="right" if column.right else "left"
        )
    for row in shown.texts():
        table.add_row(*(cell.replace(" + ", "\n+ ").replace(" (did", "\n(did") for cell in row))
    return table
