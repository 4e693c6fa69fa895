"""Whether force and position can belong together: contact, clocks, signs, units.

Contents: checks by a first look at their relation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from tissue_probe.diagnosis.inspection.channel import InspectedChannel
from tissue_probe.diagnosis.inspection.coarse_response import (
    CoarseResponse,
    Regressors,
    best_lag,
    coarse_response,
    measure_active_share,
    regressors,
)
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.physics.kinds import LONGEST_DELAY, MOST_EARLY
from tissue_probe.quantities import POSITION, Quantity

UNEXPLAINED_SHARE = 0.25
"""Share of the force (rms) that the right lag leaves unexplained at the most, and none at least."""

BETTER = 0.5
"""Share of a residual below which the other of two explanations is the right one."""

ENDS, HALF = 8, 0.5
"""Samples at the end of a record whose mean noise hardly moves, and the share of all that a channel
moves by which they are far from the first one: the nearer end of its range."""

LONGEST_LAG = 0.25
"""Lags are looked for up to this [s], and to an eighth of the record."""

STIFFEST, SOFTEST = 1e6, 1.0
"""Apparent stiffnesses of hardly any tissue [N/m]."""

HUGE = 1e30
"""Position [m] or force [N] of nothing that is measured; nor is its inverse."""

WIDEST_TRAVEL = 0.5
"""Travel of no probe [m]."""


def check_size(position: InspectedChannel, force: InspectedChannel) -> Iterator[Finding]:
    """Yield ``suspicious_units`` of values with which nothing can be computed."""
    for channel in (position, force):
        largest = np.abs(channel.values).max()
        if largest > HUGE or 0.0 < largest < 1.0 / HUGE:
            yield Finding(
                "suspicious_units",
                f"The {channel.name} reaches {largest:.3g}: no instrument measures that; look "
                "whether this is the right column, and state its unit.",
                fatal=True,
            )


#: Samples a cycle from which on the noise of a sine without any is told to less than a tenth of it.
LEAST_A_CYCLE = 6.0
FEW_A_CYCLE = (
    "The motion has {:.2g} samples a cycle, which do not tell it from noise, nor whether force and "
    "position belong together in time: sample at {:.3g} Hz or more, or excite more slowly."
)


def check_response(
    position: InspectedChannel,
    force: InspectedChannel,
    sample_period: float,
    times: float = 1.0,
    drives: Quantity = POSITION,
) -> Iterator[Finding]:
    """Yield the faults between the channels.

    ``no_contact``, ``unsynchronised``, ``wrong_polarity``, ``suspicious_units``; ``few_a_cycle`` in
    the place of findings that so few samples do not allow. The record is ``times`` slower than
    usual.
    """
    cycle = _cycle(position)
    for found in _response(position, force, sample_period, times, drives):
        if found.fatal and cycle < LEAST_A_CYCLE:
            rate = LEAST_A_CYCLE / (cycle * sample_period)
            yield Finding("few_a_cycle", FEW_A_CYCLE.format(cycle, rate), fatal=True)
            return
        yield found


def _cycle(position: InspectedChannel) -> float:
    """Return how many samples a cycle of the strongest oscillation has."""
    values = position.values - position.values.mean()
    strongest = int(np.argmax(np.abs(np.fft.rfft(values * np.hanning(values.size)))))
    return float(values.size / max(strongest, 1))


def _response(
    position: InspectedChannel,
    force: InspectedChannel,
    sample_period: float,
    times: float,
    drives: Quantity,
) -> Iterator[Finding]:
    yield from _check_units(position, force)
    if np.std(force.values) < 1.3 * force.noise:
        yield Finding(
            "no_contact",
            f"The force is no more than its noise of {force.noise:.3g} N: bring the probe into "
            "contact, or look whether this is the right column or topic.",
            fatal=True,
            channel=force.name,
        )
        return
    both = regressors(position.values / position.span, force.values / force.span, sample_period)
    found = coarse_response(both)
    lag = _lag(both, found, force, sample_period / times)
    # The position comes after a force that drives it: that is the tip's mass, and no clock.
    if lag > 0 or (lag < 0 and drives is POSITION):
        yield Finding(
            "unsynchronised",
            f"The force is {1e3 * abs(lag) * sample_period:.3g} ms "
            f"{'late' if lag > 0 else 'early'} against the position: the channels have different "
            "clocks or delays; shift one, or sample both by one clock.",
            fatal=True,
        )
        found = coarse_response(both, lag)
    if _ends_pressed(position) * _ends_pressed(force) > 0:
        return  # a body that is pressed in further, and rests there, pushes back harder
    yield from _check_sign(
        found,
        force.span / position.span,
        lambda: _measure_unexplained(position, force, sample_period),
    )


def _ends_pressed(channel: InspectedChannel) -> int:
    """Return 1 or -1 where a record ends far above or below where it begins; else 0."""
    moved = float(np.mean(channel.values[-ENDS:]) - channel.values[0])
    return int(np.sign(moved)) if abs(moved) > HALF * channel.span else 0


def _check_units(position: InspectedChannel, force: InspectedChannel) -> Iterator[Finding]:
    stiffness = np.std(force.values / force.span) / np.std(position.values / position.span)
    stiffness *= force.span / position.span
    if not SOFTEST < stiffness < STIFFEST:
        yield Finding(
            "suspicious_units",
            f"Force over position is {stiffness:.3g} N/m, which hardly any tissue has: are they in "
            "newtons and metres? State the units.",
        )
    elif position.span > WIDEST_TRAVEL:
        yield Finding(
            "suspicious_units",
            f"The position moves over {position.span:.3g} m, more than a probe can: is it in "
            "metres? State the unit.",
        )


def _lag(
    both: Regressors, found: CoarseResponse, force: InspectedChannel, sample_period: float
) -> int:
    """Return a lag [samples] that explains the force far better than none; 0 if none does."""
    longest = int(min(LONGEST_LAG / sample_period, force.values.size / 8))
    lag = best_lag(both, longest)
    # A lag that may be fitted as a delay is an effect.
    if -MOST_EARLY < lag * sample_period < LONGEST_DELAY or found.unexplained < UNEXPLAINED_SHARE:
        return 0  # without a lag they belong together, too: damping passes for one of milliseconds
    shifted = coarse_response(both, lag)
    passive = shifted.stiffness * shifted.damping > 0.0
    right = shifted.unexplained < min(0.5 * found.unexplained, UNEXPLAINED_SHARE)
    return lag if passive and right else 0


def _measure_unexplained(
    position: InspectedChannel, force: InspectedChannel, sample_period: float
) -> tuple[float, float]:
    """Return the share of the force that nothing passive explains, with its sign and the other."""
    own, other = (
        measure_active_share(position.values / position.span, values / force.span, sample_period)
        for values in (force.values, -force.values)
    )
    return own, other


def _floats(found: CoarseResponse) -> bool:
    """Whether a force that may be of a mass or of a spring is opposite to the position."""
    return not found.separable and found.elastic < -0.9 and abs(found.viscous) < 0.03


def _is_inert(found: CoarseResponse) -> bool:
    """Whether the force is a mass's, and nothing else's."""
    beside = max(abs(found.elastic), abs(found.viscous))
    return found.separable and found.inertial > 0.9 and beside < 0.05


def _check_sign(
    found: CoarseResponse, scale: float, left: Callable[[], tuple[float, float]]
) -> Iterator[Finding]:
    """Tissue resists: it pushes back, and takes up energy; mass alone does neither.

    A tissue that relaxes or creeps may seem to do the opposite: where a first look explains little,
    a closer one decides, with ``left``.
    """
    gives_energy = found.viscous < -0.05 and found.elastic < -0.5 * found.viscous
    pulls = found.separable and found.elastic < -0.2 and found.viscous < 0.05
    inertia = -found.stiffness * scale / (2.0 * np.pi * found.frequency) ** 2
    floats = _floats(found)
    wrong = gives_energy or pulls
    if found.unexplained > UNEXPLAINED_SHARE:
        given, other = left()
        wrong = other < (given if wrong else min(BETTER * given, UNEXPLAINED_SHARE))
    if wrong or (floats and inertia > 0.3):
        yield Finding(
            "wrong_polarity",
            "The force falls as the probe goes in: force or position has the wrong sign; state the "
            "other `force_polarity`, or `position_polarity` for heights.",
            fatal=True,
        )
    elif floats or _is_inert(found):
        mass = inertia if floats else found.mass * scale
        yield Finding(
            "no_contact",
            f"The force is that of a mass of {mass:.3g} kg moving freely: bring the probe into "
            "contact.",
        )
