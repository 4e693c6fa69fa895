"""What differs between two results of the golden records.

Contents: the records that changed and how, ratios of work and of time.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.golden.told import Told

#: A probability that moves by less tells nobody anything else: a twentieth, as of a sure set.
MOVED = 0.05


@dataclass(frozen=True)
class Change:
    """What differs of one record: the kinds of change, each told before and after."""

    name: str
    kinds: Mapping[str, str]


@dataclass(frozen=True)
class Ratio:
    """Of a count, after over before: of the sums, and the median of the records'."""

    sums: float
    median: float


def changes(before: Mapping[str, Told], after: Mapping[str, Told]) -> list[Change]:
    """Return what differs of the records that both have, those first that are no longer right."""
    pairs = (
        (name, dict(_kinds(before[name], now))) for name, now in after.items() if name in before
    )
    found = [Change(name, kinds) for name, kinds in pairs if kinds]
    order = ("right -> wrong", "wrong -> right")
    return sorted(found, key=lambda each: [kind not in each.kinds for kind in order])


def _kinds(was: Told, now: Told) -> Iterator[tuple[str, str]]:
    if was.right != now.right:
        yield ("right -> wrong", "wrong -> right")[now.right], ""
    for kind in ("verdict", "effects", "revisions"):
        old, new = getattr(was, kind), getattr(now, kind)
        if _plain(old) != _plain(new):
            yield kind, f"{_plain(old)} -> {_plain(new)}"
    moved = {
        name: (was.probabilities.get(name, 0.0), now.probabilities.get(name, 0.0))
        for name in {**was.probabilities, **now.probabilities}
    }
    told = [
        f"{name} {old:.2f} -> {new:.2f}"
        for name, (old, new) in moved.items()
        if abs(new - old) > MOVED
    ]
    if told:
        yield "probabilities", ", ".join(told)
    if was.refused != now.refused:
        yield "refused", f"{was.refused or 'no'} -> {now.refused or 'no'}"


def _plain(told: object) -> str:
    return told if isinstance(told, str) else "+".join(told) or "none"


def ratio(before: Mapping[str, Told], after: Mapping[str, Told], kind: str) -> Ratio | None:
    """Return the ratio of ``responses`` or ``seconds`` over the records that both diagnosed."""
    both = [name for name in after if name in before]
    old, new = (np.array([getattr(told[name], kind) for name in both]) for told in (before, after))
    counted = (old > 0.0) & (new > 0.0)
    if not counted.any():
        return None
    old, new = old[counted], new[counted]
    return Ratio(float(new.sum() / old.sum()), float(np.median(new / old)))
