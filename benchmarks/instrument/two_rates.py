"""Ramps and holds, of which a slow recorder writes the holds more seldom.

Contents: drawing such records.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from benchmarks.instrument.case import Case, Truth, generator, log_uniform
from benchmarks.instrument.pressed import Tissue
from benchmarks.ruler.dealt import Record

KINDS = ("plain", "relaxation", "two relaxations")
#: Time between two samples on ramps and on holds [s].
ON_RAMPS, ON_HOLDS = 2.4, 6.0
#: Time of each ramp and hold [s]; there are two ramps to greater depths, one back.
RAMP, HOLD = 120.0, 320.0
#: Damping over stiffness [s]: without any a branch is the same as a force that lags, and no record
#: could tell which.
DAMPING = (2.0, 6.0)
#: Position's and force's noise [m], [N]: of a testing machine with a small load cell.
POSITION_NOISE, NOISE = 5e-9, 5e-3


def make(seed: int) -> Case:
    """Return the record of a seed."""
    random = generator("two_rates", seed)
    kind = KINDS[seed % len(KINDS)]
    deep = log_uniform(random, 6e-4, 2e-3)
    depths = deep * np.array([0.0, 0.6, 0.6, 1.0, 1.0, 0.4, 0.4])
    corners = np.cumsum([0.0, *[RAMP, HOLD] * 3])
    times = np.concatenate(
        [
            np.arange(start, stop, ON_RAMPS if i % 2 == 0 else ON_HOLDS)
            for i, (start, stop) in enumerate(pairwise(corners))
        ]
    )
    stiffness = log_uniform(random, 400.0, 2000.0)
    damping = stiffness * log_uniform(random, *DAMPING)
    tissue = Tissue(stiffness, damping, _branches(kind, random, stiffness))
    position = np.interp(times, corners, depths)
    force = tissue.on_path(corners, depths, times)
    record = Record(
        times,
        position + POSITION_NOISE * random.standard_normal(times.size),
        force + NOISE * random.standard_normal(times.size),
        NOISE,
    )
    truth = Truth(tissue.effects(), tissue.values())
    arguments = {"rig": "rigid_probe", "starts": "at-rest", "constants": {"tip_mass": 0.0}}
    return Case("two_rates", kind, seed, truth, record, None, arguments)


def _branches(
    kind: str, random: np.random.Generator, stiffness: float
) -> tuple[tuple[float, float], ...]:
    slow = (stiffness * log_uniform(random, 1.0, 4.0), log_uniform(random, 0.003, 0.01))
    fast = (stiffness * log_uniform(random, 3.0, 8.0), log_uniform(random, 0.05, 0.15))
    return {"plain": (), "relaxation": (slow,), "two relaxations": (slow, fast)}[kind]
