"""A laboratory before anything is hidden: bench, two runs, and what its user would state.

Contents: the parts that protocols share: specimens of a scale, sample times, noise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from benchmarks.protocols.course import Array
from benchmarks.protocols.hidden import Extent, Random, log_uniform
from benchmarks.protocols.motion import COMPLIANT, DRIVEN, Rig
from benchmarks.protocols.sensors import Bench, Sensors
from benchmarks.protocols.specimen import Specimen
from benchmarks.protocols.strength import Run

#: Noise of the position may cost at most this share of the signal, as far as its rate of samples
#: and its spline make it: a laboratory whose encoder is worse takes fewer samples.
ENCODER_SHARE = 0.02
#: The paper's probe: value and standard deviation.
PAPER = {"tip_mass": (0.04, 4e-4), "load_cell_stiffness": (9700.0, 145.5)}


@dataclass(frozen=True)
class Scale:
    """Of what size things are in a laboratory: stiffness [N/m] and depth [m], from and to."""

    stiffness: tuple[float, float]
    depth: tuple[float, float]


TISSUE = Scale((150.0, 3000.0), (0.8e-3, 5e-3))
PRESS = Scale((2e4, 1e6), (0.2e-3, 2e-3))
CANTILEVER = Scale((0.06, 5.0), (0.3e-6, 4e-6))


@dataclass(frozen=True)
class Draft:
    """A laboratory with a Kelvin-Voigt specimen.

    Attributes
    ----------
    bench : Bench
        Rig, specimen, sensors.
    first, second : Run
        The record that is diagnosed, and another of the same specimen.
    extent : Extent
        Of the first.
    constants : mapping
        What the user knows of the rig, as ``tp.diagnose`` takes it.
    mass_known : bool
        Whether the tip's mass is among them.
    at_rest : bool
        Whether the tip rested before the first sample.
    """

    bench: Bench
    first: Run
    second: Run
    extent: Extent
    constants: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    mass_known: bool = True
    at_rest: bool = True


def drawn_specimen(random: Random, scale: Scale, time: float, mass: float = 0.0) -> Specimen:
    """Draw stiffness, and a damping that shows in motions that take some time [s]."""
    stiffness = log_uniform(random, *scale.stiffness)
    return Specimen(stiffness, stiffness * time * log_uniform(random, 0.03, 0.4), mass)


def drawn_mass(random: Random, specimen_stiffness: float, time: float) -> float:
    """Draw a tip's mass [kg]: none, or one whose inertia is slight or plain in that time [s]."""
    if random.random() < 0.4:
        return 0.0
    return specimen_stiffness * (time / (2.0 * np.pi)) ** 2 * log_uniform(random, 0.01, 0.5)


def sampled(random: Random, duration: float, rate: float, jittering: float = 0.3) -> Array:
    """Return times of samples [s], of one record in three uneven by up to ``jittering`` periods."""
    times = np.arange(int(duration * rate) + 1) / rate
    if random.random() < 1.0 / 3.0:
        share = random.uniform(0.03, jittering)
        times[1:] += share * random.uniform(-1.0, 1.0, times.size - 1) / rate
    return times


def drawn_bench(random: Random, rig: Rig, specimen: Specimen, run: Run, depth: float) -> Bench:
    """Give a rig sensors: noise of the output a share of the signal, of the input one, or none."""
    force, share = specimen.stiffness * depth, log_uniform(random, 7e-4, 7e-3)
    encoder = depth * log_uniform(random, 2e-4, 5e-3) if random.random() < 0.5 else 0.0
    if rig.name == DRIVEN:
        command = force * log_uniform(random, 2e-4, 2e-3) if random.random() < 0.5 else 0.0
        return Bench(rig, specimen, Sensors(command, depth * share))
    by_encoder = Bench(rig, specimen, Sensors(0.0, encoder)).noise(run.period, np.zeros(2))
    if by_encoder > ENCODER_SHARE * force:
        encoder *= ENCODER_SHARE * force / by_encoder
    return Bench(rig, specimen, Sensors(force * share, encoder))


def paper_rig(random: Random) -> tuple[Rig, float]:
    """Draw load cell and tip mass of the paper's probe, within their tolerances."""
    cell = random.normal(*PAPER["load_cell_stiffness"])
    grip = 0.8 * np.exp(random.normal(0.0, 0.2))
    return Rig(COMPLIANT, float(cell), float(grip)), float(random.normal(*PAPER["tip_mass"]))
