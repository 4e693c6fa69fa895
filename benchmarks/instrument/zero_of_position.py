"""Pressed tissue whose touch is not at the zero of the position, and is never lost.

Contents: drawing such records.
"""

from __future__ import annotations

import numpy as np

from benchmarks.instrument.case import Case, Truth, generator, log_uniform
from benchmarks.instrument.multisine import drawn
from benchmarks.instrument.pressed import Tissue
from benchmarks.ruler.dealt import Record

COUNT = 2400
#: Time of the record [s].
DURATION = 6.0
KINDS = ("plain", "hertz", "relaxation", "cubic", "hertz and relaxation")
#: The least depth over half the travel.
LEAST = (0.05, 0.5)
#: Zero of the position over the travel.
OFF = (0.1, 5.0)
#: Noise over the rms of the force's change.
NOISE = 0.01


def make(seed: int) -> Case:
    """Return the record of a seed."""
    random = generator("zero_of_position", seed)
    kind = KINDS[seed % len(KINDS)]
    times = np.arange(COUNT) * (DURATION / COUNT)
    travel = log_uniform(random, 1e-3, 6e-3)
    motion = drawn(random, 1.0 / DURATION, 5.0, 0.17 * travel, 1.0 / DURATION)
    lowest = -float(motion(times).min())
    depth = motion.about(lowest + 0.5 * travel * random.uniform(*LEAST))
    tissue = _tissue(kind, random, float(depth(times).max()))
    force = tissue.in_motion(depth, times)
    noise = NOISE * float(np.std(force))
    off = travel * log_uniform(random, *OFF) * random.choice([-1.0, 1.0])
    record = Record(times, depth(times) + off, force + noise * random.standard_normal(COUNT), noise)
    # Of a spring that follows Hooke's law another zero of the force is the same.
    besides = () if tissue.effects() else ("offset",)
    truth = Truth(tissue.effects(), tissue.values(), besides=besides)
    arguments = {"rig": "rigid_probe", "constants": {"tip_mass": 0.0}}
    return Case("zero_of_position", kind, seed, truth, record, None, arguments)


def _tissue(kind: str, random: np.random.Generator, deepest: float) -> Tissue:
    """Return a tissue of which each part is a good share of the force at the greatest depth."""
    stiffness, damping = log_uniform(random, 150.0, 1500.0), log_uniform(random, 1.0, 8.0)
    exponent = random.uniform(1.4, 2.1) if "hertz" in kind else 1.0
    branches = ()
    if "relaxation" in kind:
        branches = ((stiffness * random.uniform(0.5, 1.2), log_uniform(random, 1.0, 20.0)),)
    cubic = stiffness * random.uniform(0.4, 1.5) / deepest**2 if kind == "cubic" else 0.0
    return Tissue(stiffness, damping, branches, exponent, cubic)
