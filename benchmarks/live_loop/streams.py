"""Streams of samples of simulated specimens, as the monitor and an identification get them.

They are made by the challenge's simulator, which shares no code with the models under test, on its
tolerant rig: constants off within their tolerances, 1/f noise beside the white.

Contents: drawing a rig and its tissue, motions that begin at rest, measuring, blocks.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tissue_probe.challenge.case import Case
from tissue_probe.challenge.change import log_uniform
from tissue_probe.challenge.instrument import (
    CHALLENGE_RATE,
    FORCE_NOISE,
    InstrumentErrors,
    pink_noise,
)
from tissue_probe.challenge.measured_motion import Measured
from tissue_probe.challenge.motion import MOTION_RATE
from tissue_probe.challenge.record import follow
from tissue_probe.challenge.simulator import LIBRARY, PINK_NOISE
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.tolerances import Tolerances
from tissue_probe.signals import FloatArray, SampleBlock

#: Effects of the library that may be hidden alone: the others are then another one.
ALONE = tuple(name for name, effect in LIBRARY.items() if not effect.beside)
#: Time in which a motion rises from rest [s].
RISE = 0.05
#: Samples to a block, as the driver publishes them.
BLOCK = 10


def draw_rig(random: np.random.Generator) -> tuple[Specimen, InstrumentErrors]:
    """Draw Kelvin-Voigt tissue of 150 to 3000 N/m and 0.5 to 15 N s/m on a tolerant rig."""
    tissue = Specimen(
        stiffness=log_uniform(random, 150.0, 3000.0), damping=log_uniform(random, 0.5, 15.0)
    )
    rig, zero = Tolerances().draw_rig(tissue, random.standard_normal(len(Tolerances._fields)))
    return rig, InstrumentErrors(contact_zero=zero, pink_noise=PINK_NOISE)


def rise_from_rest(since: FloatArray) -> FloatArray:
    """Return what a motion is multiplied by, at times since its beginning [s]."""
    rise = np.clip(since / RISE, 0.0, 1.0)
    risen: FloatArray = rise**3 * (10.0 - 15.0 * rise + 6.0 * rise**2)
    return risen


def move_coil(kind: str, seed: int, seconds: float) -> Measured:
    """Return a motion of the coil that begins at rest, pressed in or not.

    Parameters
    ----------
    kind : str
        ``sine``, of 10 Hz; or ``sweep``, from 1 to 60 Hz and back in 8 s.
    seed : int
        Of amplitude and preload.
    seconds : float
        How long it is.
    """
    random = np.random.default_rng(seed)
    since = np.arange(round(seconds * CHALLENGE_RATE)) / CHALLENGE_RATE
    frequency = np.full(since.size, 10.0)
    if kind == "sweep":
        frequency = 1.0 + 59.0 * (1.0 - np.abs(1.0 - since % 8.0 / 4.0))
    angle = 2.0 * np.pi * np.cumsum(frequency) / CHALLENGE_RATE
    preload = random.uniform(1e-3, 3e-3) if random.random() < 0.5 else 0.0
    amplitude = random.uniform(0.8e-3, 1.2e-3)
    return follow(since, preload + amplitude * rise_from_rest(since) * np.sin(angle), kind, True)


def measure_case(
    case: Case, random: np.random.Generator, rate: int = MOTION_RATE
) -> tuple[FloatArray, FloatArray]:
    """Return position [m] and force [N] with noise of the rig; ``rate`` as ``Case.measure``."""
    noise = FORCE_NOISE * random.standard_normal(case.samples)
    noise += PINK_NOISE * pink_noise(case.samples, random)
    return case.measure(noise, rate)


def cut_into_blocks(position: FloatArray, force: FloatArray) -> Iterator[SampleBlock]:
    """Return samples as the driver publishes them; the voltage of the coil is not known."""
    unknown = np.full(BLOCK, np.nan)
    for first in range(0, force.size - BLOCK + 1, BLOCK):
        here = slice(first, first + BLOCK)
        stamp = round(1e9 * first / CHALLENGE_RATE)
        yield SampleBlock(stamp, first, 1.0 / CHALLENGE_RATE, position[here], force[here], unknown)
