"""Tips driven near their resonance: tests of integrator and course of the input.

Contents: drawing such records.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from benchmarks.instrument.case import Case, Truth, generator, log_uniform
from benchmarks.instrument.laws import LAWS, REFERENCE, Law
from benchmarks.instrument.motion import LINEAR, driven, linear
from benchmarks.instrument.multisine import Multisine, drawn
from benchmarks.instrument.widths import widths
from benchmarks.ruler.dealt import Record

Array = np.ndarray
Random = np.random.Generator
#: Samples of each recording.
COUNT = 4000
#: Samples a period of the resonance.
PER_PERIOD = (6.0, 40.0)
#: And so few that a cubic spline's error or a step's cannot be small.
FEW = (4.0, 5.0)
DAMPING_RATIO = (0.005, 0.2)
#: The end of the force's content, as a share of the sampling rate; never below the resonance.
CONTENT = (0.1, 0.25)
#: The content ends above the resonance by so much, which is thus driven.
ABOVE = 1.3
#: Residual of the best plain model over the noise.
SEEN = (20.0, 200.0)
#: Least noise over the motion: better sensors of a vibrating tip are not sold.
LEAST_NOISE = 3e-5
#: Travel of the tip [m]: any, and that of records of a usual size.
TRAVEL, USUAL_TRAVEL = (1e-5, 2e-3), (1e-3, 3e-3)
#: Bounds of the library [N/m], [1/s], [m/s] to the stiffness of a tissue, the rate of a branch, and
#: the speed at which friction turns, which a record keeps well within.
STIFFEST, FASTEST, BLUNTEST = 1e5, 1.5e3, 1e-2
#: The depth never falls below this share of its mean where the law is one of contact.
IN_CONTACT = 0.1
#: How often a record is drawn anew whose law does not show, or which loses contact.
DRAWN = 20


@dataclass(frozen=True)
class _Tip:
    """A tip that was drawn: law, values, rate of sampling [Hz], depth at rest, travel [m]."""

    law: Law
    values: Mapping[str, float]
    rate: float
    rest: float
    travel: float

    @property
    def times(self) -> Array:
        return np.arange(COUNT) / self.rate

    def position(self, force: Multisine) -> Array:
        return driven(self.law, self.values, force, self.times, (self.rest, 0.0), self.travel)


def make(seed: int) -> Case:
    """Return the record of a seed: 6 to 40 samples a period."""
    random = generator("resonance", seed)
    law = LAWS[seed % len(LAWS)]
    return _made("resonance", law.effect, seed, law, random, log_uniform(random, *PER_PERIOD))


def make_few(seed: int) -> Case:
    """Return the record of a seed: 4 or 5 samples a period."""
    number = FEW[seed % len(FEW)]
    law = LAWS[seed // len(FEW) % len(LAWS)]
    kind = f"{number:g} samples a period"
    return _made("few_samples", kind, seed, law, generator("few_samples", seed), number)


def _made(group: str, kind: str, seed: int, law: Law, random: Random, per_period: float) -> Case:
    for _ in range(DRAWN):
        tip, forces = _drawn(law, random, per_period)
        first = tip.position(forces[0])
        if law.deep and first.min() < IN_CONTACT * tip.rest:
            continue
        noise = _residual(tip, forces[0], first) / log_uniform(random, *SEEN)
        if noise < LEAST_NOISE * np.std(first):
            continue
        second = tip.position(forces[1])
        if law.deep and second.min() < IN_CONTACT * tip.rest:
            continue
        known = widths(
            lambda sets, tip=tip, force=forces[0]: driven(
                tip.law, sets, force, tip.times, (tip.rest, 0.0), tip.travel
            ),
            tip.values,
            noise,
        )
        records = (
            Record(
                tip.times, position + noise * random.standard_normal(COUNT), force(tip.times), noise
            )
            for position, force in zip((first, second), forces, strict=True)
        )
        truth = Truth({law.effect: law.family}, tip.values, known)
        arguments = {
            "rig": "force_driven",
            "starts": "at-rest",
            "constants": {"contact_position": (0.0, 1e-9)},
        }
        return Case(group, kind, seed, truth, *records, arguments)
    raise ValueError(f"{group}, seed {seed}: {law.effect} does not show")


def _drawn(law: Law, random: Random, per_period: float) -> tuple[_Tip, list[Multisine]]:
    """Return a tip, and the forces of two recordings, which are at rest at their beginning."""
    rate = log_uniform(random, 300.0, 4000.0)
    resonance = 2.0 * np.pi * rate / per_period
    mass = min(log_uniform(random, 0.003, 0.3), STIFFEST / resonance**2)
    stiffness, ratio = mass * resonance**2, log_uniform(random, *DAMPING_RATIO)
    plain = {
        "tip_mass": mass,
        "stiffness": stiffness,
        "damping": 2.0 * ratio * mass * resonance,
    }
    travel = log_uniform(random, *(USUAL_TRAVEL if law.usual else TRAVEL))
    rest = travel if law.deep else 0.0
    end = max(rate * log_uniform(random, *CONTENT), ABOVE * rate / per_period)
    size = 0.25 * travel  # a peak is some four times it
    forces = []
    for _ in range(2):
        pushed = drawn(random, 0.01 * rate, end, 1.0, rate / COUNT)
        answer = pushed.through(lambda s: 1.0 / (mass * s**2 + plain["damping"] * s + stiffness))
        forces.append(pushed.of_rms(pushed.rms / answer.rms * size).from_its_mean())
    values = _strength(law, random, plain, travel, forces[0].rms)
    start = np.full(1, rest)
    held = values["stiffness"] * rest + float(law.force(values, start, 0 * start, 0 * start)[0])
    return _Tip(law, values, rate, rest, travel), [force.about(held) for force in forces]


def _strength(
    law: Law, random: Random, plain: Mapping[str, float], travel: float, force: float
) -> dict[str, float]:
    """Return the values of a tip: the law's such that at full travel it is 5 to 50 % of the spring.

    Where the law takes the place of the spring (or of the damper), the tip at its place of rest has
    the resonance (and the damping) that was drawn.
    """
    values, share = dict(plain), log_uniform(random, 0.05, 0.5)
    stiffness, speed = plain["stiffness"], np.sqrt(plain["stiffness"] / plain["tip_mass"])
    if law.effect == "cubic_stiffening":
        values["cubic_stiffness"] = share * stiffness / travel**2
    elif law.effect == "exponential_stiffening":
        bend = random.uniform(1.0, 2.0)
        values["exponential_force"] = share * stiffness * travel / (np.expm1(bend) - bend)
        values["exponential_length"] = travel / bend
    elif law.effect == "hertz_contact":
        exponent = random.uniform(1.3, 2.2)
        values["contact_exponent"] = exponent
        values["stiffness"] = stiffness / exponent / (travel / REFERENCE) ** (exponent - 1.0)
    elif law.effect == "hunt_crossley":
        exponent = float(random.choice([1.0, 1.5]))
        values["damping"] = 0.3 * plain["damping"]
        values["depth_damping"] = 0.7 * plain["damping"] / (travel / REFERENCE) ** exponent
        values["depth_damping_exponent"] = exponent
    elif law.effect == "standard_linear_solid":
        values["relaxing_stiffness"] = share * stiffness
        values["relaxation_rate"] = min(speed * log_uniform(random, 0.03, 1.0), FASTEST)
    else:
        values["coulomb_force"] = 0.5 * share * force
        values["transition_velocity"] = min(0.02 * speed * travel, BLUNTEST)
    return values


def _residual(tip: _Tip, force: Multisine, position: Array) -> float:
    """Return the rms that the best plain model leaves, by the closed form of a linear tip."""
    start = (tip.rest, 0.0)
    begun = np.array([tip.values[name] for name in LINEAR])

    def left(factors: Array) -> Array:
        values = dict(zip(LINEAR, begun * np.exp(factors), strict=True))
        return linear(values, force, tip.times, start) - position

    best = min(
        (least_squares(left, [0.0, np.log(stiffer), 0.0]) for stiffer in (1.0, 1.2, 1.8)),
        key=lambda found: found.cost,
    )
    return float(np.sqrt(2.0 * best.cost / position.size))
