"""Records by MuJoCo: clean ones, and eight effects in MuJoCo's own terms.

Contents: drawing a specimen and its drive, how strong the effect is made.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.protocols.catalogue import wave
from benchmarks.protocols.course import Array
from benchmarks.protocols.draft import paper_rig
from benchmarks.protocols.hidden import log_uniform
from benchmarks.protocols.motion import DRIVEN, Rig
from benchmarks.protocols.sensors import Bench, Sensors
from benchmarks.protocols.specimen import Specimen
from benchmarks.protocols.strength import LEAST, MOST, Run, left_by_output_error, sought
from benchmarks.ruler.dealt import Dealt, Record, Truth
from benchmarks.third_party.mujoco_probe import MOST_DAMPING, Probe, simulate

PROTOCOL = "MuJoCo"
#: Of the samples [Hz]: the step divides their period.
RATE = 2000.0
AIMED = (3.0, 0.8 * MOST)
DRAWN = 20
Random = np.random.Generator
Change = Callable[[Probe, float], Probe]


@dataclass(frozen=True)
class _Bench:
    """One specimen under one drive."""

    probe: Probe
    bench: Bench
    runs: tuple[Run, Run]
    force: float
    depth: float
    fastest: float

    @property
    def mass_known(self) -> bool:
        return not self.probe.driven_by_force


@dataclass(frozen=True)
class Hidden:
    """An effect in MuJoCo's terms, and by which names it is rightly told."""

    effects: tuple[str, ...]
    family: str
    change: Callable[[Random, _Bench], Change]
    weakest: float
    strongest: float
    needs_cell: bool = False


def _friction(random: Random, on: _Bench) -> Change:
    return lambda probe, strength: replace(probe, friction=strength * on.force)


def _armature(random: Random, on: _Bench) -> Change:
    return lambda probe, strength: replace(probe, armature=strength * probe.mass)


def _mode(random: Random, on: _Bench) -> Change:
    rate = 2.0 * np.pi * on.fastest * random.uniform(0.5, 1.2)
    ratio = log_uniform(random, 0.03, 0.2)

    def change(probe: Probe, strength: float) -> Probe:
        mass = strength * probe.mass
        return replace(
            probe, mode_mass=mass, mode_stiffness=mass * rate**2,
            mode_damping=2.0 * ratio * mass * rate,
        )  # fmt: skip

    return change


def _branch(random: Random, on: _Bench) -> Change:
    time = log_uniform(random, 0.2 / on.fastest, 4.0 / on.fastest)

    def change(probe: Probe, strength: float) -> Probe:
        stiffness = strength * probe.stiffness
        return replace(probe, branch_stiffness=stiffness, branch_time=time)

    return change


def _wires(random: Random, on: _Bench) -> Change:
    return lambda probe, strength: replace(probe, wires=strength * probe.stiffness)


def _contact(random: Random, on: _Bench) -> Change:
    damping = min(on.probe.damping, MOST_DAMPING)
    return lambda probe, strength: replace(probe, one_sided=True, damping=damping)


def _play(random: Random, on: _Bench) -> Change:
    return lambda probe, strength: replace(probe, play=strength * on.depth)


def _body_motion(random: Random, on: _Bench) -> Change:
    frequency = random.uniform(1.0, 2.0)
    return lambda probe, strength: replace(
        probe, floor_amplitude=strength * on.depth, floor_frequency=frequency
    )


HIDDEN = {
    "friction": Hidden(("coulomb_friction",), "friction", _friction, 1e-3, 0.3),
    "armature": Hidden(("added_mass",), "inertia", _armature, 1e-2, 5.0, needs_cell=True),
    "mode": Hidden(("structural_mode",), "inertia", _mode, 1e-2, 2.0),
    "branch": Hidden(("standard_linear_solid",), "relaxation", _branch, 1e-2, 3.0),
    "wires": Hidden(("cubic_stiffening",), "stiffening", _wires, 1e-2, 100.0),
    "contact": Hidden(("contact_loss",), "contact", _contact, 1.0, 1.0, needs_cell=True),
    "play": Hidden(("backlash",), "lost motion", _play, 1e-4, 0.2, needs_cell=True),
    "body_motion": Hidden(("tissue_motion",), "body motion", _body_motion, 1e-4, 0.3),
}
"""Effects in MuJoCo's terms, by name."""


