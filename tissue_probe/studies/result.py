"""The rows of a study, and the statistics of them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tissue_probe import arguments as take
from tissue_probe.errors import FileError, ParameterError
from tissue_probe.likeness import Alike
from tissue_probe.one_line import sentence
from tissue_probe.studies.agreement import Agreement, agreement_of
from tissue_probe.studies.exclusion import explain_exclusion
from tissue_probe.studies.provenance import refuse_two_questions
from tissue_probe.studies.shares import shares_missing
from tissue_probe.studies.spread import Interval, Spread, spread_of

if TYPE_CHECKING:
    import pandas as pd


def deviation_of(value: str) -> str:
    """Return the column with the standard deviation of a value's error."""
    return f"{value}.sd" if value.startswith("value.") else f"{value}_sd"


@dataclass(frozen=True, eq=False, repr=False)
class StudyResult(Alike):
    """The rows of a study.

    Attributes
    ----------
    rows : tuple of dict
        One a recording, with its factors; see ``row``.
    computed : int
        How many of them were computed by this run.
    notes : tuple of str
        Damaged batches, changed files and repeated ones, in sentences.
    question : mapping
        Keywords of ``row`` for each.
    """

    rows: tuple[Mapping[str, Any], ...]
    computed: int
    notes: tuple[str, ...] = ()
    question: Mapping[str, Any] = field(default_factory=dict)

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as a pandas data frame."""
        import pandas as pd

        return pd.DataFrame(list(self.rows))

    def to_dict(self) -> dict[str, Any]:
        """Return the rows as plain data."""
        return {"rows": list(self.rows), "computed": self.computed, "notes": list(self.notes)}

    @property
    def text(self) -> str:
        """How many recordings there are, and how many of them were done, refused or failed."""
        counts = {
            status: sum(each["status"] == status for each in self.rows)
            for status in ("done", "refused", "failed")
        }
        told = [f"{count} {status}" for status, count in counts.items() if count]
        first = f"{len(self.rows)} recordings, {self.computed} computed now: {', '.join(told)}"
        return "\n".join([first, *self.notes])

    def __repr__(self) -> str:
        return self.text

    @take.checks(value=take.text, specimen=take.text, by=take.optional(take.text))
    def spread(
        self, value: str = "stiffness", *, specimen: str = "specimen", by: str | None = None
    ) -> Spread:
        """Return how a value spreads over specimens and repeats, and over groups.

        Parameters
        ----------
        value : str
            A column whose error the rows tell (``stiffness``, ``damping``, ``value.NAME``).
        specimen : str
            The factor that tells the specimen.
        by : str, optional
            A factor whose groups are compared.

        Raises
        ------
        ParameterError
            If there is no such column, there are too few specimens or repeats, or the rows of a
            group answer two questions.
        """
        columns = (value, deviation_of(value), specimen, *([by] if by else []))
        refuse_two_questions(self.take_rows(columns), by)
        y, sd, of, *groups = self._known(columns)
        return spread_of(
            np.array(y, dtype=float), np.array(sd, dtype=float), of, groups[0] if groups else None
        )

    @take.checks(value=take.text, of=take.text, specimen=take.text)
    def agreement(
        self, value: str = "stiffness", *, of: str, specimen: str = "specimen"
    ) -> Agreement:
        """Return how two instruments, operators or models agree.

        Repeats of one specimen by one of them count as their mean.

        Parameters
        ----------
        value : str
            A column of numbers.
        of : str
            The factor with the two that are compared.
        specimen : str
            The factor that pairs them.

        Raises
        ------
        ParameterError
            If there is no such column, the factor has not two values, there are too few pairs, or
            the rows of one of the two answer two questions.
        """
        refuse_two_questions(self.take_rows((value, of, specimen)), of)
        y, ways, pairs = self._known((value, of, specimen))
        names = sorted(set(ways))
        if len(names) != 2:
            raise ParameterError(
                f"`of` {of}: it has the values {', '.join(names)}; two are compared"
            )
        found: dict[tuple[str, str], list[float]] = {}
        for number, way, pair in zip(y, ways, pairs, strict=True):
            found.setdefault((pair, way), []).append(float(number))
        both = [p for p in sorted(set(pairs)) if all((p, name) in found for name in names)]
        first, second = (np.array([np.mean(found[p, name]) for p in both]) for name in names)
        return agreement_of(first, second)

    def missing(self) -> dict[str, Interval]:
        """Return the share of diagnosed recordings that miss each effect, the largest first.

        Raises
        ------
        ParameterError
            If no row has a verdict, or they answer two questions.
        """
        refuse_two_questions([each for each in self.rows if "verdict" in each], None)
        return shares_missing(self.rows)

    def take_rows(self, columns: Sequence[str]) -> list[Mapping[str, Any]]:
        """Return the rows that statistics of some columns take: those that have all of them.

        Raises
        ------
        ParameterError
            If no row in the statistics has one of the columns.
        """
        done = [each for each in self.rows if not explain_exclusion(each)]
        if not done:
            raise ParameterError("all recordings are left out of the statistics: see why in each")
        names = list(dict.fromkeys(name for each in done for name in each))
        for name in columns:
            if name not in names:
                raise ParameterError(f"no recording has a {name}; there are {', '.join(names)}")
        return [each for each in done if all(name in each for name in columns)]

    def _known(self, columns: Sequence[str]) -> list[list[Any]]:
        rows = self.take_rows(columns)
        return [[each[name] for each in rows] for name in columns]

    @take.checks(path=take.path, value=take.text, specimen=take.text, by=take.optional(take.text))
    def report(
        self,
        path: str | Path,
        *,
        value: str = "stiffness",
        specimen: str = "specimen",
        by: str | None = None,
    ) -> None:
        """Write the study as one HTML page that needs nothing else.

        It links to ``table.csv`` and ``table.parquet`` beside it, and to the recordings' own
        reports where they are, in the folder ``reports``.

        Parameters
        ----------
        path : path
            The page, in the study's folder.
        value, specimen, by
            As in ``spread``.

        Raises
        ------
        ParameterError
            If no recording has such a value.
        FileError
            If it cannot be written.
        """
        from tissue_probe.report.study_page import render_study
        from tissue_probe.studies.reporting import page_of

        path = Path(path)
        text = render_study(page_of(self, path.parent, value, specimen, by))
        unfinished = path.with_name(f"_unfinished-{path.name}")
        try:
            unfinished.write_text(text, encoding="utf-8")
            os.replace(unfinished, path)
        except OSError as error:
            unfinished.unlink(missing_ok=True)
            raise FileError(f"the report cannot be written: {sentence(error)}") from error
