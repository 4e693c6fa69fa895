"""Experiments of kinds that users made: instruments, laws, readings that once asked for a repair.

Contents: which specimen, course, channels and noise each has, and which answer is right.

They are made here, and no files are read: so everybody has the same ones, and the truth stands
beside each. ``right`` of each lists the sets of effects that are a right answer, an empty one for
an adequate model; where there is a second record, the last model must also carry over to it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any
from zlib import crc32

import numpy as np

from benchmarks.golden.specimens import Array, driven, held, points, pressed, rubbing
from benchmarks.ruler.dealt import Record

PLAIN: frozenset[str] = frozenset()
RIGID = {"rig": "rigid_probe"}
MASSLESS = {"rig": "rigid_probe", "constants": {"tip_mass": 0.0}}
FROM_REST = {**MASSLESS, "starts": "at-rest"}
DRIVEN = {"rig": "force_driven"}
#: White noise of a load cell [N].
NOISE = 4e-3


@dataclass(frozen=True)
class Experiment:
    """A record, how its user asks, and the right answers.

    Attributes
    ----------
    first, second : Record
        To be diagnosed, and to validate, if there is one.
    arguments : mapping
        Of ``tp.diagnose``.
    right : tuple of frozenset of str
        Right sets of effects; none where no law of the library is the true one, and the second
        record alone decides.
    values : mapping of str to float
        True values of the last model [SI].
    """

    first: Record
    second: Record | None = None
    arguments: Mapping[str, Any] = field(default_factory=dict)
    right: tuple[frozenset[str], ...] = (PLAIN,)
    values: Mapping[str, float] = field(default_factory=dict)


def _random(name: str) -> np.random.Generator:
    return np.random.default_rng(crc32(name.encode()))


def _of(*effects: str) -> tuple[frozenset[str], ...]:
    return (frozenset(effects),)


def _read(random, made, noise=NOISE) -> Record:
    """Return the record of a pressed specimen; the load cell has white noise."""
    times, depth, force = made
    return Record(times, depth, force + noise * random.standard_normal(times.size), noise)


def _followed(random, force: Array, position: Array, period: float, noise: float) -> Record:
    """Return the record of a driven specimen; what reads the position has white noise."""
    times = period * np.arange(force.size)
    return Record(times, position + noise * random.standard_normal(times.size), force, noise)


def _palpated(fine: Array) -> Array:
    """Return an uneven palpation between 0.2 and 4 mm."""
    wave = np.sin(2.0 * np.pi * 1.1 * fine) + 0.6 * np.sin(2.0 * np.pi * 2.7 * fine + 1.0)
    return 2.1e-3 + 1.1e-3 * wave * np.tanh(4.0 * fine)


def _band(random, count: int, period: float, low: float, high: float) -> Array:
    """Return a random force of rms 1 in a band of frequencies [Hz], from nothing to nothing."""
    spectrum = np.fft.rfft(random.standard_normal(count))
    frequencies = np.fft.rfftfreq(count, period)
    wave = np.fft.irfft(spectrum * ((frequencies > low) & (frequencies < high)), count)
    window = np.minimum(1.0, np.minimum(np.arange(count), np.arange(count)[::-1]) / (0.03 * count))
    return window * wave / np.std(wave)


def _linear(stiffness: float, damping: float):
    return lambda depth, speed: stiffness * depth + damping * speed


def _hertz(factor: float, damping: float, touch: float = 0.0):
    return lambda depth, speed: np.where(
        depth > touch, factor * np.maximum(depth - touch, 0.0) ** 1.5 + damping * speed, 0.0
    )


def zero_of_the_position(random) -> Experiment:
    """Put the position's zero 13 mm from the touch."""
    times, depth, force = pressed(_palpated, 2000, 2e-3, _linear(420.0, 1.8))
    record = _read(random, (times, depth + 13e-3, force))
    # Of a linear specimen the zero of the force is the same thing.
    return Experiment(
        record, arguments=RIGID, right=(PLAIN, *_of("force_bias")),
        values={"stiffness": 420.0, "damping": 1.8},
    )  # fmt: skip


