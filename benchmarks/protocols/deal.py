"""Deals records: a protocol, a seed, and whether something is hidden.

What belongs here: ``deal``, and what a dealt record consists of. What does not: judging what is
said of it (``marks``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any
from zlib import crc32

import numpy as np

from benchmarks.protocols.catalogue import PROTOCOLS
from benchmarks.protocols.course import Array
from benchmarks.protocols.draft import Draft
from benchmarks.protocols.hidden import HIDDEN, Random, log_uniform
from benchmarks.protocols.motion import COMPLIANT
from benchmarks.protocols.sensors import Bench
from benchmarks.protocols.strength import MOST, Run, strengthened

#: The residual of the best Kelvin-Voigt fit that is aimed at, over the noise.
AIMED = (3.0, 0.8 * MOST)
#: How often a part is drawn anew that the protocol does not show.
DRAWN = 30


@dataclass(frozen=True)
class Record:
    """What a laboratory wrote down.

    Attributes
    ----------
    time, position, force : array, shape (n,)
        [s], [m], and [N], positive in compression.
    noise : float
        Rms that the noise of both channels leaves to the true model, in the unit of what the rig
        predicts: [N], of ``force_driven`` [m].
    """

    time: Array
    position: Array
    force: Array
    noise: float

    def columns(self) -> dict[str, Array]:
        """Return it as ``tp.read`` takes arrays by name."""
        return {"t": self.time, "u": self.position, "F": self.force}


@dataclass(frozen=True)
class Truth:
    """What is in a record.

    Attributes
    ----------
    hidden : str
        A name in ``HIDDEN``; empty for none.
    effects, families : tuples of str
        By which names, and of which families, it is rightly told.
    ratio : float
        Rms that the best Kelvin-Voigt fit leaves, over the noise; 1 for none.
    values : mapping
        True values by the names of the library's models [SI]: of the base model, where nothing is
        hidden those that must lie within their intervals.
    """

    hidden: str
    effects: tuple[str, ...]
    families: tuple[str, ...]
    ratio: float
    values: Mapping[str, float]


@dataclass(frozen=True)
class Dealt:
    """A record, a second one of the same specimen, how a user would ask, and the truth."""

    protocol: str
    seed: int
    first: Record
    second: Record
    truth: Truth
    arguments: Mapping[str, Any] = field(default_factory=dict)


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
