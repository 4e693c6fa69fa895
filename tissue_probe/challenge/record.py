"""From a record of positions to a motion that can be simulated.

Contents: what a record must be to be followed, its band, the spline through it.
"""

from __future__ import annotations

import numpy as np
from scipy.fft import dct
from scipy.interpolate import BSpline, CubicSpline, make_lsq_spline
from scipy.ndimage import uniform_filter1d
from scipy.signal import welch

from tissue_probe.challenge.instrument import CHALLENGE_RATE
from tissue_probe.challenge.measured_motion import Measured, time_scale
from tissue_probe.errors import ParameterError
from tissue_probe.signals import FloatArray

SHORTEST, LONGEST = 0.2, 60.0
"""Durations of records that are followed [s]."""

SMALLEST, LARGEST = 10e-6, 5e-3
"""Amplitudes that are [m]: less leaves no force to hide an effect in, more is no palpation."""

DEEPEST = 10e-3
"""Largest displacement from the tissue's surface [m]."""

LIFTED = 0.5
"""How far the mean may lie above the surface, over the amplitude [-]."""

FEWEST_SAMPLES = 100  # samples of a record
MISSED = 3  # samples in a row that may be missing or not known
A_CYCLE = 2.5  # samples of a cycle of the fastest motion, at least
POWER_SHARE = 0.98  # of the power of a motion, which lies below its highest frequency
RESOLVED, BINS = 0.5, 5  # s, of which spectra are made to find the band, and lines taken together
SPECTRUM_WINDOW = (
    "general_cosine",
    (0.375, 0.5, 0.125),
)  # Hann's, squared: large motions leak less
ABOVE = 4.0  # times the noise: power that is motion
KNOTS = 8.0  # of a spline to a cycle of the band's end: it is off by less than 1e-5 there
REST_SPEED = 0.1  # speed over its rms, below which a record begins at rest


def follow(
    time: FloatArray, position: FloatArray, source: str, at_rest: bool | None = None
) -> Measured:
    """Return the motion in a record of positions.

    What is faster than the band in which the record rises above its noise is left out, so that the
    coil is not driven by an encoder's rounding.

    Parameters
    ----------
    time, position : arrays, shape (n,)
        Evenly spaced times [s], and displacements of the coil [m] from the tissue's surface,
        positive into the tissue. Up to three samples in a row may be missing, or NaN.
    source : str
        Where they come from, for answers and messages.
    at_rest : bool, optional
        Whether the coil had rested before; by default it had if it sets out slowly.

    Raises
    ------
    ValueError
        If the record is too short or too long, has gaps, hardly moves or moves too far or too fast
        for its samples.
    """
    known = np.isfinite(time) & np.isfinite(position)
    time, position = time[known], position[known]
    _check_time(time, source)
    time, period = time - time[0], float(np.median(np.diff(time)))
    preload = float(position.mean())
    grid = np.arange(int(time[-1] / period + 1e-6) + 1, dtype=float) * period
    moved = CubicSpline(time, position - preload)(grid)
    highest = _highest(moved, period)
    _check_motion(moved, preload, highest * period, source)
    course = _smooth_motion(grid, moved)
    duration = (int(time[-1] * CHALLENGE_RATE + 1e-6) + 1) / CHALLENGE_RATE
    amplitude = float(np.abs(course(grid)).max())
    course = BSpline(course.t, course.c / amplitude, course.k)
    rested = _sets_out_slowly(course, duration) if at_rest is None else at_rest
    return Measured(source, rested, duration, preload, amplitude, highest, course)


def _check_time(time: FloatArray, source: str) -> None:
    """Refuse records that are too short, too long, or have gaps."""
    if time.size < FEWEST_SAMPLES:
        raise ParameterError(
            f"{source}: {time.size} positions are known; give {FEWEST_SAMPLES} at least"
        )
    steps = np.diff(time)
    usual = float(np.median(steps))
    lasts = time[-1] - time[0] + usual
    if steps.min() <= 0.0:
        raise ParameterError(f"{source}: its times do not ascend; sort its rows")
    if not SHORTEST <= round(lasts, 6) <= LONGEST:
        raise ParameterError(
            f"{source} lasts {lasts:.4g} s; give a record of {SHORTEST:g} to {LONGEST:g} s"
        )
    longest = int(np.argmax(steps))
    if steps[longest] > (MISSED + 1.5) * usual:
        raise ParameterError(
            f"{source}: no position is known for {steps[longest]:.4g} s, "
            f"{time[longest] - time[0]:.4g} s after the first; give a part without gaps"
        )


def _check_motion(moved: FloatArray, preload: float, pace: float, source: str) -> None:
    """Refuse what hardly moves, too far, or in too few samples; ``pace`` is in cycles a sample."""
    amplitude = float(np.abs(moved).max())
    if amplitude < SMALLEST:
        raise ParameterError(
            f"{source}: the coil moves by {1e6 * amplitude:.3g} um at most, which shows nothing; "
            f"give a motion of {1e6 * SMALLEST:g} um at least"
        )
    if amplitude > LARGEST or preload + amplitude > DEEPEST:
        raise ParameterError(
            f"{source}: the coil moves by {1e3 * amplitude:.3g} mm about {1e3 * preload:.3g} mm; "
            f"effects are scaled for up to {1e3 * LARGEST:g} mm, {1e3 * DEEPEST:g} mm deep: give "
            "u in metres, from the tissue's surface"
        )
    if preload < -LIFTED * amplitude:
        raise ParameterError(
            f"{source}: the coil is {-1e3 * preload:.3g} mm above the tissue's surface on average; "
            "give u from there, positive into the tissue"
        )
    if A_CYCLE * pace > 1.0:
        raise ParameterError(
            f"{source}: the position moves as fast as its samples can tell; give {A_CYCLE:g} "
            "samples to a cycle at least"
        )


def _highest(moved: FloatArray, period: float) -> float:
    power = dct(moved) ** 2  # which knows no jump from the record's end to its beginning
    place = np.searchsorted(np.cumsum(power), POWER_SHARE * power.sum())
    return max(float(place) / (2.0 * moved.size * period), 1.0)


def _smooth_motion(grid: FloatArray, moved: FloatArray) -> BSpline:
    """Fit a quintic spline whose knots are as close as the band in which there is motion asks."""
    period = grid[1]
    length = min(round(RESOLVED / period), moved.size)
    frequency, power = welch(moved, 1.0 / period, SPECTRUM_WINDOW, length, detrend="linear")
    moving = uniform_filter1d(power, BINS) > ABOVE * np.mean(power[power.size // 2 :])
    band = max(frequency[moving].max(initial=0.0), BINS / RESOLVED)
    # No closer than the samples can tell, or those of the recordings that are made.
    apart = max(1.0 / (KNOTS * band), 1.25 * period, 1.0 / CHALLENGE_RATE)
    inner = np.linspace(0.0, grid[-1], int(grid[-1] / apart) + 1)
    # Two less at either end: there the samples tell no more than elsewhere.
    knots = np.concatenate([np.zeros(6), inner[3:-3], np.full(6, grid[-1])])
    return make_lsq_spline(grid, moved, knots, k=5)


def _sets_out_slowly(course: BSpline, duration: float) -> bool:
    """Whether the speed is next to nothing for as long as a motion takes to cross its rms."""
    speed = course.derivative()
    first = speed(np.linspace(0.0, time_scale(course, duration), FEWEST_SAMPLES))
    everywhere = speed(np.arange(0.0, duration, 1.0 / CHALLENGE_RATE))
    return bool(np.mean(first**2) < REST_SPEED**2 * np.mean(everywhere**2))
