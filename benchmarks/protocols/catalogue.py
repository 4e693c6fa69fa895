"""The protocols of laboratories.

Contents: which course, how often sampled, what may be hidden.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.protocols.course import Course, Held, Path, Smooth, Straight
from benchmarks.protocols.draft import (
    CANTILEVER,
    PRESS,
    TISSUE,
    Draft,
    Scale,
    drawn_bench,
    drawn_mass,
    drawn_specimen,
    paper_rig,
    sampled,
)
from benchmarks.protocols.hidden import Extent, Random, log_uniform
from benchmarks.protocols.motion import DRIVEN, RIGID, Rig
from benchmarks.protocols.specimen import Specimen
from benchmarks.protocols.strength import Run

RELAXATION = ("branch", "two_branches", "power_law")
CURVED = ("exponential", "cubic")
#: What a motion to and fro shows of a tip that follows it.
MOVING = (*RELAXATION, *CURVED, "dry_friction", "bias", "drift", "delay", "lag")
ON_LOAD_CELL = (*RELAXATION, *CURVED, "dry_friction", "mass", "bias", "drift", "delay", "lag")
DRIVEN_BY_FORCE = (*RELAXATION, *CURVED, "dry_friction", "bias", "drift")


@dataclass(frozen=True)
class Protocol:
    """One kind of experiment.

    Attributes
    ----------
    draw : callable
        Of a random generator; returns a ``Draft``.
    hides : tuple of str
        What may be hidden in it.
    clean : bool
        Whether a record with nothing hidden is Kelvin-Voigt: one that begins in the air is not.
    """

    draw: Callable[[Random], Draft]
    hides: tuple[str, ...]
    clean: bool = True


def _cycles(
    depth: float, period: float, count: int, rising: float, rest: float, rounding: float
) -> Path:
    """Press to a depth and back ``count`` times, ``rising`` of each period forwards."""
    begins = rest + period * np.arange(count)
    times = np.stack([begins, begins + rising * period], axis=-1).ravel()
    values = np.tile([0.0, depth], count)
    end = rest + period * count
    return Path([*times, end], [*values, 0.0], rounding)


def _ramp_and_hold(random: Random, scale: Scale, at_once: bool = False) -> Draft:
    """Press to a depth and stay there."""
    hold, depth = log_uniform(random, 5.0, 300.0), log_uniform(random, *scale.depth)
    if at_once:
        ramp = log_uniform(random, 1e-3, 2e-2)
        rate = random.uniform(0.2, 0.9) / ramp
        rate = max(min(rate, 2e4 / hold), 200.0 / hold)
    else:
        ramp = log_uniform(random, 0.02, 2.0)
        rate = max(random.uniform(6.0, 60.0) / ramp, 200.0 / hold)
        hold = min(hold, 2e4 / rate)
    rest = random.choice([0.0, log_uniform(random, 0.3, 5.0)])
    # At rest up to the first sample: a ramp that begins with it, begins there.
    rest += 0.0 if rest else 0.5 * 0.3 * ramp
    specimen = drawn_specimen(random, scale, max(ramp, 1.0 / rate))
    runs = []
    for factor, faster in ((1.0, 1.0), (random.uniform(0.5, 1.5), random.uniform(0.5, 2.0))):
        lasts = ramp / faster
        course = Path([rest, rest + lasts], [0.0, factor * depth], 0.3 * lasts)
        runs.append(Run(course, sampled(random, rest + ramp + hold, rate), 0.0))
    extent = Extent(depth, hold, max(2.0 * ramp, 3.0 / rate), 0.5 * hold)
    return _rigid(random, specimen, runs, extent)


def _rigid(random: Random, specimen: Specimen, runs: Sequence[Run], extent: Extent) -> Draft:
    """Put the specimen under a probe that follows its drive; its mass known, or not."""
    bench = drawn_bench(random, Rig(RIGID), specimen, runs[0], extent.depth)
    known = specimen.mass == 0.0 or random.random() < 0.5
    constants = {"tip_mass": (specimen.mass, 0.0)} if known else {}
    return Draft(bench, *runs, extent, constants, known)


def _cyclic(random: Random, scale: Scale, sawtooth: bool) -> Draft:
    """Press and let go at a steady rate, at several rates one after another."""
    depth, period = log_uniform(random, *scale.depth), log_uniform(random, 0.3, 20.0)
    rate = random.uniform(50.0, 400.0) / period
    rising = random.choice([0.8, 0.2, 0.95]) if sawtooth else 0.5
    rounding = random.uniform(2.0, 10.0) / rate
    edge = min(rising, 1.0 - rising) * period
    rounding = min(rounding, edge)
    specimen = drawn_specimen(random, scale, 0.25 * period, 0.0)
    specimen = replace(specimen, mass=drawn_mass(random, specimen.stiffness, 2.0 * rounding))
    runs = []
    for factor, slower in ((1.0, 1.0), (random.uniform(0.5, 1.3), random.uniform(0.7, 2.0))):
        count, rest = int(random.integers(3, 8)), random.choice([0.0, 0.5 * period])
        rest = max(rest, rounding)
        course = _cycles(factor * depth, slower * period, count, rising, rest, rounding)
        runs.append(Run(course, sampled(random, rest + count * slower * period, rate), 0.0))
    extent = Extent(depth, float(runs[0].times[-1]), 0.05 * period, 1.5 * period)
    return _rigid(random, specimen, runs, extent)


def _onset(time: np.ndarray, lasts: float) -> np.ndarray:
    """Return a share that grows from 0 to 1, three derivatives of which are continuous."""
    x = np.clip(time / lasts, 0.0, 1.0)
    return x**4 * (35.0 - 84.0 * x + 70.0 * x**2 - 20.0 * x**3)


def _sines(
    random: Random, frequencies: np.ndarray, weights: np.ndarray, begin: float, end: float
) -> Callable[[np.ndarray], np.ndarray]:
    """Return a sum of sines of random phases, of largest value 1."""
    phases = random.uniform(0.0, 2.0 * np.pi, frequencies.size)

    def wave(time: np.ndarray) -> np.ndarray:
        angles = 2.0 * np.pi * np.multiply.outer(time, frequencies) + phases
        return np.sin(angles) @ weights

    largest = np.abs(wave(np.linspace(begin, end, 4000))).max()
    weights = weights / largest
    return wave


def _wave(random: Random, kind: str, low: float, high: float, lasts: float) -> Smooth:
    """Return a course between -1 and 1, from rest at 0, of frequencies from low to high [Hz]."""
    onset = min(1.0 / low, 0.3 * lasts)
    if kind == "sine":
        shape, fastest = (lambda t: np.sin(2.0 * np.pi * high * t)), high
    elif kind == "sweep":
        speed = (high - low) / lasts
        shape = lambda t: np.sin(2.0 * np.pi * (low + 0.5 * speed * t) * t)  # noqa: E731
        fastest = high
    else:
        count = int(np.clip((high - low) * lasts, 8, 60))
        frequencies = np.sort(random.uniform(low, high, count))
        shape, fastest = _sines(random, frequencies, np.ones(count), 0.0, lasts), high
    return Smooth(lambda t: _onset(t, onset) * shape(t), 0.0, lasts, 2.0 * fastest)


class _Shifted:
    """A course of size 1, scaled and moved to a mean."""

    def __init__(self, course: Course, size: float, mean: float) -> None:
        self._course, self._size, self._mean = course, size, mean
        self.breaks, self.longest_step = course.breaks, course.longest_step
        self.end = getattr(course, "end", 0.0)

    def __call__(self, time: np.ndarray, order: int = 0) -> np.ndarray:
        return self._size * self._course(time, order) + (self._mean if order == 0 else 0.0)


def wave(
    random: Random, kind: str, low: float, high: float, lasts: float, size: float, mean: float
) -> Course:
    """Return a ``sine``, ``sweep`` or ``noise`` of frequencies from low to high [Hz] about a mean.

    From rest at time 0; ``lasts`` is its duration [s], ``size`` its amplitude [m or N].
    """
    return _Shifted(_wave(random, kind, low, high, lasts), size, mean)


def _waving(random: Random, kind: str) -> Draft:
    """Move a tip that stays pressed in, or is bonded, as a wave."""
    high = log_uniform(random, 0.5, 60.0)
    low = high if kind == "sine" else high * random.uniform(0.02, 0.2)
    depth, lasts = log_uniform(random, *TISSUE.depth), random.uniform(8.0, 25.0) / high
    lasts = max(lasts, 6.0 / low if kind != "sine" else 0.0)
    rate = min(high * random.uniform(15.0, 60.0), 1e4)
    specimen = drawn_specimen(random, TISSUE, 0.3 / high)
    specimen = replace(specimen, mass=drawn_mass(random, specimen.stiffness, 1.0 / high))
    preload = random.choice([0.0, 1.2 * depth])
    runs = []
    for factor, faster in ((1.0, 1.0), (random.uniform(0.5, 1.2), random.uniform(0.6, 1.4))):
        wave = _wave(random, kind, faster * low, faster * high, lasts)
        course = _Shifted(wave, factor * depth, preload)
        runs.append(Run(course, sampled(random, lasts, rate), 0.0))
    extent = Extent(depth + preload, lasts, 0.1 / high, 2.0 / low)
    return _rigid(random, specimen, runs, extent)


def _palpation(random: Random) -> Draft:
    """Press by hand, once or twice a second, never the same, while the hand drifts."""
    depth, rhythm = log_uniform(random, *TISSUE.depth), random.uniform(1.0, 2.0)
    rate = log_uniform(random, 25.0, 500.0)
    specimen = drawn_specimen(random, TISSUE, 0.15)
    specimen = replace(specimen, mass=drawn_mass(random, specimen.stiffness, 0.3))
    runs = []
    for factor in (1.0, random.uniform(0.6, 1.3)):
        lasts = random.uniform(8.0, 30.0)
        slow = _sines(random, random.uniform(0.03, 0.3, 5), np.ones(5), 0.0, lasts)
        uneven = _sines(random, random.uniform(0.1, 0.5, 4), np.ones(4), 0.0, lasts)

        def hand(
            t: np.ndarray, size: float = factor * depth, slow=slow, uneven=uneven
        ) -> np.ndarray:
            phase = 2.0 * np.pi * rhythm * t + 1.5 * uneven(t)
            press = 0.45 * (1.0 - np.cos(phase)) * (1.0 + 0.2 * uneven(0.7 * t))
            return size * _onset(t, 1.0) * (0.3 + press + 0.2 * slow(t))

        course = Smooth(hand, 0.0, lasts, 4.0 * rhythm)
        runs.append(Run(course, sampled(random, lasts, rate), 0.0))
    extent = Extent(1.4 * depth, float(runs[0].times[-1]), 0.05, 2.0)
    return _rigid(random, specimen, runs, extent)


def _staircase(random: Random, scale: Scale, series: bool) -> Draft:
    """Step from depth to depth, and wait at each: a depth series in order, or levels at random."""
    depth, wait = log_uniform(random, *scale.depth), log_uniform(random, 0.5, 20.0)
    rate = random.uniform(20.0, 200.0) / wait
    move = max(random.uniform(0.02, 0.3) * wait, 5.0 / rate)
    specimen = drawn_specimen(random, scale, move)
    runs = []
    for factor in (1.0, random.uniform(0.6, 1.3)):
        count = int(random.integers(5, 12))
        up = np.arange(1, count + 1) / count
        levels = up if series else random.uniform(0.1, 1.0, count)
        levels = factor * depth * np.concatenate([[0.0], levels])
        begins = 0.5 * wait + wait * np.arange(count)
        times = np.stack([begins, begins + move], axis=-1).ravel()
        values = np.stack([levels[:-1], levels[1:]], axis=-1).ravel()
        course = Path(times, values, 0.3 * move)
        runs.append(Run(course, sampled(random, begins[-1] + wait, rate), 0.0))
    extent = Extent(depth, float(runs[0].times[-1]), move, 3.0 * wait)
    return _rigid(random, specimen, runs, extent)


def _paused(random: Random) -> Draft:
    """Drive, rest, and drive again."""
    high, depth = log_uniform(random, 1.0, 20.0), log_uniform(random, *TISSUE.depth)
    rate = high * random.uniform(20.0, 60.0)
    specimen = drawn_specimen(random, TISSUE, 0.3 / high)
    specimen = replace(specimen, mass=drawn_mass(random, specimen.stiffness, 1.0 / high))
    runs = []
    for factor in (1.0, random.uniform(0.6, 1.3)):
        on, off = random.uniform(4.0, 8.0) / high, random.uniform(6.0, 20.0) / high
        parts = int(random.integers(2, 4))

        def bursts(
            t: np.ndarray, size: float = factor * depth, on=on, off=off, parts=parts
        ) -> np.ndarray:
            place = np.mod(t - off, on + off)
            going = (t > off) & (place < on) & (t < parts * (on + off))
            envelope = _onset(place, 0.3 * on) * _onset(on - place, 0.3 * on)
            return size * np.where(going, envelope, 0.0) * np.sin(2.0 * np.pi * high * place)

        lasts = off + parts * (on + off)
        course = Smooth(bursts, 0.0, lasts, 3.0 * high)
        runs.append(Run(course, sampled(random, lasts, rate), 0.0))
    extent = Extent(depth, float(runs[0].times[-1]), 0.1 / high, 2.0 / high)
    return _rigid(random, specimen, runs, extent)


def _approach(random: Random, baseline: bool) -> Draft:
    """Come out of the air, touch at an unknown place, press in, go back out."""
    depth, rate = log_uniform(random, *TISSUE.depth), log_uniform(random, 20.0, 1000.0)
    gap, period = random.uniform(0.3, 1.0) * depth, random.uniform(200.0, 1500.0) / rate
    rounding = random.uniform(3.0, 10.0) / rate
    specimen = replace(drawn_specimen(random, TISSUE, 0.2 * period), touch=gap)
    runs = []
    for factor, slower in ((1.0, 1.0), (random.uniform(0.6, 1.2), random.uniform(0.6, 1.6))):
        count, rest = int(random.integers(1, 4)), 0.1 * period
        course = _cycles(gap + factor * depth, slower * period, count, 0.5, rest, rounding)
        runs.append(Run(course, sampled(random, 2.0 * rest + count * slower * period, rate), 0.0))
    lasts = float(runs[0].times[-1])
    draft = _rigid(random, specimen, runs, Extent(depth, lasts, 0.02 * period, period))
    if not baseline:
        return draft
    force = specimen.stiffness * depth * random.uniform(0.01, 0.1) * random.choice([-1.0, 1.0])
    settles = random.random() < 0.5
    moving = {"settling": force, "settling_time": random.uniform(0.1, 0.4) * lasts}
    zero = moving if settles else {"drift": force / lasts}
    bias = 0.3 * force
    sensors = replace(draft.bench.sensors, bias=bias, **zero)
    return replace(draft, bench=replace(draft.bench, sensors=sensors))


def _on_load_cell(random: Random, kind: str) -> Draft:
    """Move the paper's probe, whose load cell yields: a wave, or cycles of straight lines."""
    rig, mass = paper_rig(random)
    depth, high = log_uniform(random, *TISSUE.depth), log_uniform(random, 1.0, 40.0)
    specimen = replace(drawn_specimen(random, TISSUE, 0.3 / high), mass=mass)
    preload = random.choice([0.0, 1.2 * depth])
    runs = []
    for factor, faster in ((1.0, 1.0), (random.uniform(0.5, 1.2), random.uniform(0.6, 1.4))):
        period = 1.0 / (faster * high)
        if kind == "cycles":
            count, rest = int(random.integers(5, 15)), period
            course = _cycles(factor * depth, period, count, 0.5, rest, 0.2 * period)
            lasts = rest + count * period
        else:
            low = high if kind == "sine" else 0.1 * high
            lasts = random.uniform(10.0, 30.0) / high
            wave = _wave(random, kind, faster * low, faster * high, lasts)
            course = _Shifted(wave, factor * depth, preload)
        rate = float(np.clip(high * random.uniform(30.0, 80.0), 500.0, 1e4))
        runs.append(Run(course, sampled(random, lasts, rate), 0.0))
    extent = Extent(depth + preload, float(runs[0].times[-1]), 0.1 / high, 10.0 / high)
    bench = drawn_bench(random, rig, specimen, runs[0], extent.depth)
    # What is known of it is what the diagnosis takes for granted of this probe.
    return Draft(bench, *runs, extent)