def dealt(count: int, first_seed: int) -> Iterator[Dealt]:
    """Yield ``count`` records of each of the eight effects, and twice as many clean ones."""
    for seed in range(first_seed, first_seed + 2 * count):
        yield deal(seed, "")
    for name in HIDDEN:
        for seed in range(first_seed, first_seed + count):
            yield deal(seed, name)


def deal(seed: int, name: str) -> Dealt:
    """Return the record of a seed with an effect hidden, or none where the name is empty.

    Raises
    ------
    ValueError
        If no drive that was drawn shows the effect.
    """
    random = np.random.default_rng([seed, *name.encode()])
    if not name:
        return _written(seed, random, _drawn(random, force=random.random() < 0.3), "", 1.0)
    hidden = HIDDEN[name]
    for _ in range(DRAWN):
        drawn = _drawn(
            random, force=not hidden.needs_cell and random.random() < 0.3, in_air=name == "contact"
        )
        change = hidden.change(random, drawn)

        def ratio(strength: float, change: Change = change, drawn: _Bench = drawn) -> float:
            return _left(change(drawn.probe, strength), drawn)

        aimed = log_uniform(random, *AIMED)
        strength, found = sought(ratio, aimed, hidden.weakest, hidden.strongest)
        if found >= LEAST and (found <= MOST or name == "contact"):
            drawn = replace(drawn, probe=change(drawn.probe, strength))
            return _written(seed, random, drawn, name, found)
    raise ValueError(f"MuJoCo, seed {seed}: no drive shows {name}")


def _drawn(random: Random, force: bool, in_air: bool = False) -> _Bench:
    rig, mass = paper_rig(random)
    high, depth = log_uniform(random, 5.0, 30.0), log_uniform(random, 0.8e-3, 1.5e-3)
    if force:
        rig = Rig(DRIVEN)
    stiffness = log_uniform(random, 200.0, 2000.0)
    damping = stiffness * log_uniform(random, 0.03, 0.3) / high
    load = stiffness * depth
    size, preload = (load, 0.0) if force else (depth, random.choice([0.0, 1.2 * depth]))
    preload = 0.0 if in_air else preload
    runs = []
    for factor, faster in ((1.0, 1.0), (random.uniform(0.6, 1.2), random.uniform(0.7, 1.4))):
        kind = random.choice(["sweep", "noise"])
        lasts = min(25.0 / high, 2.0)
        course = wave(random, kind, 0.1 * high, faster * high, lasts, factor * size, preload)
        runs.append(Run(course, np.arange(int(lasts * RATE)) / RATE, 0.0))
    share = log_uniform(random, 1e-3, 5e-3)
    noise = Sensors(0.0, share * depth) if force else Sensors(share * load)
    specimen = Specimen(stiffness, damping, mass)
    probe = Probe(stiffness, damping, mass, rig.cell_stiffness, rig.cell_damping)
    return _Bench(probe, Bench(rig, specimen, noise), (runs[0], runs[1]), load, depth, high)


def _output(probe: Probe, run: Run) -> Array:
    place, force = simulate(probe, run.course, run.times)
    return place if probe.driven_by_force else force


def _left(probe: Probe, on: _Bench) -> float:
    run = on.runs[0]
    target = _output(probe, run)
    rms = left_by_output_error(on.bench, run, run.times, target, on.mass_known)
    return rms / on.bench.noise(run.period, np.zeros(2))


def _written(seed: int, random: Random, on: _Bench, name: str, ratio: float) -> Dealt:
    sensors, records = on.bench.sensors, []
    for run in on.runs:
        output = _output(on.probe, run)
        white = random.standard_normal(output.size)
        if on.probe.driven_by_force:
            columns = (output + sensors.position_noise * white, run.course(run.times))
        else:
            columns = (run.course(run.times), output + sensors.force_noise * white)
        records.append(Record(run.times, *columns, on.bench.noise(run.period, np.zeros(2))))
    specimen, rig = on.bench.specimen, on.bench.rig
    values = {
        "stiffness": specimen.stiffness,
        "damping": specimen.damping,
        "tip_mass": specimen.mass,
        "contact_position": 0.0,
    }
    if not on.probe.driven_by_force:
        values |= {"load_cell_stiffness": rig.cell_stiffness}
    hidden = HIDDEN.get(name)
    truth = Truth(
        name,
        hidden.effects if hidden else (),
        (hidden.family,) if hidden else (),
        ratio,
        values,
    )
    return Dealt(PROTOCOL, seed, *records, truth, {"rig": rig.name, "starts": "at-rest"})
