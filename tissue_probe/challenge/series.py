"""Series of challenges: which effects they hide.

Contents: dealing names.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, Literal

import numpy as np

from tissue_probe.challenge.instrumental import SPOILING_EFFECTS
from tissue_probe.challenge.outside import OUTSIDE
from tissue_probe.challenge.simulator import (
    LIBRARY,
    SIMULATED_EFFECTS,
    WEAKEST_OF_TWO,
    Challenge,
    Excitation,
    HiddenTruth,
    Rig,
    make_challenge,
)
from tissue_probe.challenge.strength import ABSORBED
from tissue_probe.challenge.trajectory import DURATIONS
from tissue_probe.errors import ParameterError

Effects = tuple[str, ...]


Hide = Literal["one", "two", "none", "outside", "spoilt", "mixed"]

SHARES: dict[Hide, float] = {"one": 0.6, "two": 0.15, "none": 0.1, "outside": 0.1, "spoilt": 0.05}
"""What a recording may hide, and how often it does in ``mixed``."""

_NOT_BESIDE = {name: effect for name, effect in LIBRARY.items() if not effect.beside}
PACKS = {"one": _NOT_BESIDE, "outside": OUTSIDE, "spoilt": SPOILING_EFFECTS}

SHOWN_ALONE = 0.95 * WEAKEST_OF_TWO
"""What each of two effects must leave alone, in units of the noise."""

LEAST_BESIDE_OTHERS = ABSORBED
"""And where the fit may move the rig within its tolerances."""

ANY: Final = "any"
"""An excitation drawn for each recording."""

PAIRS_TRIED = 20
"""How many pairs are tried until both effects show; of named excitations three in four do."""


def make_series(
    hide: Hide, count: int, seed: int, excitation: Excitation | Literal["any"], rig: Rig
) -> Iterator[Challenge]:
    """Yield ``count`` challenges; the same arguments give the same ones.

    Two effects of which one would not show are replaced by two others, and by one alone where no
    two are found that the excitation shows. ``any`` draws the excitation of each recording.

    Raises
    ------
    ValueError
        If a name is not known.
    """
    if hide not in (*SHARES, "mixed"):
        raise ParameterError(f"cannot hide {hide!r}; there are {', '.join(SHARES)}, mixed")
    random = np.random.default_rng(seed)
    for effects in deal(hide, count, random):
        if excitation == ANY:
            yield _hide_showing(
                effects, tuple(DURATIONS)[random.choice(len(DURATIONS))], rig, random
            )
        else:
            yield _hide_showing(effects, excitation, rig, random)


def _hide_showing(
    effects: Effects, excitation: Excitation, rig: Rig, random: np.random.Generator
) -> Challenge:
    """Hide effects, or others in their place if they are two and do not both show."""
    seed = int(random.integers(2**32))
    for _ in range(PAIRS_TRIED):
        challenge = make_challenge(seed, effects, excitation, rig)
        if all_show(challenge.answer):
            return challenge
        seed, effects = int(random.integers(2**32)), _pair(random)
    return make_challenge(seed, effects[:1], excitation, rig)


def all_show(answer: HiddenTruth) -> bool:
    """Whether each of several effects leaves something alone, beyond the rig's tolerances too."""
    if len(answer.effects) < 2:
        return True
    return (
        min(answer.ratios.values()) >= SHOWN_ALONE
        and min(answer.shown.values()) >= LEAST_BESIDE_OTHERS
    )


def deal(hide: Hide, count: int, random: np.random.Generator) -> list[Effects]:
    """Return the effects of ``count`` recordings.

    Single effects are dealt as from a shuffled pack, so that each comes equally often; of two, both
    are of different families.
    """
    kinds: list[Hide] = [hide] * count
    if hide == "mixed":
        drawn = random.choice(len(SHARES), count, p=list(SHARES.values()))
        kinds = [tuple(SHARES)[place] for place in drawn]
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
        preloads = SIMULATED_EFFECTS[one].sets_preload and SIMULATED_EFFECTS[other].sets_preload
        same = SIMULATED_EFFECTS[one].family == SIMULATED_EFFECTS[other].family
        if not (same or preloads or _is_another(one, other) or _is_another(other, one)):
            return one, other


def _is_another(one: str, other: str) -> bool:
    """Whether an effect beside another one is a third."""
    return bool(SIMULATED_EFFECTS[one].beside) and other not in SIMULATED_EFFECTS[one].beside
