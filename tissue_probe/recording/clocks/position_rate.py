"""The error of k and beta where a position is sampled slowly for its motion.

Contents: how far a spline through few samples a cycle is from the motion.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.recording.clocks.even_grid import interpolate
from tissue_probe.signals import FloatArray

TOLERATED = 0.01
"""Error of the position's amplitude from which on it is told: k and beta carry it in full."""

ENOUGH_FORCE = 2**14
"""Samples of the force that tell its frequency."""

LINE_SHARE = 0.25
"""Share of the force's power that a line holds where the motion is a sine; noise holds less in one.
"""


def tell_slow_position(
    name: str, position_times: FloatArray, force_times: FloatArray, force: FloatArray
) -> str | None:
    """Name the error of k and beta where a position is sampled too slowly for the motion.

    The motion is taken to be a sine of the force's strongest frequency; it is sampled when the
    position was, brought to the force's times as the position is, and compared with itself.

    Parameters
    ----------
    name : str
        The position's name in messages.
    position_times : array, shape (k,)
        When it was sampled [s].
    force_times, force : arrays, shape (n,)
        Even times [s], and the force; NaN where not known.

    Returns
    -------
    str or None
        None where the position is sampled often enough, or nothing moves.
    """
    force_times, force = force_times[:ENOUGH_FORCE], force[:ENOUGH_FORCE]
    position_times = position_times[: np.searchsorted(position_times, force_times[-1]) + 1]
    known = np.isfinite(force)
    if known.sum() < 16 or position_times.size < 4:
        return None
    frequency = _strongest(force_times, np.where(known, force, np.nanmean(force)))
    step = float(np.median(np.diff(position_times)))
    if frequency == 0.0:
        return None
    a_cycle = 1.0 / (frequency * step)
    has = f"{name} has {a_cycle:.2g} samples a cycle of the force's {frequency:.4g} Hz"
    enough = f"record it at {8 * frequency:.3g} Hz or more"
    if a_cycle <= 2.0:
        return f"{has}: it cannot follow, and stiffness and damping mean nothing; {enough}"
    omega = 2.0 * np.pi * frequency
    truth = np.exp(1j * omega * force_times)
    motion = np.exp(1j * omega * position_times)
    seen = interpolate(position_times, motion.real, force_times) + 1j * interpolate(
        position_times, motion.imag, force_times
    )
    both = np.isfinite(seen.real) & np.isfinite(seen.imag)
    if not both.any():
        return None
    gain = np.vdot(truth[both], seen[both]) / np.count_nonzero(both)
    loss, delay = abs(1.0 / gain) - 1.0, -float(np.angle(gain)) / omega
    scatter = float(np.sqrt(np.mean(np.abs(seen[both] - gain * truth[both]) ** 2)))
    if max(abs(loss), scatter, omega * abs(delay)) < TOLERATED:
        return None
    return (
        f"{has}, too few for a spline: about {100 * scatter:.2g} % of the motion is lost between "
        f"them, stiffness and damping come out {100 * loss:+.2g} % off, the damping by another "
        f"{abs(delay):.2g} s times the stiffness; {enough}"
    )


def _strongest(times: FloatArray, values: FloatArray) -> float:
    """Return the frequency of the line that stands out [Hz]; 0 where none does."""
    centred = values - values.mean()
    if not centred.any():
        return 0.0
    power = np.abs(np.fft.rfft(centred * np.hanning(values.size))) ** 2
    place = int(np.argmax(power[1:])) + 1
    if power[max(place - 2, 1) : place + 3].sum() < LINE_SHARE * power[1:].sum():
        return 0.0
    return place / (values.size * float(np.median(np.diff(times))))
