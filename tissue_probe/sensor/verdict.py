"""Whether a fit explains its wrench, and if not, with which course the rest goes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tissue_probe.sensor.cable import CableFunctions
from tissue_probe.sensor.fit import SensorFit
from tissue_probe.sensor.free_air import WRENCH_AXES, FreeAir
from tissue_probe.sensor.kinematics import motion
from tissue_probe.sensor.smoothed_air import Smoothed
from tissue_probe.sensor.smoothing import Smoother
from tissue_probe.signals import FloatArray

TEST_SIZE = 0.1
"""Less beyond noise than this part of a sample's noise is nobody's concern: with it a sample varies
by half a per cent more."""
LEAST_CONCERN = 0.5
"""A cause that explains less than this part of the rest is not named: of causes that have nothing
in common one alone explains more."""
BRIEF = 0.05
"""A touch: in this part of the time lies ``LEAST_CONCERN`` of the rest. A rest that lasts has less
there: a sine a tenth, noise three tenths."""
WAVES = 8
"""Half waves of time that a wander may have: half a minute in four minutes."""
FRICTION_SLOW = 1.0 / 3.0
"""Friction changes its side within this part of the usual speed: a step would follow the noise of
speeds near 0, and the speed itself has a column of its own."""
STANDSTILL = 1e-9
"""Less is no usual speed [rad/s]: nothing turns."""
ROUNDED_COLUMN = 1e-6
"""A function of which this part is left beside the others is none [of the largest]: digits of poses
are 1e-6 of a metre or a radian."""


def missing_effects(
    found: SensorFit, runs: Sequence[FreeAir], smoothed: Sequence[Smoothed], cabled: bool
) -> list[str]:
    """Return in sentences the effects in the wrench beyond the fit and noise, if any.

    Parameters
    ----------
    found : Fit
        Of the stretches.
    runs, smoothed : sequence of FreeAir, of Smoothed
        The stretches.
    cabled : bool
        Whether a cable is part of the fit already.
    """
    noise = np.sqrt(np.mean([run.noise**2 for run in smoothed], axis=0))
    beyond = np.sqrt(found.belief.unexplained)
    axes = [axis for axis in range(6) if beyond[axis] > TEST_SIZE * noise[axis]]
    if not axes:
        return []
    rest = np.concatenate(found.left)[:, axes] / np.sqrt(found.expected[axes])
    size = ", ".join(f"{WRENCH_AXES[axis]} {beyond[axis]:.2g}" for axis in axes)
    return [f"{_named(rest, runs, smoothed, cabled)}: beyond noise is left {size} [N, N m] rms"]


def _named(
    rest: FloatArray, runs: Sequence[FreeAir], smoothed: Sequence[Smoothed], cabled: bool
) -> str:
    time = np.concatenate([run.time for run in smoothed])
    power = np.sum(rest**2, axis=1)
    excess = float(power.sum()) - rest.size
    brief = np.sort(power)[::-1][: max(1, round(BRIEF * len(power)))]
    if brief.sum() - brief.size * rest.shape[1] > LEAST_CONCERN * excess:
        when = float(time[np.argmax(power)])
        return f"the wrench is disturbed for a short time about {when:.1f} s (was it touched?)"
    share = (time - time.min()) / np.ptp(time)
    waves = np.cos(np.pi * share[:, None] * np.arange(1, WAVES + 1))
    causes = {"bias that wanders in time, not along a line": waves}
    speeds = [_resampled(run, each) for run, each in zip(runs, smoothed, strict=True)]
    rates = np.concatenate(speeds)
    both = np.concatenate(
        [rates, np.tanh(rates / (FRICTION_SLOW * max(float(rates.std()), STANDSTILL)))], axis=1
    )
    causes["force that goes with the speed of turning (friction or hysteresis of a cable)"] = both
    if not cabled:
        functions = CableFunctions.about(list(runs))
        passed = [Smoothed(run, functions) for run in runs]
        causes["force that goes with the pose (a cable, or gains that depend on each other)"] = (
            np.concatenate([each.cable(0.0) for each in passed])
        )
    parts = {name: _explained(columns, rest) / excess for name, columns in causes.items()}
    best = max(parts, key=lambda name: parts[name])
    if parts[best] > LEAST_CONCERN:
        return best
    if cabled:
        return (
            "force that the cable's functions do not follow (tell the joints' angles, if not told)"
        )
    return "something that goes neither with time, nor pose, nor speed (contact, or vibration)"


def _resampled(run: FreeAir, smoothed: Smoothed) -> FloatArray:
    """Return angular velocities at the coarse times, filtered as the wrench is, shape (n, 3)."""
    rate = motion(run.position, run.orientation, run.period).rate
    fine = run.begin + run.period * np.arange(1, len(run.wrench) - 1)
    smooth = Smoother(run.period)
    fine = fine[smooth.half : len(fine) - smooth.half]
    return np.stack([np.interp(smoothed.time, fine, each) for each in smooth(rate).T], axis=1)


def _explained(columns: FloatArray, rest: FloatArray) -> float:
    """Return how much of the power columns explain, beyond the part by chance."""
    columns = columns - columns.mean(axis=0)
    left, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    left = left[:, sizes > ROUNDED_COLUMN * sizes[0]]
    return float(np.sum((left.T @ rest) ** 2) - left.shape[1] * rest.shape[1])
