"""Deals records: a protocol, a seed, and whether something is hidden.

Contents: from a draft to records and their truth.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any
from zlib import crc32

import numpy as np

from benchmarks.protocols.catalogue import PROTOCOLS
from benchmarks.protocols.draft import Draft
from benchmarks.protocols.hidden import HIDDEN, Random, log_uniform
from benchmarks.protocols.motion import COMPLIANT
from benchmarks.protocols.sensors import Bench
from benchmarks.protocols.strength import MOST, Run, strengthened
from benchmarks.ruler.dealt import Dealt, Record, Truth

#: The residual of the best Kelvin-Voigt fit that is aimed at, over the noise.
AIMED = (3.0, 0.8 * MOST)
#: How often a part is drawn anew that the protocol does not show.
DRAWN = 30


def dealt(
    count: int, first_seed: int, protocols: Sequence[str] = tuple(PROTOCOLS)
) -> Iterator[Dealt]:
    """Yield ``count`` records of each protocol with something hidden, and as many without."""
    for protocol in protocols:
        for seed in range(first_seed, first_seed + count):
            yield from (
                deal(protocol, seed, hide)
                for hide in (False, True)[not PROTOCOLS[protocol].clean :]
            )


def deal(protocol: str, seed: int, hide: bool) -> Dealt:
    """Return the record of a protocol and a seed; the same for the same.

    Parameters
    ----------
    protocol : str
        A name in ``PROTOCOLS``.
    seed : int
        Of everything that is drawn.
    hide : bool
        Whether something is hidden.

    Raises
    ------
    ValueError
        If the protocol shows nothing that may be hidden, or has no record without.
    """
    random = np.random.default_rng([crc32(protocol.encode()), seed, hide])
    if not hide:
        if not PROTOCOLS[protocol].clean:
            raise ValueError(f"{protocol}: every record hides something")
        return _written(protocol, seed, random, PROTOCOLS[protocol].draw(random), None)
    return _hidden(protocol, seed, random)


def _hidden(protocol: str, seed: int, random: Random) -> Dealt:
    names = PROTOCOLS[protocol].hides
    for attempt in range(DRAWN):
        # By turns, so that each comes equally often; another where this one does not show.
        name = names[(seed + attempt) % len(names)]
        draft = PROTOCOLS[protocol].draw(random)
        change = HIDDEN[name].drawn(random, draft.extent)
        found = strengthened(
            draft.bench, draft.first, HIDDEN[name], change, log_uniform(random, *AIMED),
            draft.mass_known,
        )  # fmt: skip
        if found:
            return _written(protocol, seed, random, draft, (name, *found))
    raise ValueError(f"{protocol}, seed {seed}: nothing that may be hidden shows")


def _written(
    protocol: str, seed: int, random: Random, draft: Draft, hidden: tuple[str, Bench, float] | None
) -> Dealt:
    name, bench, ratio = hidden or ("", draft.bench, 1.0)
    first, second = (_record(bench, run, random) for run in (draft.first, draft.second))
    effects = HIDDEN[name].effects if name else ()
    families = (HIDDEN[name].family,) if name else ()
    if name and protocol == "approach_on_drift":
        effects, families = (*effects, "force_drift", "force_bias"), (*families, "offset")
    arguments: dict[str, Any] = {"rig": bench.rig.name, "constants": dict(draft.constants)}
    if draft.at_rest:
        arguments["starts"] = "at-rest"
    truth = Truth(name, effects, families, ratio, _values(bench))
    return Dealt(protocol, seed, first, second, truth, arguments)


def _record(bench: Bench, run: Run, random: Random) -> Record:
    read = bench.read(run.course, run.times, run.begin, random)
    return Record(run.times, read.position, read.force, bench.noise(run.period, read.position))


def _values(bench: Bench) -> dict[str, float]:
    specimen, rig = bench.specimen, bench.rig
    values = {
        "stiffness": specimen.stiffness,
        "damping": specimen.damping,
        "tip_mass": specimen.mass,
        "contact_position": specimen.touch,
    }
    if rig.name == COMPLIANT:
        values |= {
            "load_cell_stiffness": rig.cell_stiffness,
            "load_cell_damping": rig.cell_damping,
        }
    return values
