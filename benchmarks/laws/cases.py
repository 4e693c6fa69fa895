"""The records of the benchmark: what is hidden in each, how it is made.

Contents: the plan of all records, and making one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count as count_from
from itertools import cycle, product
from typing import Literal
from zlib import crc32

import numpy as np

from benchmarks.laws.channel import draw_channel, hide_channel
from benchmarks.laws.library import BEFORE, BY_CHANNEL, NEW_FORM
from tissue_probe.challenge.simulator import (
    LIBRARY,
    Challenge,
    HiddenTruth,
    Rig,
    SimulatedRecord,
    make_challenge,
)
from tissue_probe.challenge.trajectory import DURATIONS, Kind
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.signals import FloatArray

#: What the best Kelvin-Voigt fit leaves of a newer law, in units of the noise.
STRENGTHS = (2.0, 5.0, 15.0)
RIGS: tuple[Rig, ...] = ("exact", "tolerant")
#: The excitation of which one record cannot tell many laws.
STEADY: Kind = "sine10ss"
#: Length of the records for whose time there is a goal [s]: these are asked about by the library
#: before, too.
TIMED = 2.0
#: Seeds of each part are apart, whichever other parts are measured; of a law by its name, so that
#: another law in the library moves none.
AFTER_CLEAN, AFTER_IDLE, FIRST_OF_LAWS = 10_000, 20_000, 100_000
SEEDS_OF_A_LAW, PLACES_OF_LAWS = 100, 4_000
#: Of records with an idle channel there are as many fewer than of clean ones.
TO_AN_IDLE = 5

Part = Literal["clean", "earlier", "idle", "law"]


@dataclass(frozen=True)
class Case:
    """A record to be made.

    Attributes
    ----------
    part : str
        "clean"; "earlier": an effect of the library before is hidden; "idle": clean, and a channel
        is recorded beside that drives nothing; "law": a newer law is hidden.
    law : str
        The newer law, or the earlier effect; empty where nothing is hidden.
    hidden : tuple of str
        All that is hidden: the law, and the effect beside which alone it is one.
    excitation, rig : str
        As the challenge names them.
    leaves : float or None
        What the law is to leave, in units of the noise; drawn where None.
    seed : int
        Of the challenge.
    """

    part: Part
    law: str
    hidden: tuple[str, ...]
    excitation: Kind
    rig: Rig
    leaves: float | None
    seed: int

    @property
    def is_timed(self) -> bool:
        """Whether the library before is asked, too, and the time of both is taken."""
        return self.part in ("clean", "earlier") and DURATIONS[self.excitation] == TIMED


@dataclass(frozen=True)
class MadeCase:
    """Two recordings of a specimen, and how much its law leaves."""

    first: Measurement
    second: Measurement
    ratio: float
    absorbed: bool


def plan_cases(
    laws: Sequence[str], rigs: Sequence[Rig], count: int, first_seed: int
) -> Iterator[Case]:
    """Yield the records: the clean ones first, then rig by rig the laws."""
    for number, rig in product(range(count), rigs):
        excitation = list(DURATIONS)[number % len(DURATIONS)]
        seed = first_seed + 2 * number + RIGS.index(rig)
        yield Case("clean", "", (), excitation, rig, None, seed)
        if DURATIONS[excitation] == TIMED:
            name = _earlier(first_seed, number)
            yield Case("earlier", name, (name,), excitation, rig, None, seed + AFTER_CLEAN)
        if number % TO_AN_IDLE == 0 and BY_CHANNEL in laws:
            idle = list(DURATIONS)[number // TO_AN_IDLE % len(DURATIONS)]
            yield Case("idle", "", (), idle, rig, None, seed + AFTER_IDLE)
    for rig, law in product(rigs, laws):
        yield from _of_law(law, rig, first_seed + _place(law, rig))


def _earlier(first_seed: int, number: int) -> str:
    """Return the effect hidden in a record, of a pack that is shuffled anew when it is through."""
    pack = [name for name in BEFORE if name in LIBRARY]
    through, place = divmod(number, len(pack))
    shuffled = np.random.default_rng((first_seed, through)).permutation(pack)
    return str(shuffled[place])


def _place(law: str, rig: Rig) -> int:
    place = SEEDS_OF_A_LAW * (crc32(law.encode()) % PLACES_OF_LAWS)
    return FIRST_OF_LAWS + place + RIGS.index(rig) * SEEDS_OF_A_LAW // len(RIGS)


def _of_law(law: str, rig: Rig, first_seed: int) -> Iterator[Case]:
    beside = cycle(LIBRARY[law].beside or ("",) if law in LIBRARY else ("",))
    seeds = count_from(first_seed)
    for leaves, excitation in product(STRENGTHS, DURATIONS):
        hidden = tuple(filter(None, (next(beside), law)))
        yield Case("law", law, hidden, excitation, rig, leaves, next(seeds))


def make_case(case: Case) -> MadeCase:
    """Simulate a record."""
    still = case.excitation != STEADY
    if case.part == "idle" or case.law == BY_CHANNEL:
        return _beside_channel(case, still)
    made = _challenge(case)
    first, second = _measured(made.recording, still), _measured(made.second, True)
    ratio = made.answer.ratios[case.law] if case.law else 1.0
    return MadeCase(first, second, ratio, case.law in made.answer.absorbed)


def _challenge(case: Case) -> Challenge:
    """Return a challenge; of a law with a newer form the first of its seeds that hides that one."""
    arguments = case.hidden, case.excitation, case.rig
    if case.part != "law" or case.law not in NEW_FORM:
        return make_challenge(case.seed, *arguments, leaves=case.leaves)
    step = SEEDS_OF_A_LAW * PLACES_OF_LAWS
    drawn = (
        make_challenge(seed, *arguments, leaves=case.leaves) for seed in count_from(case.seed, step)
    )
    return next(made for made in drawn if _has_new_form(case.law, made.answer))


def _has_new_form(law: str, answer: HiddenTruth) -> bool:
    name, before = NEW_FORM[law]
    return bool(answer.parameters[law][name] != before)


def _beside_channel(case: Case, still: bool) -> MadeCase:
    random = np.random.default_rng((case.seed, 1))
    made, ratio = make_challenge(case.seed, (), case.excitation, case.rig), 1.0
    if case.leaves is None:
        channels = [draw_channel(random, made.recording.force.size) for _ in range(2)]
    else:
        made, *channels, ratio = hide_channel(made, random, case.leaves)
    first, second = channels
    return MadeCase(
        _measured(made.recording, still, first), _measured(made.second, True, second), ratio, False
    )


def _measured(
    record: SimulatedRecord, at_rest: bool, channel: FloatArray | None = None
) -> Measurement:
    return Measurement(record.position, record.force, record.sample_period, at_rest, input2=channel)
