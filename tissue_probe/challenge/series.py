"""Series of challenges: which effects they hide.

What belongs here: dealing names. What does not: their strength (``strength``), files (``folder``).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from tissue_probe.challenge.instrumental import SPOILT
from tissue_probe.challenge.outside import OUTSIDE
from tissue_probe.challenge.simulator import (
    EFFECTS,
    LIBRARY,
    WEAKEST_OF_TWO,
    Answer,
    Challenge,
    Rig,
    make_challenge,
)
from tissue_probe.challenge.strength import ABSORBED
from tissue_probe.challenge.trajectory import Kind

Effects = tuple[str, ...]


Hide = Literal["one", "two", "none", "outside", "spoilt", "mixed"]

SHARES: dict[str, float] = {"one": 0.6, "two": 0.15, "none": 0.1, "outside": 0.1, "spoilt": 0.05}
"""What a recording may hide, and how often it does in ``mixed``."""

PACKS = {"one": LIBRARY, "outside": OUTSIDE, "spoilt": SPOILT}

SHOWN = 0.95 * WEAKEST_OF_TWO
"""What each of two effects must leave alone, in units of the noise."""

BEYOND = ABSORBED
"""And where the fit may move the rig within its tolerances."""


def make_series(
    hide: Hide, count: int, seed: int, excitation: Kind, rig: Rig
) -> Iterator[Challenge]:
    """Yield ``count`` challenges; the same arguments give the same ones.

    Two effects of which one would not show are replaced by two others.

    Raises
    ------
    ValueError
        If a name is not known.
    """
    if hide not in (*SHARES, "mixed"):
        raise ValueError(f"cannot hide {hide!r}; there are {', '.join(SHARES)}, mixed")
    random = np.random.default_rng(seed)
    for effects in deal(hide, count, random):
        challenge = make_challenge(int(random.integers(2**32)), effects, excitation, rig)
        while not all_show(challenge.answer):
            another = int(random.integers(2**32))
            challenge = make_challenge(another, _pair(random), excitation, rig)
        yield challenge


def all_show(answer: Answer) -> bool:
    """Whether each of several effects leaves something alone, beyond the rig's tolerances too."""
    if len(answer.effects) < 2:
        return True
    return min(answer.ratios.values()) >= SHOWN and min(answer.shown.values()) >= BEYOND


def deal(hide: Hide, count: int, random: np.random.Generator) -> list[Effects]:
    """Return the effects of ``count`` recordings.

    Single effects are dealt as from a shuffled pack, so that each comes equally often; of two, both
    are of different families.
    """
    kinds = [hide] * count
    if hide == "mixed":
        kinds = random.choice(list(SHARES), count, p=list(SHARES.values())).tolist()
    hands = {kind: iter(_hand(kind, kinds.count(kind), random)) for kind in SHARES}
    return [next(hands[kind]) for kind in kinds]


def _hand(kind: str, count: int, random: np.random.Generator) -> list[Effects]:
    if kind == "none":
        return [()] * count
    if kind == "two":
        return [_pair(random) for _ in range(count)]
    names: list[str] = []
    while len(names) < count:
        names += random.permutation(list(PACKS[kind])).tolist()
    return [(name,) for name in names[:count]]


def _pair(random: np.random.Generator) -> Effects:
    while True:
        one, other = random.choice(list(LIBRARY), 2, replace=False).tolist()
        preloads = EFFECTS[one].sets_preload and EFFECTS[other].sets_preload
        if EFFECTS[one].family != EFFECTS[other].family and not preloads:
            return one, other
