"""The groups of records: who makes each, how it is asked about, and what is marked.

Contents: a line and a function a group.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import tissue_probe as tp
from benchmarks.instrument import (
    in_motion,
    resonance,
    rezeroed,
    two_rates,
    uneven,
    zero_of_position,
)
from benchmarks.instrument.case import Case
from benchmarks.instrument.outcome import (
    Answer,
    Outcome,
    finds,
    last_values,
    law_is_right,
    mark_carries_over,
    mark_values,
    off_by,
    off_in_words,
    said,
)

#: Columns.
LAW, NAME, CLOSE, STIFFNESS = "law right", "right by name", "values within 3 %", "k within 2 %"
FITTED, HONEST, TOLD = "law fitted", "right, or widened and said", "outliers told"
WIDTH = "width / exact"
#: Words of a finding that tells spoilt samples, and of one that tells too few of them.
OUTLIERS, FEW = ("stand alone", "outlier", "sign"), ("samples a second", "samples a period")
#: An interval so many times wider than the exact one is widened.
WIDER = 1.5


def ask(case: Case, add: tuple[str, ...] = ()) -> Answer:
    """Return what the diagnosis says of a record, for programs; with the notes on how it was read.

    Raises
    ------
    Exception
        Whatever ends a diagnosis: of the package's own family, or of a library.
    """
    first, second = (
        record and tp.read(record.columns(), force_polarity="compression")
        for record in (case.first, case.second)
    )
    found = tp.diagnose(first, validate=second, add=add, **case.arguments)
    answer = found.to_dict()
    return answer | {"findings": [*answer["findings"], *found.notes]}


def resonant(case: Case, outcome: Outcome, answer: Answer) -> None:
    """Mark the name, and by a fit with the true law its values, widths and the second record."""
    _mark_law(outcome, case, answer)
    _mark_fitted(outcome, case)


def few(case: Case, outcome: Outcome, answer: Answer) -> None:
    """Mark the same, and that what is not right is at least said to be doubtful."""
    _mark_law(outcome, case, answer)
    fitted = _mark_fitted(outcome, case)
    inside = outcome.inside == outcome.intervals
    right = outcome.marks[LAW] and outcome.marks["carries over"] and inside
    widened = inside and outcome.numbers[WIDTH] > WIDER and finds(fitted, FEW)
    outcome.mark(HONEST, right or widened, "neither right nor widened")


def moving(case: Case, outcome: Outcome, answer: Answer) -> None:
    """Mark the law, and the second record."""
    _mark_law(outcome, case, answer)
    mark_values(outcome, answer, case.truth.values)
    mark_carries_over(outcome, answer, case.second.noise)


def shifted(case: Case, outcome: Outcome, answer: Answer) -> None:
    """Mark the law by its name, and that the values are close."""
    _mark_name(outcome, case, answer)
    off = off_by(answer, case.truth.values)
    worst = max(off, key=lambda name: off[name])
    outcome.mark(CLOSE, off[worst] <= 0.03, off_in_words(worst, off[worst]))


def silent(case: Case, outcome: Outcome, answer: Answer) -> None:
    """Mark that no effect of the tissue is told that is not there, and the stiffness."""
    _mark_name(outcome, case, answer)
    _mark_stiffness(outcome, case, answer)


def spoilt(case: Case, outcome: Outcome, answer: Answer) -> None:
    """Mark the law, the stiffness, and that spoilt samples are told."""
    silent(case, outcome, answer)
    outcome.mark(TOLD, finds(answer, OUTLIERS), "outliers not told")


def slow(case: Case, outcome: Outcome, answer: Answer) -> None:
    """Mark the law by its name, and count the intervals."""
    _mark_name(outcome, case, answer)
    mark_values(outcome, answer, case.truth.values)


@dataclass(frozen=True)
class Group:
    """Who makes a record of a seed, who marks its answer, and the columns of the marks."""

    make: Callable[[int], Case]
    mark: Callable[[Case, Outcome, Answer], None]
    columns: tuple[str, ...]


_FITTED = (LAW, NAME, FITTED, "carries over")
GROUPS = {
    "resonance": Group(resonance.make, resonant, _FITTED),
    "few_samples": Group(resonance.make_few, few, (*_FITTED, HONEST)),
    "in_motion": Group(in_motion.make, moving, (LAW, NAME, "carries over")),
    "zero_of_position": Group(zero_of_position.make, shifted, (NAME, CLOSE)),
    "rezeroed": Group(rezeroed.make, silent, (NAME, STIFFNESS)),
    "uneven": Group(uneven.make, spoilt, (NAME, STIFFNESS, TOLD)),
    "two_rates": Group(two_rates.make, slow, (NAME,)),
}


def outcome_of(group: str, seed: int) -> Outcome:
    """Make a record, ask, and mark."""
    began = time.perf_counter()
    case = GROUPS[group].make(seed)
    outcome = Outcome(group, case.kind, seed)
    try:
        answer = ask(case)
        outcome.told = said(answer)
        GROUPS[group].mark(case, outcome, answer)
    except Exception as error:
        # Whatever ends a diagnosis is a refusal, an untold exception of a library too.
        kind = "" if isinstance(error, tp.TissueProbeError) else f"{type(error).__name__}: "
        outcome.told, outcome.refused = f"{kind}{error}", True
        outcome.wrong.append("refused")
    # What a refusal leaves unsaid is not right.
    outcome.marks = {name: outcome.marks.get(name, False) for name in GROUPS[group].columns}
    outcome.seconds = time.perf_counter() - began
    return outcome


def _mark_law(outcome: Outcome, case: Case, answer: Answer) -> None:
    outcome.mark(LAW, law_is_right(answer, case.truth), "another law")
    outcome.marks[NAME] = law_is_right(answer, case.truth, by_name=True)


def _mark_name(outcome: Outcome, case: Case, answer: Answer) -> None:
    """Mark the law by its name: a branch more than there is tells a zero or a gap as tissue."""
    outcome.mark(NAME, law_is_right(answer, case.truth, by_name=True), "another law")


def _mark_fitted(outcome: Outcome, case: Case) -> Answer:
    """Fit the true law, and mark its values, their widths and the second record."""
    fitted = ask(case, tuple(case.truth.effects))
    outcome.mark(FITTED, fitted["verdict"] == "missing", f"with the law: {fitted['verdict']}")
    mark_values(outcome, fitted, case.truth.values)
    found = last_values(fitted)
    shares = [found[name][1] / sd for name, sd in case.truth.widths.items() if name in found]
    outcome.numbers[WIDTH] = float(np.median(shares))
    mark_carries_over(outcome, fitted, case.second.noise)
    return fitted


def _mark_stiffness(outcome: Outcome, case: Case, answer: Answer) -> None:
    off = off_by(answer, {"stiffness": case.truth.values["stiffness"]})["stiffness"]
    outcome.mark(STIFFNESS, off <= 0.02, off_in_words("k", off))
