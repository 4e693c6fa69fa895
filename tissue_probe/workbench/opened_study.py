"""A study beside the desk: its table, of which each row opens its recording.

Contents: the part of the rows that a page is told, and how a recording of it is read and asked
about.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tissue_probe.analysis.question_items import ITEMS_BY_NAME
from tissue_probe.studies.dataset import Dataset
from tissue_probe.studies.exclusion import explain_exclusion
from tissue_probe.studies.key import key_of_question
from tissue_probe.studies.plan import StudyPlan, read_plan
from tissue_probe.studies.row import SHOWN, SIGNAL_STATEMENTS
from tissue_probe.studies.running import ROWS_FOLDER
from tissue_probe.workbench.page_messages import StudyMessage
from tissue_probe.workbench.question import PAGE_ITEMS
from tissue_probe.workbench.refusal import RequestRefused


@dataclass(frozen=True)
class Studied:
    """A study whose rows are there.

    Attributes
    ----------
    name : str
        Its file's name.
    plan : Plan
        The recordings and the question.
    rows : sequence of dict
        In the order of the plan's recordings.
    """

    name: str
    plan: StudyPlan
    rows: Sequence[Mapping[str, Any]]

    @property
    def layout(self) -> dict[str, Any]:
        """The study's statements on its recordings' signals."""
        return {
            name: each for name, each in self.plan.question.items() if name in SIGNAL_STATEMENTS
        }

    @property
    def asked(self) -> dict[str, Any]:
        """The study's statements on the model, as a page states them: those that the desk knows."""
        known = {each.name for each in PAGE_ITEMS}
        return {
            name: _as_stated(ITEMS_BY_NAME[name].kind, given)
            for name, given in self.plan.question.items()
            if name in known and given is not None
        }

    def path(self, row: int) -> Path:
        """Return the recording of a row.

        Raises
        ------
        Refused
            If there is no such row.
        """
        if not 0 <= row < len(self.rows):
            raise RequestRefused(f"the study has no row {row}")
        return Path(self.rows[row]["path"])

    def describe_study(self) -> StudyMessage:
        """Return the table; recordings by their names, since no page is to know where they lie."""
        shown = [name for name in SHOWN if any(name in each for each in self.rows)]
        names = [*self.plan.factors, *shown]
        return {
            "name": self.name,
            "columns": ["recording", *names, "reason"],
            "rows": [[Path(each["path"]).name, *_cells(each, names)] for each in self.rows],
        }


def _as_stated(kind: str, given: Any) -> Any:
    """Return a value as a page states it: a file may have a number, or a name, alone."""
    if kind == "constants":
        numbers = given.items()
        return {
            name: (each, 0.0) if isinstance(each, (int, float)) else each for name, each in numbers
        }
    return (given,) if kind == "names" and isinstance(given, str) else given


def _cells(row: Mapping[str, Any], names: Sequence[str]) -> list[Any]:
    reason = explain_exclusion(row).replace(row["path"], Path(row["path"]).name)
    return [*(row.get(name) for name in names), reason]


def open_study(path: Path) -> Studied:
    """Return a study that was run.

    Raises
    ------
    Refused
        If none of its recordings has a row of its question yet.
    ParameterError
        If the file describes no study.
    """
    plan = read_plan(path)
    question = key_of_question(plan.task, plan.question)
    of = {str(each.resolve()): place for place, each in enumerate(plan.recordings)}
    there = [each for each in Dataset(plan.output / ROWS_FOLDER).read() if each["path"] in of]
    # A plan that has changed since asks another question than the rows that are there answer.
    rows = [each for each in there if each.get("question") == question]
    if not rows:
        yet = "no rows of its question" if there else "no rows"
        raise RequestRefused(f"{path} has {yet} yet: run `tissue_probe study run {path}` first")
    return Studied(path.name, plan, sorted(rows, key=lambda each: of[each["path"]]))