def _driven(random: Random, specimen: Specimen, runs: Sequence[Run], extent: Extent) -> Draft:
    """Put the specimen under a tip that a force drives; its mass is not known, by default."""
    return Draft(
        drawn_bench(random, Rig(DRIVEN), specimen, runs[0], extent.depth), *runs, extent,
        mass_known=False,
    )  # fmt: skip


def _free_specimen(random: Random, ratio: tuple[float, float]) -> tuple[Specimen, float]:
    """Draw a specimen and a mass by the damping ratio; return the time of its free motion, too."""
    stiffness, mass = log_uniform(random, *TISSUE.stiffness), log_uniform(random, 0.02, 0.3)
    rate = np.sqrt(stiffness / mass)
    return Specimen(stiffness, 2.0 * log_uniform(random, *ratio) * mass * rate, mass), 1.0 / rate


def _creep(random: Random) -> Draft:
    """Put a weight down within a moment, or a voice coil's force, and wait."""
    specimen, own = _free_specimen(random, (0.15, 3.0))
    force = specimen.stiffness * log_uniform(random, *TISSUE.depth)
    hold, rise = log_uniform(random, 5.0, 60.0), log_uniform(random, 0.5, 10.0) * own
    rate = min(random.uniform(2.0, 8.0) / own, 2e4 / hold)
    rest = random.choice([0.15 * rise, log_uniform(random, 0.3, 2.0)])
    runs = []
    for factor in (1.0, random.uniform(0.4, 1.5)):
        course = Path([rest, rest + rise], [0.0, factor * force], 0.3 * rise)
        runs.append(Run(course, sampled(random, rest + rise + hold, rate), 0.0))
    extent = Extent(force / specimen.stiffness, hold, max(4.0 * own, rise), 0.5 * hold)
    return _driven(random, specimen, runs, extent)


