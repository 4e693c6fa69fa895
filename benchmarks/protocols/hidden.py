"""What is hidden beside Kelvin-Voigt: one part in a form of the benchmark's own.

Contents: each part's form, as a change of the bench that grows with a strength, and by which names
it may be told.

| hidden | form here | names of the library, family |
|---|---|---|
| branch | a Maxwell branch | standard_linear_solid, relaxation |
| two branches | two Maxwell branches, a decade and more apart | generalized_maxwell, relaxation |
| power law | Maxwell branches, four a decade, rates^a strong | springpot, relaxation |
| exponential | k L (exp(e / L) - 1) in place of k e | exponential_stiffening, stiffening |
| cubic | k e (1 + (e / L)^2) in place of k e | cubic_stiffening, stiffening |
| hertz | k L (e / L)^n in place of k e, pushing only | hertz_contact, stiffening |
| contact | the tissue only pushes | contact_loss, contact |
| dry friction | Fc sign v; sticks where the tip is free | coulomb_friction, friction |
| mass | a mass beside the tip's | added_mass, inertia |
| bias, drift | constant, and proportional to time | force_bias, force_drift, offset |
| lag | a first-order low-pass of the force | force_lag, timing |
| delay | the force is late | channel_delay, timing |
| gain | the force reads too much by a share | force_gain, scale |
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.protocols.sensors import Bench

Random = np.random.Generator
#: A bench with a part of a strength, which is relative to what the bench does by itself.
Change = Callable[[Bench, float], Bench]


@dataclass(frozen=True)
class Extent:
    """How far, how long and how fast a protocol goes.

    Attributes
    ----------
    depth : float
        Largest indentation [m], roughly.
    duration : float
        Of the record [s].
    shortest, longest : float
        Times between which a relaxation shows [s].
    """

    depth: float
    duration: float
    shortest: float
    longest: float


@dataclass(frozen=True)
class Hidden:
    """A part that may be hidden.

    Attributes
    ----------
    effects : tuple of str
        Names by which it may be told.
    family : str
        Of these.
    drawn : callable
        Of a random generator and an ``Extent``; returns the ``Change``.
    weakest, strongest : float
        Between which its strength is sought.
    measured : bool
        Whether the strength is sought at all: contact comes and goes as the course has it.
    """

    effects: tuple[str, ...]
    family: str
    drawn: Callable[[Random, Extent], Change]
    weakest: float = 1e-4
    strongest: float = 5.0
    measured: bool = True


def log_uniform(random: Random, low: float, high: float) -> float:
    """Return a value whose logarithm is uniform."""
    return float(np.exp(random.uniform(np.log(low), np.log(max(low, high)))))


def _branches(times: tuple[float, ...], weights: np.ndarray) -> Change:
    def change(bench: Bench, strength: float) -> Bench:
        stiffness = tuple(bench.specimen.stiffness * strength * weights)
        rates = tuple(1.0 / np.array(times))
        return _specimen(bench, branch_stiffness=stiffness, branch_rate=rates)

    return change


def _specimen(bench: Bench, **changed: object) -> Bench:
    return replace(bench, specimen=replace(bench.specimen, **changed))


def _sensors(bench: Bench, **changed: object) -> Bench:
    return replace(bench, sensors=replace(bench.sensors, **changed))


def _branch(random: Random, extent: Extent) -> Change:
    return _branches((log_uniform(random, extent.shortest, extent.longest),), np.ones(1))


def _two_branches(random: Random, extent: Extent) -> Change:
    middle = np.sqrt(extent.shortest * extent.longest)
    times = (
        log_uniform(random, extent.shortest, 0.5 * middle),
        log_uniform(random, 2.0 * middle, extent.longest),
    )
    share = random.uniform(0.3, 0.7)
    return _branches(times, np.array([share, 1.0 - share]))


def _power_law(random: Random, extent: Extent) -> Change:
    """Take branches for the integral over rates r of r^(a - 1): the law t^-a between the ends."""
    exponent = random.uniform(0.15, 0.5)
    decades = np.log10(extent.longest / extent.shortest) + 3.0
    times = extent.longest * 10.0 ** (1.5 - np.linspace(0.0, decades, int(4.0 * decades) + 1))
    weights = (times / np.sqrt(extent.shortest * extent.longest)) ** -exponent
    return _branches(tuple(times), weights / weights[times >= extent.shortest].sum())


def _exponential(random: Random, extent: Extent) -> Change:
    def change(bench: Bench, strength: float) -> Bench:
        return _specimen(bench, law="exponential", length=extent.depth / strength)

    return change


def _cubic(random: Random, extent: Extent) -> Change:
    def change(bench: Bench, strength: float) -> Bench:
        return _specimen(bench, law="cubic", length=extent.depth / np.sqrt(strength))

    return change


def _hertz(random: Random, extent: Extent) -> Change:
    def change(bench: Bench, strength: float) -> Bench:
        return _specimen(
            bench, law="power", length=extent.depth, exponent=1.0 + strength, one_sided=True
        )

    return change


def _contact(random: Random, extent: Extent) -> Change:
    return lambda bench, strength: _specimen(bench, one_sided=True)


def _friction(random: Random, extent: Extent) -> Change:
    def change(bench: Bench, strength: float) -> Bench:
        return _specimen(bench, friction=strength * bench.specimen.stiffness * extent.depth)

    return change


def _mass(random: Random, extent: Extent) -> Change:
    def change(bench: Bench, strength: float) -> Bench:
        specimen = bench.specimen
        added = strength * (specimen.stiffness * extent.shortest**2 + specimen.mass)
        return _specimen(bench, mass=specimen.mass + added)

    return change


def _offset(name: str) -> Callable[[Random, Extent], Change]:
    def drawn(random: Random, extent: Extent) -> Change:
        sign = random.choice([-1.0, 1.0])
        time = extent.duration if name == "drift" else 1.0

        def change(bench: Bench, strength: float) -> Bench:
            force = sign * strength * bench.specimen.stiffness * extent.depth
            return _sensors(bench, **{name: force / time})

        return change

    return drawn


def _lag(random: Random, extent: Extent) -> Change:
    def change(bench: Bench, strength: float) -> Bench:
        return replace(bench, rig=replace(bench.rig, lag=strength * extent.shortest))

    return change


def _delay(random: Random, extent: Extent) -> Change:
    return lambda bench, strength: _sensors(bench, delay=strength * extent.shortest)


def _gain(random: Random, extent: Extent) -> Change:
    return lambda bench, strength: _sensors(bench, gain=strength)


HIDDEN = {
    "branch": Hidden(("standard_linear_solid",), "relaxation", _branch),
    "two_branches": Hidden(("generalized_maxwell",), "relaxation", _two_branches),
    "power_law": Hidden(("springpot",), "relaxation", _power_law),
    "exponential": Hidden(("exponential_stiffening",), "stiffening", _exponential, 1e-3, 4.0),
    "cubic": Hidden(("cubic_stiffening",), "stiffening", _cubic, 1e-3, 10.0),
    "hertz": Hidden(("hertz_contact",), "stiffening", _hertz, 0.2, 1.5),
    "contact": Hidden(("contact_loss",), "contact", _contact, measured=False),
    "dry_friction": Hidden(("coulomb_friction",), "friction", _friction, 1e-4, 0.5),
    "mass": Hidden(("added_mass",), "inertia", _mass, 1e-4, 3.0),
    "bias": Hidden(("force_bias",), "offset", _offset("bias"), 1e-4, 0.5),
    "drift": Hidden(("force_drift",), "offset", _offset("drift"), 1e-4, 0.5),
    "lag": Hidden(("force_lag",), "timing", _lag, 1e-4, 0.5),
    "delay": Hidden(("channel_delay",), "timing", _delay, 1e-4, 0.3),
    "gain": Hidden(("force_gain",), "scale", _gain, 1e-3, 0.5),
}
"""What may be hidden, by its name."""
