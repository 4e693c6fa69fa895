"""Two parts with a silence between, after which the force may have another zero.

Contents: drawing such records.
"""

from __future__ import annotations

import numpy as np

from benchmarks.instrument.case import Case, Truth, generator, log_uniform
from benchmarks.instrument.multisine import drawn
from benchmarks.instrument.pressed import Tissue
from benchmarks.ruler.dealt import Record

COUNT, RATE = 2000, 250.0
#: The silence [s].
SILENCE = 0.3
KINDS = ("plain, other zero", "relaxation, other zero", "plain", "relaxation")
#: The other zero [N].
OFF = (0.05, 1.0)
#: Rates of the branch [1/s]: from one that is just seen in the 8 s of the record on.
RATES = (0.3, 20.0)
NOISE = 4e-3


def make(seed: int) -> Case:
    """Return the record of a seed."""
    random = generator("rezeroed", seed)
    kind = KINDS[seed % len(KINDS)]
    times = np.arange(COUNT) / RATE
    motion = drawn(random, 0.125, 6.0, 1e-3 * random.uniform(0.6, 1.5), 0.125)
    depth = motion.about(1.1 * float(np.abs(motion(times)).max()))
    stiffness = log_uniform(random, 150.0, 600.0)
    branches = ()
    if kind.startswith("relaxation"):
        branches = ((stiffness * random.uniform(0.4, 1.2), log_uniform(random, *RATES)),)
    tissue = Tissue(stiffness, log_uniform(random, 3.0, 8.0), branches)
    silent = random.uniform(0.35, 0.65) * times[-1]
    force = tissue.in_motion(depth, times) + NOISE * random.standard_normal(COUNT)
    if kind.endswith("other zero"):
        off = log_uniform(random, *OFF) * random.choice([-1.0, 1.0])
        force = force + off * (times > silent)
    heard = (times < silent) | (times > silent + SILENCE)
    record = Record(times[heard], depth(times)[heard], force[heard], NOISE)
    truth = Truth(tissue.effects(), tissue.values(), besides=("offset",))
    arguments = {"rig": "rigid_probe", "constants": {"tip_mass": 0.0}}
    return Case("rezeroed", kind, seed, truth, record, None, arguments)