def _driven_in_steps(random: Random, kind: str) -> Draft:
    """Drive by what a converter puts out: squares, steps or noise, held or straight between."""
    specimen, own = _free_specimen(random, (0.05, 1.0))
    force = specimen.stiffness * log_uniform(random, *TISSUE.depth)
    rate = random.uniform(3.0, 12.0) / own
    count = int(random.integers(400, 2500))
    runs = []
    for factor in (1.0, random.uniform(0.5, 1.3)):
        # A converter's clock is even: what it holds between samples would else be unknown.
        times = np.arange(count) / rate
        lasts = times[-1]
        if kind == "noise":
            tones = _sines(random, random.uniform(0.02, 0.5, 40) / own, np.ones(40), 0.0, lasts)
            values = _onset(times, 4.0 * own) * tones(times)
        elif kind == "squares":
            values = np.sign(np.sin(2.0 * np.pi * times / (random.uniform(8.0, 30.0) * own)))
        else:
            wait = int(random.uniform(5.0, 25.0) * own * rate) + 1
            values = np.repeat(random.uniform(-1.0, 1.0, count // wait + 1), wait)[:count]
        values[: int(2.0 * own * rate)] = 0.0
        course = (Straight if kind == "straight squares" else Held)(times, factor * force * values)
        runs.append(Run(course, times, 0.0))
    extent = Extent(force / specimen.stiffness, float(runs[0].times[-1]), 2.0 * own, 40.0 * own)
    return _driven(random, specimen, runs, extent)


def _driven_by_wave(random: Random, kind: str) -> Draft:
    """Drive by a force that is a wave."""
    specimen, own = _free_specimen(random, (0.05, 1.0))
    force = specimen.stiffness * log_uniform(random, *TISSUE.depth)
    high = random.uniform(0.05, 0.4) / own
    low = high if kind == "sine" else 0.1 * high
    rate, lasts = high * random.uniform(20.0, 60.0), random.uniform(10.0, 30.0) / high
    runs = []
    for factor, faster in ((1.0, 1.0), (random.uniform(0.5, 1.2), random.uniform(0.6, 1.4))):
        wave = _wave(random, kind, faster * low, faster * high, lasts)
        runs.append(Run(_Shifted(wave, factor * force, 0.0), sampled(random, lasts, rate), 0.0))
    extent = Extent(force / specimen.stiffness, lasts, 0.1 / high, 10.0 / high)
    return _driven(random, specimen, runs, extent)


PROTOCOLS: dict[str, Protocol] = {
    "relaxation": Protocol(lambda r: _ramp_and_hold(r, TISSUE), (*RELAXATION, "drift")),
    "relaxation_at_once": Protocol(
        lambda r: _ramp_and_hold(r, TISSUE, at_once=True), (*RELAXATION, "drift")
    ),
    "triangles": Protocol(lambda r: _cyclic(r, TISSUE, sawtooth=False), MOVING),
    "sawteeth": Protocol(lambda r: _cyclic(r, TISSUE, sawtooth=True), MOVING),
    "palpation": Protocol(_palpation, MOVING),
    "noise": Protocol(lambda r: _waving(r, "noise"), (*MOVING, "mass")),
    "sine": Protocol(lambda r: _waving(r, "sine"), (*CURVED, "dry_friction", "bias", "drift")),
    "sweep": Protocol(lambda r: _waving(r, "sweep"), (*MOVING, "mass", "gain")),
    "depth_series": Protocol(
        lambda r: _staircase(r, TISSUE, series=True), (*RELAXATION, *CURVED, "drift")
    ),
    "steps": Protocol(
        lambda r: _staircase(r, TISSUE, series=False), (*RELAXATION, *CURVED, "drift", "bias")
    ),
    "pauses": Protocol(_paused, MOVING),
    "approach": Protocol(lambda r: _approach(r, baseline=False), ("contact", "hertz"), clean=False),
    "approach_on_drift": Protocol(
        lambda r: _approach(r, baseline=True), ("contact", "hertz"), clean=False
    ),
    "cantilever": Protocol(lambda r: _cyclic(r, CANTILEVER, sawtooth=False), MOVING),
    "press": Protocol(lambda r: _ramp_and_hold(r, PRESS), (*RELAXATION, "drift")),
    "probe_sine": Protocol(
        lambda r: _on_load_cell(r, "sine"), (*CURVED, "dry_friction", "bias", "drift")
    ),
    "probe_sweep": Protocol(lambda r: _on_load_cell(r, "sweep"), ON_LOAD_CELL),
    "probe_noise": Protocol(lambda r: _on_load_cell(r, "noise"), ON_LOAD_CELL),
    "probe_cycles": Protocol(lambda r: _on_load_cell(r, "cycles"), ON_LOAD_CELL),
    "creep": Protocol(_creep, RELAXATION),
    "steps_held": Protocol(lambda r: _driven_in_steps(r, "steps"), DRIVEN_BY_FORCE),
    "squares_held": Protocol(lambda r: _driven_in_steps(r, "squares"), DRIVEN_BY_FORCE),
    "squares_straight": Protocol(
        lambda r: _driven_in_steps(r, "straight squares"), DRIVEN_BY_FORCE
    ),
    "noise_held": Protocol(lambda r: _driven_in_steps(r, "noise"), DRIVEN_BY_FORCE),
    "force_sine": Protocol(lambda r: _driven_by_wave(r, "sine"), (*CURVED, "dry_friction", "bias")),
    "force_sweep": Protocol(lambda r: _driven_by_wave(r, "sweep"), DRIVEN_BY_FORCE),
}
"""Every protocol, by its name."""
