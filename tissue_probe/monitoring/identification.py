"""The identification of a model by several records: the question, its answer, when it ends.

Contents: question and answer as plain values, to pass between processes; the rule of the end.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tissue_probe.monitoring.experiments import ExcitationBounds
from tissue_probe.monitoring.question import MonitorAnswer, touch_anywhere
from tissue_probe.monitoring.tested_model import TestedModel
from tissue_probe.signals import FloatArray

#: Verdicts by which it is known which model holds.
CERTAIN = ("adequate", "missing")


@dataclass(frozen=True)
class LiveRecord:
    """One record, of one excitation, without a hole.

    Attributes
    ----------
    position, force, command : array, shape (n,)
        Displacement of the coil [m], force [N], voltage commanded [V]; finite.
    sample_period : float
        Time between two samples [s].
    excitation : mapping
        As the driver has it: kind, amplitude [V], frequencies [Hz], duration [s].
    path : str
        Of its file; empty where there is none.
    """

    position: FloatArray
    force: FloatArray
    command: FloatArray
    sample_period: float
    excitation: Mapping[str, object]
    path: str = ""


@dataclass(frozen=True)
class RecordsQuestion:
    """Records of one site that are diagnosed together, and the model that is asked about.

    Attributes
    ----------
    records : tuple of LiveRecord
        In the order in which they were made.
    rig, model, effects, constants
        As ``Question`` has them.
    bounds : ExcitationBounds
        Of the next excitation.
    probability : float
        That the answer is to have.
    """

    records: tuple[LiveRecord, ...]
    rig: str
    model: str
    effects: tuple[str, ...]
    constants: dict[str, tuple[float, float]]
    bounds: ExcitationBounds
    probability: float


@dataclass(frozen=True)
class RecordsVerdict(MonitorAnswer):
    """The answer.

    Attributes
    ----------
    probability : float
        Of the model that the verdict names, over all that were tried.
    excitation : mapping
        The next one, as the driver takes it; empty where none within the bounds tells more.
    duration : float
        Time to record it [s].
    """

    probability: float
    excitation: Mapping[str, object]
    duration: float

    def is_settled(self, probability: float) -> bool:
        """Whether the answer has a probability, and no excitation would show more."""
        known = self.verdict in CERTAIN and self.probability >= probability
        return known and not self.excitation


def ask_about_records(
    model: TestedModel,
    records: Sequence[LiveRecord],
    bounds: ExcitationBounds,
    probability: float,
    file: str = "",
    effects: tuple[str, ...] = (),
) -> RecordsQuestion:
    """Ask which effect a model misses on all records together; as ``question`` does for one."""
    position = np.concatenate([each.position for each in records])
    return RecordsQuestion(
        tuple(records),
        model.composition.rig.name,
        file,
        effects,
        touch_anywhere(model, position),
        bounds,
        probability,
    )


def find_end(verdict: RecordsVerdict, probability: float, records: int, most: int) -> str:
    """Say why an identification ends after some records; empty where another is to be made.

    Parameters
    ----------
    verdict : RecordsVerdict
        Of all records so far.
    probability : float
        That was asked for.
    records, most : int
        How many there are, and how many there may be.
    """
    reached = f"{verdict.verdict}, with a probability of {verdict.probability:.3f}"
    if verdict.is_settled(probability):
        return f"settled: {reached}"
    if not verdict.excitation:
        helps = f"; {verdict.experiment}" if verdict.experiment else ""
        return f"no excitation within the limits tells more: {reached}{helps}"
    if records >= most:
        return f"the budget of {most} records is spent: {reached}"
    return ""
