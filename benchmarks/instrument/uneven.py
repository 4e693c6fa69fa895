"""Uneven times, and samples of the force that a cheap converter spoilt.

Contents: drawing such records.
"""

from __future__ import annotations

import numpy as np

from benchmarks.instrument.case import Case, Truth, generator, log_uniform
from benchmarks.instrument.multisine import drawn
from benchmarks.instrument.pressed import Tissue
from benchmarks.ruler.dealt import Record

COUNT = 2000
#: Samples a second, and deviation of each sample's time [s].
RATES, JITTER = (80.0, 1000.0), 2e-4
KINDS = ("plain, flipped signs", "hertz, flipped signs", "plain, spikes", "hertz, spikes")
#: Share of the spoilt samples, and size of a spike over the force's rms.
SPOILT, SPIKE = 0.015, (2.0, 8.0)
NOISE = 6e-3


def make(seed: int) -> Case:
    """Return the record of a seed."""
    random = generator("uneven", seed)
    kind = KINDS[seed % len(KINDS)]
    rate = log_uniform(random, *RATES)
    # Never two at one time: the deviation is normal, and cut at a third of the period.
    late = np.clip(JITTER * random.standard_normal(COUNT), -0.33 / rate, 0.33 / rate)
    times = np.arange(COUNT) / rate + late
    resolution = rate / COUNT
    motion = drawn(random, resolution, 0.03 * rate, 1.5e-3, resolution)
    depth = motion.about(1.1 * float(np.abs(motion(times)).max()))
    exponent = random.uniform(1.4, 2.1) if kind.startswith("hertz") else 1.0
    # The damping's force is a tenth to a half of the spring's at the fastest.
    stiffness = log_uniform(random, 150.0, 600.0)
    damping = stiffness * random.uniform(0.1, 0.5) / (2.0 * np.pi * 0.03 * rate)
    tissue = Tissue(stiffness, damping, exponent=exponent)
    force = tissue.in_motion(depth, times) + NOISE * random.standard_normal(COUNT)
    spoilt = random.choice(COUNT, round(SPOILT * COUNT), replace=False)
    if kind.endswith("signs"):
        force[spoilt] = -force[spoilt]
    else:
        signs = random.choice([-1.0, 1.0], spoilt.size)
        force[spoilt] += np.std(force) * random.uniform(*SPIKE, spoilt.size) * signs
    record = Record(times, depth(times), force, NOISE)
    truth = Truth(tissue.effects(), tissue.values())
    arguments = {"rig": "rigid_probe", "constants": {"tip_mass": 0.0}}
    return Case("uneven", kind, seed, truth, record, None, arguments)