def zero_of_the_position_under_hertz(random) -> Experiment:
    """Do the same with a ball on a half-space."""
    times, depth, force = pressed(_palpated, 2000, 2e-3, _hertz(9500.0, 1.8))
    record = _read(random, (times, depth + 13e-3, force))
    return Experiment(record, arguments=RIGID, right=_of("hertz_contact"))


def _set_to_zero(random, branches, lower: float) -> Record:
    """Return a palpation with a gap of 0.3 s, after which the force's zero is lower."""
    made = pressed(_palpated, 2000, 2e-3, _linear(320.0, 6.0), branches)
    record = _read(random, made)
    kept = (record.time < 2.0) | (record.time > 2.3)
    force = record.force - lower * (record.time > 2.0)
    return Record(record.time[kept], record.position[kept], force[kept], record.noise)


def zero_of_the_force_set_anew(random) -> Experiment:
    """Lower the force's zero by 1 N in a silence of 0.3 s."""
    record = _set_to_zero(random, (), 1.0)
    return Experiment(
        record, arguments=MASSLESS, right=(PLAIN, *_of("force_bias")), values={"stiffness": 320.0}
    )


def zero_of_the_force_set_anew_beside_relaxation(random) -> Experiment:
    """Lower it by 0.3 N, of a specimen that relaxes."""
    record = _set_to_zero(random, [(250.0, 2.0)], 0.3)
    sls = "standard_linear_solid"
    return Experiment(record, arguments=MASSLESS, right=(*_of(sls), *_of(sls, "force_bias")))


def flipped_signs(random) -> Experiment:
    """Flip the sign of 1.5 % of the forces, as an amplifier does, at uneven times."""
    times, depth, force = pressed(_palpated, 4000, 1e-3, _linear(320.0, 6.0))
    picked = 2 * np.arange(1999) + random.integers(0, 2, 1999)
    flipped = np.where(random.random(picked.size) < 0.015, -1.0, 1.0)
    record = _read(random, (times[picked], depth[picked], force[picked]), 6e-3)
    record = Record(record.time, record.position, flipped * record.force, record.noise)
    return Experiment(record, arguments=MASSLESS, values={"stiffness": 320.0, "damping": 6.0})


def uneven_clock(random) -> Experiment:
    """Read a load cell at 80 Hz in whole milliseconds."""
    times, depth, force = pressed(_palpated, 12000, 1e-3, _linear(300.0, 8.0))
    picked = np.round(12.5 * np.arange(950)).astype(int)
    record = _read(random, (times[picked], depth[picked], force[picked]))
    return Experiment(record, arguments=MASSLESS, values={"stiffness": 300.0, "damping": 8.0})


def stale_force(random) -> Experiment:
    """Repeat each force five times: it is read faster than it is measured."""
    times, depth, force = pressed(_palpated, 4000, 1e-3, _linear(300.0, 4.0))
    record = _read(random, (times, depth, force))
    stale = np.repeat(record.force[::5], 5)[: times.size]
    record = Record(times, depth, stale, record.noise)
    return Experiment(record, arguments=MASSLESS, values={"stiffness": 300.0})


def two_rates(random) -> Experiment:
    """Take samples every 2.4 s on ramps and every 6 s on holds, of two times of relaxation."""
    course = points([0.0, 60.0, 120.0, 700.0, 760.0, 1400.0], [0.0, 0.0, 1e-3, 1e-3, 2e-3, 2e-3], 4)
    times, depth, force = pressed(
        course, 1200, 1.2, _linear(684.0, 0.0), [(12800.0, 0.117), (6700.0, 0.0022)]
    )
    ramp = (times < 125.0) | ((times > 695.0) & (times < 765.0))
    picked = np.flatnonzero(np.arange(times.size) % np.where(ramp, 2, 5) == 0)
    record = _read(random, (times[picked], depth[picked], force[picked]), 5e-3)
    return Experiment(record, arguments=FROM_REST, right=_of("generalized_maxwell"))


