"""Records of indentation on blocks that finite elements solve.

Contents: a quasi-static table of force against depth becomes a record: pressed in to a preload,
then cycles about it, with a damping that is given.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from benchmarks.protocols.course import Array, Path
from benchmarks.protocols.hidden import log_uniform
from benchmarks.ruler.dealt import Dealt, Record, Truth
from benchmarks.third_party.fem_block import Block, linear_stiffness, neo_hookean_force

LINEAR, NEO_HOOKEAN = "scikit-fem", "felupe"
#: Depths of the quasi-static table; between them the force is a cubic spline.
DEPTHS = 9
#: Rms that the best Kelvin-Voigt fit leaves, over the noise: the noise is made so.
LEAST, MOST = 3.0, 16.0
Random = np.random.Generator


def dealt(count: int, first_seed: int) -> Iterator[Dealt]:
    """Yield ``count`` records of linear blocks, and as many of neo-Hookean ones."""
    for seed in range(first_seed, first_seed + count):
        yield from (deal(seed, neo_hookean) for neo_hookean in (False, True))


def deal(seed: int, neo_hookean: bool) -> Dealt:
    """Return the record of a seed; of a linear block nothing is hidden in it."""
    random = np.random.default_rng([seed, neo_hookean])
    height = random.uniform(10e-3, 30e-3)
    block = Block(
        height * random.uniform(1.0, 2.0), height, height * random.uniform(0.25, 0.6),
        log_uniform(random, 5e3, 5e4), random.uniform(0.3, 0.47),
    )  # fmt: skip
    # Small strains are what the linear block is of; the other one shows what large ones do.
    depth = height * (random.uniform(0.2, 0.35) if neo_hookean else 0.05)
    depths = np.linspace(0.0, 1.2 * depth, DEPTHS)
    if neo_hookean:
        spring = CubicSpline(depths, neo_hookean_force(block, depths))
        stiffness = float(spring(depth)) / depth
    else:
        stiffness = linear_stiffness(block)
        spring = lambda place: stiffness * place  # noqa: E731
    period = log_uniform(random, 0.5, 10.0)
    damping = stiffness * period * log_uniform(random, 0.005, 0.05)
    runs = [
        _run(random, factor * depth, slower * period)
        for factor, slower in ((1.0, 1.0), (random.uniform(0.7, 1.2), random.uniform(0.7, 1.5)))
    ]
    load = stiffness * depth
    left = _left(*runs[0], spring, damping)
    ratio = log_uniform(random, LEAST, MOST) if neo_hookean else 1.0
    noise = left / ratio if neo_hookean else load * log_uniform(random, 1e-3, 5e-3)
    records = []
    for course, times in runs:
        force = spring(course(times)) + damping * course(times, 1)
        force = force + noise * random.standard_normal(times.size)
        records.append(Record(times, course(times), force, noise))
    values = {} if neo_hookean else {"stiffness": stiffness, "damping": damping}
    truth = Truth(
        "neo_hookean" if neo_hookean else "",
        ("exponential_stiffening", "cubic_stiffening", "hertz_contact") if neo_hookean else (),
        ("stiffening",) if neo_hookean else (),
        ratio,
        values,
    )
    arguments = {
        "rig": "rigid_probe",
        "constants": {"tip_mass": (0.0, 0.0)},
        "starts": "at-rest",
    }
    protocol = NEO_HOOKEAN if neo_hookean else LINEAR
    return Dealt(protocol, seed, *records, truth, arguments)


def _run(random: Random, depth: float, period: float) -> tuple[Path, Array]:
    """Press in to a preload, rest there, then go to and fro about it."""
    preload, count = random.uniform(0.4, 0.6) * depth, int(random.integers(3, 7))
    times = np.concatenate([[0.5, 1.5], 2.0 + 0.5 * np.arange(2 * count + 1)]) * period
    turns = np.where(np.arange(2 * count - 1) % 2, 0.1 * depth, depth)
    values = np.concatenate([[0.0, preload, preload], turns, [preload]])
    course = Path(times, values, 0.2 * period)
    rate = random.uniform(60.0, 200.0) / period
    return course, np.arange(int((times[-1] + 0.5 * period) * rate)) / rate


def _left(course: Path, times: Array, spring: Callable[[Array], Array], damping: float) -> float:
    columns = np.stack([course(times), course(times, 1)], axis=-1)
    force = spring(columns[:, 0]) + damping * columns[:, 1]
    fitted = np.linalg.lstsq(columns / np.std(columns, axis=0), force, rcond=None)[0]
    return float(np.std(force - columns / np.std(columns, axis=0) @ fitted))
