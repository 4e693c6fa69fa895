"""Whether enough was sampled, evenly, of something that moves.

Contents: checks of times, and of each channel by itself.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tissue_probe.diagnosis.inspection.channel import InspectedChannel
from tissue_probe.diagnosis.inspection.disturbances import LONGEST
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.residuals.noise_floor import FELT, noise_beside_steps
from tissue_probe.diagnosis.transforms import lasting_range
from tissue_probe.signals import FloatArray

IRREGULAR_STEP = 0.05
"""Deviation from even spacing that matters [periods]."""

PER_CYCLE = 8.0
"""Samples in a cycle of the fastest motion below which a model cannot be integrated."""


SUDDEN = 5.5
"""A jump is so many times the root mean square of a channel's changes: no chance makes such."""

BLOCKS, RESTS = 50, 0.1
"""Pieces in which the way is looked at; a position rests in a piece that goes by less than a tenth
of the mean way, and goes one way that rests in no more than a tenth of them."""

GOES_ONE_WAY = (
    "The tip goes one way all the time: how the force grows with the depth, and how it changes in "
    "time, look alike here. Go back as well, or hold, to tell them apart."
)

UNEVEN = 0.1
"""Share of a ramp's moves that rounding makes uneven at least, unless its speed is a whole number
of steps a sample to half of this share."""

FEWEST_STEPS = 1000.0
"""Encoder steps in the whole travel below which they show in the force.

On the paper's rig 2 um of 2 mm shake the force by 9700 N/m * 2 um / sqrt(12) = 5.6 mN, its noise.
"""


def check_times(time: FloatArray, sample_period: float) -> Iterator[Finding]:
    """Check when samples were taken [s]; yields ``irregular_sampling`` and ``gaps``."""
    steps = np.diff(time) / sample_period
    gaps = steps > 1.5
    if gaps.any():
        yield Finding(
            "gaps",
            f"There are {np.count_nonzero(gaps)} gaps in time, the longest "
            f"{steps.max() * sample_period:.3g} s: fit the parts between them as recordings of "
            "their own.",
            fatal=True,
            spans=tuple((int(place), int(place) + 2) for place in np.flatnonzero(gaps)),
        )
    off = np.abs(steps[~gaps] - 1.0)
    if not (off <= IRREGULAR_STEP).all():
        yield Finding(
            "irregular_sampling",
            f"Steps in time differ by up to {100.0 * np.nanmax(off, initial=0.0):.0f} % from the "
            f"period of {sample_period:.4g} s: resample onto even times, or have the samples timed "
            "by hardware.",
        )


def check_sampling(
    position: InspectedChannel, force: InspectedChannel, sample_period: float
) -> Iterator[Finding]:
    """Yield the faults of a channel by itself.

    ``constant_position``, ``constant_force``, ``no_motion``, ``low_rate``, ``coarse_encoder``,
    ``one_way``.
    """
    for channel, cause in ((position, "the encoder"), (force, "the load cell")):
        if channel.span == 0.0:
            yield Finding(
                f"constant_{channel.name}",
                f"The {channel.name} is {channel.values[0]:.4g} throughout: look whether {cause} "
                "is connected, and whether this is the right column or topic.",
                fatal=True,
            )
    if position.span == 0.0:
        return
    if _stands_still(position, force):
        yield Finding(
            "no_motion",
            f"The position moves by {position.span:.3g} m in all, no more than its noise and "
            "resolution: without motion nothing is learnt of the tissue; excite the coil.",
            fatal=True,
        )
        return
    yield from _check_rate(position, sample_period)
    yield from _check_encoder(position)
    if _goes_one_way(position):
        yield Finding("one_way", GOES_ONE_WAY)


def _goes_one_way(position: InspectedChannel) -> bool:
    """Whether the position goes on in one direction, without rests that would tell time alone."""
    blocks = np.array_split(position.values, min(BLOCKS, position.values.size))
    ways = np.diff([block.mean() for block in blocks]) / position.span
    going = np.abs(ways) > RESTS / BLOCKS
    return bool(abs(np.sign(ways) @ going) == going.sum() > (1.0 - RESTS) * ways.size)


def _stands_still(position: InspectedChannel, force: InspectedChannel) -> bool:
    """Whether the position moves within its resolution, or as noise that the force does not see.

    A motion sampled too slowly looks like noise in the position alone. A step in the first samples,
    before a long rest, is hardly seen in the spread.
    """
    if position.span <= 2.0 * position.step:
        return not _answers(position, force)
    spread = np.std(position.values / position.span) * position.span
    noise = noise_beside_steps(position.values)
    quiet = spread < 2.0 * noise and _measure_likeness(position, force) < FELT
    return bool(quiet and lasting_range(position.values, LONGEST) < 2.0 * SUDDEN * noise)


def _measure_likeness(position: InspectedChannel, force: InspectedChannel) -> float:
    """Return how alike the force is to position, speed and acceleration together, from 0 to 1.

    A sample and its two neighbours tell these three.
    """
    if not force.span:
        return 0.0
    moved = np.lib.stride_tricks.sliding_window_view(position.values / position.span, 3)
    moved, answer = moved - moved.mean(axis=0), force.values[1:-1] / force.span
    answer = answer - answer.mean()
    told = moved @ np.linalg.lstsq(moved, answer, rcond=None)[0]
    size = float(np.linalg.norm(answer))
    return float(np.linalg.norm(told)) / size if size else 0.0


def _answers(position: InspectedChannel, force: InspectedChannel) -> bool:
    """Whether the force jumps where the position does: a step that is commanded, with no encoder.

    Where an encoder turns from one count to the next the force changes as it does elsewhere.
    """
    moves = np.diff(position.values) != 0.0
    change = np.diff(force.values / (force.span or 1.0))
    if not moves.any() or moves.all():
        return False
    return bool(np.median(np.abs(change[moves])) > SUDDEN * np.sqrt(np.mean(change[~moves] ** 2)))


def _check_rate(position: InspectedChannel, sample_period: float) -> Iterator[Finding]:
    """Look where 99 % of the displacement's energy lies below."""
    centred = position.values - position.values.mean()
    energy = np.abs(np.fft.rfft(centred * np.hanning(centred.size))) ** 2
    below = np.cumsum(energy) / energy.sum()
    fastest = np.searchsorted(below, 0.99) / (centred.size * sample_period)
    if fastest * sample_period * PER_CYCLE > 1.0:
        yield Finding(
            "low_rate",
            f"The motion reaches {fastest:.3g} Hz, but only {1.0 / sample_period:.4g} samples a "
            f"second were taken: sample at {2.0 * PER_CYCLE * fastest:.3g} Hz or more, or excite "
            "more slowly.",
        )


def _goes_evenly(position: InspectedChannel) -> bool:
    """Whether the steps are those of an even motion: hardly a move is longer than the one before.

    Rounding makes the moves of a ramp uneven: it is not a whole number of steps from one sample to
    the next.
    """
    moves = np.abs(np.diff(position.values))
    uneven = np.abs(np.diff(moves)) > 0.5 * position.step
    return bool(np.count_nonzero(uneven) < UNEVEN * np.count_nonzero(moves))


def _check_encoder(position: InspectedChannel) -> Iterator[Finding]:
    steps = position.span / position.step if position.step else np.inf
    if steps < FEWEST_STEPS and not _goes_evenly(position):
        yield Finding(
            "coarse_encoder",
            f"The position comes in steps of {position.step:.3g} m, {steps:.0f} of them in the "
            "whole travel: that poses as lag and as noise; use a finer encoder or a larger "
            "amplitude.",
        )