def relaxation_beside_a_palpation(random) -> Experiment:
    """Relax in a shorter time than the motion's: a lag of the force looks alike."""
    made = pressed(_palpated, 2000, 2e-3, _linear(420.0, 0.6), [(300.0, 20.0)])
    return Experiment(_read(random, made), arguments=MASSLESS, right=_of("standard_linear_solid"))


def hertz_that_relaxes(random) -> Experiment:
    """Press a ball on a half-space that relaxes."""
    made = pressed(_palpated, 2000, 2e-3, _hertz(9500.0, 0.6), [(300.0, 20.0)])
    return Experiment(
        _read(random, made), arguments=RIGID, right=_of("hertz_contact", "standard_linear_solid")
    )


def touch_on_the_way(random) -> Experiment:
    """Press a ball that touches at 1.8 mm."""
    course = points([0.0, 0.5, 2.0, 3.0, 4.5], [0.0, 0.0, 5e-3, 5e-3, 0.0], 0.03)
    made = pressed(course, 1800, 2.5e-3, _hertz(4000.0, 0.0, 1.8e-3))
    return Experiment(
        _read(random, made), arguments=MASSLESS,
        right=(*_of("hertz_contact"), *_of("contact_loss", "hertz_contact")),
    )  # fmt: skip


def relaxation_from_the_first_row(random) -> Experiment:
    """Ramp for 0.1 s from the beginning of the record, and hold."""
    course = points([0.0, 0.02, 0.12, 40.0], [0.0, 0.0, 2e-3, 2e-3], 0.003)
    made = pressed(course, 1500, 2e-2, _linear(100.0, 0.0), [(300.0, 0.5)])
    return Experiment(
        _read(random, made, 1e-3), arguments=FROM_REST, right=_of("standard_linear_solid")
    )


def ramp_and_hold_of_a_heavy_tip(random) -> Experiment:
    """Ramp and hold by a robot, with a tip whose mass nobody has told."""
    course = points([0.0, 1.0, 2.0, 40.0], [0.0, 0.0, 3e-3, 3e-3], 0.1)
    times, depth, force = pressed(course, 3000, 1e-2, _linear(350.0, 2.0), [(250.0, 0.4)])
    inertia = 0.1 * np.gradient(np.gradient(depth, 1e-2), 1e-2)
    record = _read(random, (times, depth, force + inertia), 1e-2)
    return Experiment(record, arguments=RIGID, right=_of("standard_linear_solid"))


def triangles_of_what_stiffens_and_relaxes(random) -> Experiment:
    """Cycle what stiffens exponentially and relaxes."""
    turns = np.arange(11.0)

    def record(depth: float, half: float) -> Record:
        course = points(half * turns + 0.5, depth * (turns % 2), 0.02 * half)
        made = pressed(
            course, 1600, half / 150,
            lambda x, v: 100.0 * x + 0.25 * np.expm1(x / 1.1e-3) + 2.0 * v, [(200.0, 1.25)],
        )  # fmt: skip
        return _read(random, made, 2e-2)

    right = _of("exponential_stiffening", "standard_linear_solid")
    return Experiment(record(3e-3, 1.0), record(2.5e-3, 0.7), MASSLESS, right)


def half_a_sine(random) -> Experiment:
    """Take a hundred samples of one press."""
    made = pressed(lambda t: 2e-3 * np.sin(np.pi * t) ** 2, 101, 1e-2, _linear(200.0, 30.0))
    return Experiment(
        _read(random, made, 2e-3), arguments=MASSLESS, values={"stiffness": 200.0, "damping": 30.0}
    )


