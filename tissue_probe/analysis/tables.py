"""The tables of a diagnosis: ranking, ladder, values.

Contents: which values stand in which column.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from tissue_probe.analysis import fit_shown
from tissue_probe.analysis.result_table import (
    Column,
    ResultTable,
    number,
    probability,
    write_settled,
)
from tissue_probe.diagnosis.answer import Answer
from tissue_probe.diagnosis.diagnosis import Diagnosis
from tissue_probe.quantities import Quantity


def rank_effects(told: Answer, output: Quantity) -> ResultTable:
    """Return the effects of an answer, the best first."""
    small = number(4, output.per_small)
    columns = (
        Column("effect", "effect"),
        Column("family", "family"),
        Column("probability", "P", probability, right=True),
        Column("rmse", f"error [{output.small}]", small, right=True),
        Column("heldout_rmse", f"held out [{output.small}]", small, right=True),
        Column("settled", "settled", write_settled),
    )
    rows = tuple(
        (
            each.effect,
            each.family,
            each.probability,
            each.rmse,
            each.heldout_rmse,
            each.converged,
        )
        for each in told.ranking
    )
    held_out = "parts of this recording" if told.carries_over is None else "the second recording"
    title = "With one effect more, the most probable first; P: that it is missing, "
    title += f"alone or beside others. Held out: {held_out}"
    return ResultTable(title, columns, rows)


def shorten_table(table: ResultTable, rows: int) -> ResultTable:
    """Return the first rows of a table, under the same title."""
    return replace(table, rows=table.rows[:rows])


def ladder(diagnosis: Diagnosis) -> ResultTable:
    """Return the error of each model of the ladder beside the noise."""
    output, noise = diagnosis.ladder.base.output, diagnosis.ladder.final.noise
    small = number(4, output.per_small)
    columns = (
        Column("step", " ", right=True),
        Column("model", "model"),
        Column("rmse", f"error [{output.small}]", small, right=True),
        Column("heldout_rmse", f"held out [{output.small}]", small, right=True),
        Column("heldout_over_noise", "held out / noise", number(3), right=True),
    )
    rows = []
    for step, fit in enumerate((diagnosis.ladder.base, *diagnosis.ladder.steps)):
        heldout = diagnosis.heldout(fit)
        unsettled = "" if fit.converged else " (did not settle)"
        rows.append((step, fit_shown.title(fit) + unsettled, fit.rmse, heldout, heldout / noise))
    return ResultTable(f"The ladder; the noise is {output.tell(noise)}", columns, tuple(rows))


def shape(diagnosis: Diagnosis) -> ResultTable | None:
    """Return each variable's share of the missing force; None where that was not learnt."""
    if diagnosis.shape is None:
        return None
    columns = (
        Column("variable", "a function of"),
        Column("alone", "alone [%]", _percent, right=True),
        Column("beyond", "beyond the others [%]", _percent, right=True),
    )
    rows = tuple((name, each.alone, each.beyond) for name, each in diagnosis.shape.shares.items())
    beside = fit_shown.title(diagnosis.shape.fit)
    title = f"Shares of the force that {beside} misses, on held-out parts"
    return ResultTable(title, columns, rows)


def values(diagnosis: Diagnosis) -> ResultTable:
    """Return the values that each model of the ladder was fitted with, a column a model."""
    steps = (diagnosis.ladder.base, *diagnosis.ladder.steps)
    found: dict[tuple[str, str], list[str | None]] = {}
    for step, fit in enumerate(steps):
        for name, value, unit in fit_shown.table(fit):
            row = found.setdefault((name, unit), [None] * len(steps))
            row[step] = value + (fit_shown.AT_LIMIT if name in fit.exhausted else "")
    rows: list[tuple[Any, ...]] = [(name, *row, unit) for (name, unit), row in found.items()]
    rows.append(("whitened / noise", *(f"{fit.ratio:.3g}" for fit in steps), "1"))
    columns = (
        Column("name", " "),
        *(Column(f"step_{step}", str(step), right=True) for step in range(len(steps))),
        Column("unit", "unit"),
    )
    return ResultTable("Values at each step, +- 95 % intervals", columns, tuple(rows))


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f}"
