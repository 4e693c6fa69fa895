"""The marks of the instrument's measure as tables.

Contents: shares with their 95 % intervals, medians, and what was wrong, by seed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from rich.markup import escape
from rich.table import Table

from benchmarks.instrument.groups import GROUPS
from benchmarks.instrument.outcome import Outcome
from benchmarks.ruler.tables import IN_ALL, share


def tables(outcomes: Sequence[Outcome]) -> Iterator[Table]:
    """Yield a table for each group, and what was wrong."""
    for group in dict.fromkeys(outcome.group for outcome in outcomes):
        yield _table(group, [each for each in outcomes if each.group == group])
    wrong = Table("record", "told", "wrong", title="What was wrong", title_justify="left")
    for outcome in outcomes:
        if outcome.wrong:
            record = f"{outcome.group} {outcome.seed}\n{outcome.kind}"
            wrong.add_row(record, escape(outcome.told), escape("\n".join(outcome.wrong)))
    if wrong.row_count:
        yield wrong


def _table(group: str, outcomes: Sequence[Outcome]) -> Table:
    columns = GROUPS[group].columns
    numbers = list(dict.fromkeys(name for each in outcomes for name in each.numbers))
    intervals = any(each.intervals for each in outcomes)
    table = Table(title=group, title_justify="left", caption_justify="left")
    table.add_column("")
    for column in (*columns, *(["intervals that hold"] if intervals else []), *numbers, "refused"):
        table.add_column(column, justify="right", overflow="fold")
    kinds = sorted({each.kind for each in outcomes})
    for kind in (*kinds, IN_ALL) if len(kinds) > 1 else kinds:
        chosen = [each for each in outcomes if kind in (each.kind, IN_ALL)]
        if kind == IN_ALL:
            table.add_section()
        table.add_row(kind, *_cells(chosen, columns, intervals, numbers))
    table.caption = "in brackets: 95 % interval of the share (Clopper and Pearson), in %"
    if numbers:
        table.caption += f"\nmedians of: {', '.join(numbers)}"
    return table


def _cells(
    outcomes: Sequence[Outcome], columns: Sequence[str], intervals: bool, numbers: Sequence[str]
) -> Iterator[str]:
    for column in columns:
        yield share(each.marks[column] for each in outcomes)
    if intervals:
        held, asked = (
            sum(getattr(each, of) for each in outcomes) for of in ("inside", "intervals")
        )
        yield f"{held} of {asked}"
    for name in numbers:
        told = [each.numbers[name] for each in outcomes if name in each.numbers]
        yield f"{np.median(told):.3g}" if told else "-"
    yield str(sum(each.refused for each in outcomes))
