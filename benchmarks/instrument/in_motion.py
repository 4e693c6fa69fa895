"""Driven tips that are in motion at the first sample, with a clean and with a noisy force.

Contents: drawing such records: one kind as the Silverbox benchmark (Wigren and Schoukens, Three
free data sets for development and benchmarking in nonlinear system identification, 2013), one
faster and stiffer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from benchmarks.instrument.case import Case, Truth, generator, log_uniform
from benchmarks.instrument.laws import CUBIC
from benchmarks.instrument.motion import driven
from benchmarks.instrument.multisine import Multisine, drawn
from benchmarks.ruler.dealt import Record

Array = np.ndarray
Random = np.random.Generator


@dataclass(frozen=True)
class _Kind:
    """Nominal values [SI], of which each seed draws others; sampling; noise of the position [m]."""

    mass: float
    damping: float
    stiffness: float
    cubic: float
    rate: float
    count: int
    lowest: float
    travel: float
    noise: float


#: The travel is an rms.
KINDS = {
    "silverbox": _Kind(5.4e-6, 2.2e-4, 0.99, 4.0, 610.0, 3000, 1.0, 0.04, 2e-4),
    "fast": _Kind(0.02, 0.8, 4200.0, 9e7, 600.0, 2400, 5.0, 1.3e-3, 2e-6),
}
#: White noise of the force over its rms.
FORCE_NOISES = (0.0, 0.02)
#: Values are the nominal ones times or over this.
SPREAD = 1.3
#: End of the force's content, as a share of the sampling rate; the resonance is at 1/9.
CONTENT = (0.15, 0.25)
#: Time before the first sample, in time constants of the free decay.
BEFORE = 12.0


def make(seed: int) -> Case:
    """Return the record of a seed."""
    random = generator("in_motion", seed)
    name = list(KINDS)[seed % len(KINDS)]
    share = FORCE_NOISES[seed // len(KINDS) % len(FORCE_NOISES)]
    kind = KINDS[name]
    values = {
        "tip_mass": kind.mass,
        "damping": kind.damping,
        "stiffness": kind.stiffness,
        "cubic_stiffness": kind.cubic,
    }
    values = {each: value * SPREAD ** random.uniform(-1.0, 1.0) for each, value in values.items()}
    # With the resonance at the same share of the rate as the nominal tip's.
    faster = np.sqrt(values["stiffness"] / values["tip_mass"] * kind.mass / kind.stiffness)
    end = log_uniform(random, *CONTENT)
    first, second = (
        _record(kind, values, kind.rate * faster, end, share, size, random) for size in (1.0, 0.6)
    )
    truth = Truth({CUBIC.effect: CUBIC.family}, values)
    kind_of = f"{name}, force {'noisy' if share else 'clean'}"
    return Case("in_motion", kind_of, seed, truth, first, second, {"rig": "force_driven"})


def _record(
    kind: _Kind,
    values: dict[str, float],
    rate: float,
    end: float,
    share: float,
    size: float,
    random: Random,
) -> Record:
    pushed = drawn(random, kind.lowest, end * rate, 1.0, rate / kind.count)
    answer = pushed.through(
        lambda s: 1.0 / (values["tip_mass"] * s**2 + values["damping"] * s + values["stiffness"])
    )
    force = pushed.of_rms(pushed.rms / answer.rms * size * kind.travel)
    times = np.arange(kind.count) / rate
    before = BEFORE * 2.0 * values["tip_mass"] / values["damping"]
    disturbance = share * force.rms * random.standard_normal(kind.count)
    true, shaken = _both(values, force, times, before, disturbance, kind.travel)
    noise = kind.noise * random.standard_normal(kind.count)
    left = float(np.hypot(kind.noise, np.sqrt(np.mean((shaken - true) ** 2))))
    return Record(times, true + noise, force(times) + disturbance, left)


def _both(
    values: dict[str, float],
    force: Multisine,
    times: Array,
    before: float,
    disturbance: Array,
    travel: float,
) -> Array:
    """Return the true position, and that which the true values make of the force as measured.

    Both are in motion alike at the first sample; between its samples the noise goes on as a spline.
    """
    spline = CubicSpline(times, disturbance)
    shaken = np.array([0.0, 1.0])

    def pushed(time: float) -> Array:
        return force(time) + (shaken * spline(time) if time > 0.0 else 0.0 * shaken)

    begun = np.concatenate([[-before], times])
    return driven(CUBIC, values, pushed, begun, (0.0, 0.0), travel)[:, 1:]
