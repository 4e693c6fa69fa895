"""The rows of a study, and the statistics of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tissue_probe import arguments as take
from tissue_probe.alike import Alike
from tissue_probe.errors import ParameterError
from tissue_probe.studies.agreement import Agreement, agreement_of
from tissue_probe.studies.shares import shares_missing
from tissue_probe.studies.spread import Interval, Spread, spread_of

if TYPE_CHECKING:
    import pandas as pd


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
        What was found on the way, in sentences.
    """

    rows: tuple[Mapping[str, Any], ...]
    computed: int
    notes: tuple[str, ...] = ()

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as a pandas data frame."""
        import pandas as pd

        return pd.DataFrame(list(self.rows))

    def to_dict(self) -> dict[str, Any]:
        """Return the rows as plain data."""
        return {"rows": list(self.rows), "computed": self.computed, "notes": list(self.notes)}

    @property
    def text(self) -> str:
        """How many recordings there are, and what became of them."""
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
            If there is no such column, or there are too few specimens or repeats.
        """
        deviation = f"{value}.sd" if value.startswith("value.") else f"{value}_sd"
        columns = (value, deviation, specimen, *([by] if by else []))
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
            If there is no such column, the factor has not two values, or there are too few pairs.
        """
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
            If no row has a verdict.
        """
        return shares_missing(self.rows)

    def _known(self, columns: Sequence[str]) -> list[list[Any]]:
        """Return columns of the recordings that are done, where they have all of them."""
        done = [each for each in self.rows if each["status"] == "done"]
        names = list(dict.fromkeys(name for each in done for name in each))
        for name in columns:
            if name not in names:
                raise ParameterError(f"no recording has a {name}; there are {', '.join(names)}")
        rows = [each for each in done if all(name in each for name in columns)]
        return [[each[name] for each in rows] for name in columns]