def _staircase(law, branches, random, scale: float, stretch=lambda depth: depth) -> Record:
    """Return steps of depth and rests, at 10 Hz."""
    times = [0.0, 5.0, 6.0, 60.0, 61.0, 110.0, 112.0, 150.0, 151.0, 190.0]
    depths = scale * np.array([0.0, 0.0, 2.0, 2.0, 3.5, 3.5, 1.5, 1.5, 3.0, 3.0]) * 1e-3
    course = points(times, depths, 0.2)
    return _read(random, pressed(course, 1880, 0.1, law, branches, stretch))


def three_branches(random) -> Experiment:
    """Relax in three times from a second to a minute."""
    branches = [(900.0, 1 / 55.0), (700.0, 1 / 6.0), (900.0, 1 / 1.2)]
    first, second = (
        _staircase(_linear(1900.0, 0.0), branches, random, scale) for scale in (1.0, 0.8)
    )
    return Experiment(first, second, FROM_REST, ())


def toe_that_relaxes(random) -> Experiment:
    """Relax the whole force of a power law (Y. C. Fung, Biomechanics (1993), section 7.6)."""

    def elastic(depth):
        return 1.4e5 * np.maximum(depth, 0.0) ** 1.5

    branches = [(0.22, 1 / 60.0), (0.18, 1 / 6.0), (0.3, 1 / 0.8)]
    first, second = (
        _staircase(lambda x, v: 0.5 * elastic(x), branches, random, scale, elastic)
        for scale in (1.0, 0.8)
    )
    return Experiment(first, second, FROM_REST, ())


def softening(random) -> Experiment:
    """Press what yields more the deeper it is: F = 500 x / (1 + x / 4 mm) + 5 x'."""

    def record(scale: float) -> Record:
        made = pressed(
            lambda t: scale * _palpated(t), 2000, 2e-3,
            lambda x, v: 500.0 * x / (1.0 + x / 4e-3) + 5.0 * v,
        )  # fmt: skip
        return _read(random, made)

    return Experiment(record(1.0), record(0.8), MASSLESS, ())


def creep(random) -> Experiment:
    """Load what relaxes by a constant force that comes on in a second, with a tip of 0.2 kg."""
    period = 1e-2
    force = points([0.0, 1.0, 2.0, 30.0], [0.0, 0.0, 1.0, 1.0], 0.1)(period * np.arange(2500))

    def law(now):
        return 400.0 * now[0] + 8.0 * now[1] + now[2], 300.0 * now[1] - now[2] / 3.0

    position = driven(force, period, 0.2, law, (0.0, 0.0, 0.0))
    record = _followed(random, force, position, period, 5e-6)
    return Experiment(record, arguments=DRIVEN, right=_of("standard_linear_solid"))


def converter_that_holds(random) -> Experiment:
    """Drive by steps of a force that a converter holds from sample to sample."""
    force = np.repeat(random.choice([-1.0, 0.0, 0.5, 1.0], 40), 50)
    position = held(force, 1e-3, 0.05, 1.0, 200.0)
    record = _followed(random, force, position, 1e-3, 1e-6)
    truth = {"tip_mass": 0.05, "damping": 1.0, "stiffness": 200.0}
    return Experiment(record, arguments={**DRIVEN, "starts": "at-rest"}, values=truth)


def drive_that_rubs(random) -> Experiment:
    """Drive a mass without a spring that rubs."""
    times = 2e-2 * np.arange(700)
    force = np.select(
        [times < 4.0, times < 6.0, times < 9.0], [0.7 * times, 0.0, 3 - 0.2 * times], -1.1
    )
    position = rubbing(force, 2e-2, 0.3, 2.0, 0.6)
    record = _followed(random, force, position, 2e-2, 2e-5)
    free = {"stiffness": 0.0, "contact_position": 0.0}
    return Experiment(
        record, arguments={**DRIVEN, "starts": "at-rest", "constants": free},
        right=_of("coulomb_friction"), values={"tip_mass": 0.3, "damping": 2.0},
    )  # fmt: skip


def _stiffening(stiffness: float, damping: float, cubic: float):
    return lambda now: (stiffness * now[0] + damping * now[1] + cubic * now[0] ** 3,)


