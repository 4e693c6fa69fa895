"""Whether what is stated with a probability is right as often as it says.

Contents: what an answer for programs states, beside the truth, and the table.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from rich.table import Table
from scipy.stats import binomtest

#: Bounds of the bins of a probability, up to 1.
BINS = (0.0, 0.5, 0.7, 0.9, 0.97, 1.0)
#: Probability of the set that an answer gives first.
SET = 0.95
NAMING = ("missing", "ambiguous")


@dataclass(frozen=True)
class Stated:
    """What is stated of one recording, and whether it is so.

    Attributes
    ----------
    probability : float
        That the effect which ranks first is missing.
    right : bool
        Whether it is.
    named : bool
        Whether the verdict names effects: the answer without its probability.
    family : bool or None
        Whether the family that is claimed is right; None where none is.
    held : bool or None
        Whether the set of models that has a probability of 0.95 holds the right one; None where
        nothing is hidden, or nothing is named.
    size : int
        Models in that set.
    """

    probability: float
    right: bool
    named: bool
    family: bool | None
    held: bool | None
    size: int


def stated(
    answer: Mapping[str, Any], truths: Collection[Collection[str]], families: Collection[str]
) -> Stated:
    """Compare an answer for programs with the truth.

    Parameters
    ----------
    answer : mapping
        What ``diagnose --json`` writes.
    truths : collection of collections of str
        The models that are right, each by the names of its effects; empty where nothing is hidden.
    families : collection of str
        Of what is hidden.
    """
    first = answer["ranking"][0]
    named = answer["verdict"] in NAMING
    told = _set(answer["models"])
    right = {frozenset(each) for each in truths}
    return Stated(
        first["probability"],
        any(first["effect"] in each for each in right),
        named,
        None if answer["family"] is None else answer["family"] in families,
        any(each in right for each in told) if right and named else None,
        len(told),
    )


def _set(models: Sequence[Mapping[str, Any]]) -> list[frozenset[str]]:
    """Return the fewest models that together have the probability of the set."""
    sums = np.cumsum([each["probability"] for each in models])
    count = int(np.searchsorted(sums, SET)) + 1
    return [frozenset(each["effects"]) for each in models[:count]]


def table(title: str, all_stated: Iterable[Stated]) -> Table:
    """Return how often what is stated is right, bin by bin, and what else follows."""
    every = list(all_stated)
    made = Table("", "recordings", "stated", "right", title=title, title_justify="left")
    for column in made.columns[1:]:
        column.justify = "right"
    for low, high in pairwise(BINS):
        inside = [
            each
            for each in every
            if low <= each.probability < high or each.probability == high == 1
        ]
        if inside:
            mean = np.mean([each.probability for each in inside])
            name = f"P of the first effect in {low:g} to {high:g}"
            made.add_row(
                name, str(len(inside)), f"{mean:.3f}", _share(each.right for each in inside)
            )
    made.add_section()
    for name, told in (
        ("Brier's score", [each.probability for each in every]),
        ("  of names taken as certain", [float(each.named) for each in every]),
    ):
        score = np.mean([(p - each.right) ** 2 for p, each in zip(told, every, strict=True)])
        made.add_row(name, str(len(every)), "", f"{score:.4f}" if every else "-")
    families = [each.family for each in every if each.family is not None]
    made.add_row("a family is claimed", str(len(families)), "", _share(families))
    held = [each for each in every if each.held is not None]
    made.add_row(
        f"the set of {SET:g} holds the truth",
        str(len(held)),
        "",
        _share(each.held for each in held),
    )
    if held:
        made.add_row("  models in it, mean", "", "", f"{np.mean([each.size for each in held]):.2f}")
    made.caption = "in brackets: 95 % interval of the share (Clopper and Pearson), in %"
    made.caption_justify = "left"
    return made


def _share(right: Iterable[bool | None]) -> str:
    marks = [bool(each) for each in right]
    if not marks:
        return "-"
    interval = binomtest(sum(marks), len(marks)).proportion_ci(0.95, "exact")
    low, high = (f"{100.0 * end:.0f}" for end in interval)
    return f"{np.mean(marks):.3f} ({low} to {high})"
