"""What was said of one record, and which of it is right.

Contents: marks of an answer for programs beside the truth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.stats import norm

from benchmarks.instrument.case import Truth
from benchmarks.ruler.tables import NOISE

Answer = Mapping[str, Any]
#: Half the width of a 95 % interval, in standard deviations.
HALF_WIDTH = float(norm.ppf(0.975))


@dataclass
class Outcome:
    """Marks of one record.

    Attributes
    ----------
    group, kind, seed
        Of the record.
    told : str
        Verdict and effects, or the sentence of the refusal.
    refused : bool
        Whether there was no diagnosis.
    marks : dict of str to bool
        What is right, by the name of its column.
    numbers : dict of str to float
        Of which a table shows the median.
    inside, intervals : int
        How many of how many 95 % intervals hold the true value.
    wrong : list of str
        What is wrong, in words.
    seconds : float
        Time that making, asking and marking took.
    """

    group: str
    kind: str
    seed: int
    told: str = ""
    refused: bool = False
    marks: dict[str, bool] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)
    inside: int = 0
    intervals: int = 0
    wrong: list[str] = field(default_factory=list)
    seconds: float = 0.0

    def mark(self, name: str, right: bool, otherwise: str) -> None:
        """Keep a mark, and where it is wrong the words for it."""
        self.marks[name] = bool(right)
        if not right:
            self.wrong.append(otherwise)


def said(answer: Answer) -> str:
    """Return verdict and effects in a few words."""
    effects = " + ".join(answer["effects"])
    return f"{answer['verdict']}{': ' if effects else ''}{effects}"


def law_is_right(answer: Answer, truth: Truth, by_name: bool = False) -> bool:
    """Whether the verdict is sure of the true effects of the tissue, and of no others.

    Parameters
    ----------
    answer : mapping
        For programs.
    truth : Truth
        Its ``besides`` may be named, or not.
    by_name : bool
        Whether an effect must be the true one, and not only of its family.
    """
    families = {each["effect"]: each["family"] for each in answer["ranking"]}
    named = [name for name in answer["effects"] if families.get(name) not in truth.besides]
    if not truth.effects:
        beside = bool(answer["effects"]) and not named
        return answer["verdict"] == "adequate" or (answer["verdict"] == "missing" and beside)
    if answer["verdict"] != "missing":
        return False
    if by_name:
        return sorted(named) == sorted(truth.effects)
    return sorted(families.get(name, "") for name in named) == sorted(truth.effects.values())


def last_values(answer: Answer) -> dict[str, tuple[float, float]]:
    """Return the last model's values and their standard deviations; inf where none is told."""
    return {
        name: (each["value"], np.inf if each["deviation"] is None else each["deviation"])
        for name, each in answer["ladder"][-1]["parameters"].items()
    }


def off_by(answer: Answer, truths: Mapping[str, float]) -> dict[str, float]:
    """Return by which share each value of the last model is off; inf of one that it has not."""
    found = last_values(answer)
    return {
        name: abs(found[name][0] / true - 1.0) if name in found else np.inf
        for name, true in truths.items()
    }


def off_in_words(name: str, share: float) -> str:
    """Say by how much a value is off."""
    known = np.isfinite(share)
    return f"{name} off by {100.0 * share:.2g} %" if known else f"{name} not in the last model"


def outside(answer: Answer, truths: Mapping[str, float], half_width: float) -> dict[str, str]:
    """Return the values whose interval does not hold the truth: by how many half widths.

    A value that the last model has not, another form of the law having none, is not judged.
    """
    found = {}
    for name, true in truths.items():
        value, deviation = last_values(answer).get(name, (true, np.inf))
        half = half_width * deviation
        if abs(value - true) > half:
            off = abs(value - true) / half if half else np.inf
            found[name] = (
                f"{name} {value:.6g} +- {half:.2g}, true {true:.6g} ({off:.3g} half widths)"
            )
    return found


def mark_values(outcome: Outcome, answer: Answer, truths: Mapping[str, float]) -> dict[str, str]:
    """Count the 95 % intervals that hold the truth; return those that do not."""
    judged = [name for name in truths if name in last_values(answer)]
    missed = outside(answer, truths, HALF_WIDTH)
    outcome.intervals += len(judged)
    outcome.inside += len(judged) - len(missed)
    outcome.wrong += missed.values()
    return missed


def joint_half_width(count: int) -> float:
    """Return the half width [sd] of so many intervals that together hold in 95 % (Bonferroni)."""
    return float(norm.ppf(1.0 - 0.025 / max(count, 1)))


def mark_carries_over(outcome: Outcome, answer: Answer, noise: float) -> None:
    """Mark that the last model leaves on the second record no more than its noise."""
    error = answer["rmse"]["heldout"]["final"]
    share = np.inf if error is None else error / noise
    outcome.numbers["error / noise on the second"] = share
    # Where it carries over only after both records were fitted together, no record is left to tell.
    kept = answer["verdict"] != "unexplained" and answer["carries_over"] is True
    outcome.mark(
        "carries over",
        kept and share <= NOISE,
        f"{answer['verdict']}, error {share:.3g} noise on the second, carries_over "
        f"{answer['carries_over']}",
    )


def finds(answer: Answer, words: Sequence[str]) -> bool:
    """Whether a finding has one of some words."""
    return any(word in sentence for sentence in answer["findings"] for word in words)
