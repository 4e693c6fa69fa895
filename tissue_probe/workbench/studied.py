"""A study beside the desk: its table, of which each row opens its recording.

Contents: what of the rows a page is told, and how a recording of it is read and asked about.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from tissue_probe.studies.dataset import Dataset
from tissue_probe.studies.exclusion import left_out
from tissue_probe.studies.plan import Plan, read_plan
from tissue_probe.studies.row import SIGNALS
from tissue_probe.studies.running import ROWS
from tissue_probe.workbench.question import Asked
from tissue_probe.workbench.refused import Refused

#: Columns of the page's table, where the rows have them; the factors stand before them.
COLUMNS = ("status", "stiffness", "damping", "quality", "verdict", "missing", "over_noise")


@dataclass(frozen=True)
class Studied:
    """A study whose rows are there.

    Attributes
    ----------
    name : str
        Its file's name.
    plan : Plan
        What was asked.
    rows : sequence of dict
        In the order of the plan's recordings.
    """

    name: str
    plan: Plan
    rows: Sequence[Mapping[str, Any]]

    @property
    def layout(self) -> dict[str, Any]:
        """What the study states of its recordings' signals."""
        return {name: each for name, each in self.plan.question.items() if name in SIGNALS}

    @property
    def asked(self) -> dict[str, Any]:
        """What the study asks, as far as the desk can."""
        known = {each.name for each in fields(Asked)}
        return {name: each for name, each in self.plan.question.items() if name in known}

    def path(self, row: int) -> Path:
        """Return the recording of a row.

        Raises
        ------
        Refused
            If there is no such row.
        """
        if not 0 <= row < len(self.rows):
            raise Refused(f"the study has no row {row}")
        return Path(self.rows[row]["path"])

    def told(self) -> dict[str, Any]:
        """Return the table; recordings by their names, since no page is to know where they lie."""
        shown = [name for name in COLUMNS if any(name in each for each in self.rows)]
        names = [*self.plan.factors, *shown]
        return {
            "name": self.name,
            "columns": ["recording", *names, "reason"],
            "rows": [[Path(each["path"]).name, *_cells(each, names)] for each in self.rows],
        }


def _cells(row: Mapping[str, Any], names: Sequence[str]) -> list[Any]:
    reason = left_out(row).replace(row["path"], Path(row["path"]).name)
    return [*(row.get(name) for name in names), reason]


def opened_study(path: Path) -> Studied:
    """Return a study that was run.

    Raises
    ------
    Refused
        If none of its recordings has a row yet.
    ParameterError
        If the file describes no study.
    """
    plan = read_plan(path)
    of = {str(each.resolve()): place for place, each in enumerate(plan.recordings)}
    rows = [each for each in Dataset(plan.output / ROWS).read() if each["path"] in of]
    if not rows:
        raise Refused(f"{path} has no rows yet: run `tissue_probe study run {path}` first")
    return Studied(path.name, plan, sorted(rows, key=lambda each: of[each["path"]]))
