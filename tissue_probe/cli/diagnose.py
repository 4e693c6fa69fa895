"""``tissue_probe diagnose``: which physical effect a model misses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tissue_probe.cli import measurement_options
from tissue_probe.cli.groups import add_groups
from tissue_probe.cli.options_named import with_options
from tissue_probe.cli.question_options import Asked, Json, Validate, write_json

if TYPE_CHECKING:
    from rich.table import Table

    from tissue_probe.analysis.diagnosing import DiagnosisResult

Quick = Annotated[
    bool,
    typer.Option(
        "--quick", help="Rank the effects by what they promise, to first order, and fit none."
    ),
]
RANKS_SHOWN = 8
NAME_LENGTH = 30  # characters of an effect with its mark up to which it stays on one line
#: Meaning of the mark before a name.
SEARCH_GAVE_UP = (
    "The search gave up for {} effects: it would not come near the best, or ran out of steps. Of "
    "a model named above, * says so: its numbers are a guess, no result."
)


@add_groups
def diagnose(
    files: measurement_options.Measurements,
    signals: measurement_options.Signals,
    asked: Asked,
    validate: Validate = None,
    json: Json = None,
    quick: Quick = False,
) -> None:
    """Say which physical effect a model misses, if any can be told.

    Every effect of the library is added to the model and fitted, and further ones while the error
    falls. They are ranked by the probability that they are missing, over all models that were
    tried; beside it stands the error on data they were not fitted to.
    """
    if quick and (validate or json):
        raise ValueError(
            "--quick fits no effect, so that nothing can be tried on a second recording or written "
            "to a file: leave out --validate and --json, or --quick"
        )
    measurement_options.check_there([*files, *(validate or [])])
    layout, keywords = signals.layout(), asked.keywords()
    fitted = measurement_options.read(files, layout)
    tried = measurement_options.read(validate, layout) if validate else None
    # Only now: fits take longer to import than a file takes to be refused.
    from rich.console import Console

    from tissue_probe.analysis import diagnosing, promising

    if quick:
        promised = promising.promises(fitted, **keywords)
        measurement_options.tell(promised.notes)
        print(promised)
        return
    with measurement_options.under_way() as progress:
        result = diagnosing.diagnose(
            fitted,
            validate=tried,
            **keywords,
            progress=progress,
        )
    measurement_options.tell(result.notes)
    print(with_options(result.asked.head))
    # Units stand in square brackets.
    Console(markup=False, highlight=False).print(tabulate_ranking(result))
    gave_up = [row[0] for row in result.ranking.rows if not row[-1]]
    if gave_up or not result.converged:
        print(SEARCH_GAVE_UP.format(len(gave_up)))
    if result.shape is not None:
        print(result.shape)
    print(with_options(result.text))
    if json:
        write_json(json, result.to_dict())


def tabulate_ranking(result: DiagnosisResult) -> Table:
    """Return the base model's errors, and those with each of the best effects."""
    from rich.table import Table

    shown = [row for row in result.ranking.rows if row[-1] or row[0] in result.effects][
        :RANKS_SHOWN
    ]
    heads, write = result.ranking.heads[:-1], [column.write for column in result.ranking.columns]
    base = result.ladder.rows[0]
    rows = [_row(("none", "", None, base[2], base[3], result.converged), write)]
    rows += [_row(row, write) for row in shown]
    table = Table(title=result.ranking.title, title_justify="left")
    for head, column in zip(heads, result.ranking.columns, strict=False):
        # A name that breaks behind its mark looks like two.
        whole = column.name == "effect" and max(len(row[0]) for row in rows) <= NAME_LENGTH
        table.add_column(head, no_wrap=whole, justify="right" if column.right else "left")
    for row in rows:
        table.add_row(*row)
    return table


def _row(values: Sequence[Any], write: Sequence[Callable[[Any], str]]) -> list[str]:
    """Write a row of the ranking, with a mark before a name that did not settle.

    No narrow window cuts a mark off that stands before a name.
    """
    *cells, settled = values
    told = ["" if each is None else text(each) for each, text in zip(cells, write, strict=False)]
    return told if settled else [f"* {told[0]}", *told[1:]]