def resonance_of_ten_samples(random) -> Experiment:
    """Drive a sharp resonance at 100 Hz of what stiffens, read ten times a period."""

    def record(size: float) -> Record:
        force = size * _band(random, 3000, 1e-3, 20.0, 140.0)
        position = driven(force, 1e-3, 0.01, _stiffening(3947.84, 0.251327, 3.15028e10))
        return _followed(random, force, position, 1e-3, 2e-8)

    asked = {**DRIVEN, "starts": "at-rest", "constants": {"contact_position": (0.0, 1e-9)}}
    return Experiment(record(0.05), record(0.035), asked, _of("cubic_stiffening"))


def broad_drive_of_what_stiffens(random) -> Experiment:
    """Drive by a periodic force up to a sixth of the rate of sampling."""

    def record(size: float) -> Record:
        period, lines = 1.0 / 600.0, np.arange(5.0, 90.0, 0.5)
        phases = random.uniform(0.0, 2.0 * np.pi, lines.size)
        times = period * np.arange(2400)
        force = np.sin(2.0 * np.pi * np.outer(times, lines) + phases).sum(axis=1)
        force *= size / np.std(force)
        position = driven(force, period, 0.02, _stiffening(4200.0, 0.8, 9e7))
        return _followed(random, force[1200:], position[1200:], period, 2e-6)

    return Experiment(record(1.6), record(1.1), DRIVEN, _of("cubic_stiffening"))


def begun_in_motion(random) -> Experiment:
    """Begin in motion, with a light oscillator that is read nine times a period."""

    def record(size: float) -> Record:
        period = 1.638e-3
        force = size * _band(random, 3000, period, 5.0, 110.0)
        law = _stiffening(0.99024, 2.2013e-4, 3.96)
        position = driven(force, period, 5.377e-6, law, (0.03, -20.0))
        return _followed(random, force, position, period, 2e-4)

    return Experiment(record(0.02), record(0.015), DRIVEN, _of("cubic_stiffening"))


def hysteresis_of_another_law(random) -> Experiment:
    """Drive Bouc and Wen's hysteresis of a shape that the library has not."""

    def law(now):
        _, speed, force = now
        shaped = 600.0 * (0.8 * abs(speed) * force - 1.1 * speed * abs(force))
        return 3000.0 * now[0] + 0.8 * speed + force, 2000.0 * speed - shaped

    def record(size: float) -> Record:
        force = size * _band(random, 3000, 2e-3, 1.0, 40.0)
        position = driven(force, 2e-3, 0.02, law, (0.0, 0.0, 0.0))
        return _followed(random, force, position, 2e-3, 1e-6)

    return Experiment(record(5.0), record(4.0), {**DRIVEN, "starts": "moving"}, ())


_MADE: tuple[Callable[[np.random.Generator], Experiment], ...] = (
    zero_of_the_position,
    zero_of_the_position_under_hertz,
    zero_of_the_force_set_anew,
    zero_of_the_force_set_anew_beside_relaxation,
    flipped_signs,
    uneven_clock,
    stale_force,
    two_rates,
    relaxation_beside_a_palpation,
    hertz_that_relaxes,
    touch_on_the_way,
    relaxation_from_the_first_row,
    ramp_and_hold_of_a_heavy_tip,
    triangles_of_what_stiffens_and_relaxes,
    half_a_sine,
    three_branches,
    toe_that_relaxes,
    softening,
    creep,
    converter_that_holds,
    drive_that_rubs,
    resonance_of_ten_samples,
    broad_drive_of_what_stiffens,
    begun_in_motion,
    hysteresis_of_another_law,
)
#: Every experiment by its name; its noise is drawn by that.
EXPERIMENTS: dict[str, Callable[[np.random.Generator], Experiment]] = {
    make.__name__: make for make in _MADE
}


def experiment(name: str) -> Experiment:
    """Return an experiment; the same for the same name."""
    return EXPERIMENTS[name](_random(name))
