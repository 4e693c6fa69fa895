"""Which effects a recording promises, by one fit: a first look before a diagnosis.

Contents: the question, and the table that answers it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe import arguments as take
from tissue_probe.analysis.asking import asks
from tissue_probe.analysis.measurements import Source, measurements_of
from tissue_probe.analysis.question import Asked, question
from tissue_probe.analysis.result_table import Column, ResultTable, number
from tissue_probe.diagnosis.diagnosis import promises as search
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.ranking.screen import Promise
from tissue_probe.diagnosis.sharing import WORKERS, among
from tissue_probe.likeness import Alike

if TYPE_CHECKING:
    from typing_extensions import Unpack


@dataclass(frozen=True, eq=False, repr=False)
class PromiseResult(Alike):
    """Effects in the order of their promise; none of them was fitted.

    Attributes
    ----------
    base : Fit
        The model that was asked about.
    promised : tuple of Promise
        Each effect, and the cost that it may leave.
    notes : tuple of str
        Changes of the samples when they were read, and their faults.
    """

    base: Fit
    promised: tuple[Promise, ...]
    notes: tuple[str, ...]

    @property
    def ranking(self) -> ResultTable:
        """Effects, their families, and the error that each may leave at best."""
        output = self.base.output
        columns = (
            Column("effect", "effect"),
            Column("family", "family"),
            Column(
                "promised_rmse",
                f"error it may leave [{output.small}]",
                number(4, output.per_small),
                right=True,
            ),
        )
        rows = tuple(
            (each.effect.name, each.effect.family, self._measure_rest(each))
            for each in self.promised
        )
        return ResultTable("By promise alone: no effect was fitted", columns, rows)

    def _measure_rest(self, promise: Promise) -> float:
        return self.base.rmse * float(np.sqrt(promise.cost / self.base.cost))

    @property
    def text(self) -> str:
        """One sentence on the model that was asked about."""
        output = self.base.output
        error, noise = (
            f"{output.per_small * each:.4g} {output.small}"
            for each in (self.base.rmse, self.base.noise)
        )
        return (
            f"The model leaves {error}, and the noise is {noise}. An effect that switches "
            "(contact, play, dry friction) may explain more than it promises: the whole "
            "diagnosis fits every effect."
        )

    def __repr__(self) -> str:
        return f"{self.ranking}\n{self.text}"


@asks
@take.checks(workers=take.whole(1))
def promises(
    measured: Source | Sequence[Source],
    *,
    workers: int = WORKERS,
    **asked: Unpack[Asked],
) -> PromiseResult:
    """Rank effects by their promise, to first order, beside a model that is fitted once.

    Parameters
    ----------
    measured
        As ``diagnose`` has it.
    workers : int
        Processes that may share the work, 1 or more: this one, and one copy of it (fork) at most;
        1 keeps all of it in this process. The numbers are the same.
    **asked
        See ``Asked``.

    Raises
    ------
    TissueProbeError
        If something cannot be read or fitted; says why, and the remedy.
    """
    put = question(**asked)
    output = put.composition.output
    fitted = measurements_of(measured)
    taken = put.segments(fitted)
    with among(workers):
        base, ranking, findings = search(
            put.composition,
            [each.measurement(output) for each in taken],
            put.instrument_for(fitted),
            put.library,
            put.model.values,
        )
    notes = (*put.notes, *(finding.sentence for finding in findings))
    return PromiseResult(base, tuple(ranking), notes)
