"""Errors of a noisy position, as a model that it drives feels them.

Contents: the noise that they leave in the output, the motion as the output shows it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.observation.chained_noise import NEAR, Chained
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.motion import MotionEstimate, MotionInformation, motion
from tissue_probe.diagnosis.observation.noise import FAINT_NOISE, Noise, faint
from tissue_probe.signals import FloatArray

#: How many of the samples before a tip that moves by itself remembers: a resonance has two, and
#: each relaxing branch beside it has one.
SAMPLES_REMEMBERED = 2
#: Errors drawn to tell the taps: of some hundred samples each then tells them to a twentieth.
TAP_DRAWS = 4


def estimate_motions(fit: Fit) -> list[Measurement]:
    """Return the measurements of a fit, their motions estimated from the output, too.

    Of a channel that is more precise than the position: where a corner of the motion is hidden in
    its noise, the output shows it. Not where the output rings: there a corner shows late.
    """
    pairs = zip(fit.measurements, fit.residuals, strict=True)
    return [_estimate_motion(each, each.motion, each.noise, residual) for each, residual in pairs]


def estimate_motion_anew(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    """Return the measurements of a fit with motions that the output shows by it; None if none move.

    The motion was told by a model that lacks an effect: where that moved it away from its samples,
    the output told nothing.
    """
    if all(each.motion is None for each in fit.measurements):
        return None
    seen = replace(fit, measurements=tuple(add_position_noise(fit, instrument)))
    told = estimate_motions(seen)
    pairs = zip(told, fit.measurements, strict=True)
    if not any(_has_moved(*pair) for pair in pairs):
        return None
    return add_position_noise(replace(fit, measurements=tuple(told)), instrument)


def _has_moved(new: Measurement, old: Measurement) -> bool:
    if old.motion is None:
        return False
    moved = float(np.sqrt(np.mean((new.position - old.position) ** 2)))
    return moved > FAINT_NOISE * old.motion.noise


def _estimate_motion(
    measurement: Measurement, known: MotionEstimate | None, noise: Noise, residual: FloatArray
) -> Measurement:
    if known is None or not isinstance(noise, Chained) or noise.memory.size:
        return measurement
    shown = MotionInformation(
        residual, measurement.position, noise.taps, np.hypot(noise.own, noise.beside)
    )
    told = motion(known.samples, known.noise, shown).surer(known.share)
    return replace(measurement, position=told.position, motion=told, noise=Noise(noise.own))


def no_louder(fit: Fit) -> list[Measurement]:
    """Return the measurements of a fit, errors of the position no larger than its residual is.

    An effect that a model lacks makes its residual larger, never smaller.
    """
    pairs = zip(fit.measurements, fit.residuals, strict=True)
    return [each if each.noise.is_white else each.within(residual) for each, residual in pairs]


def add_position_noise(fit: Fit, instrument: Instrument) -> list[Measurement]:
    """Return the measurements of a fit with the noise that errors of the position leave in each.

    Errors are drawn as the samples of the position leave them possible, and the model is run with
    each.
    """
    problem = Problem(fit.composition, fit.measurements, instrument)
    return [
        each
        if each.motion is None
        else replace(each, noise=_noise(problem, fit, index, each.motion))
        for index, each in enumerate(fit.measurements)
    ]


def _noise(problem: Problem, fit: Fit, index: int, motion: MotionEstimate) -> Noise:
    measurement, random = fit.measurements[index], np.random.default_rng(0)
    position, white = measurement.position, Noise(measurement.noise.own)
    values, start = fit.values, fit.starts[index]
    right = problem.response(index, position, values, start).output
    errors = [motion.error(random) for _ in range(TAP_DRAWS)]
    changes = [
        problem.response(index, position + error, values, start).output - right for error in errors
    ]
    # Where samples are left out the model may switch with an error: that is no sum of taps.
    inside = NEAR + np.flatnonzero(measurement.used[NEAR:-NEAR])
    change = np.concatenate([each[inside] for each in changes])
    if faint(change, white):
        return white
    rings = SAMPLES_REMEMBERED if "free" in problem.kernel.spreads else 0
    felt = np.concatenate(
        [
            np.column_stack([_neighbours(error), _before(own, rings)])[inside]
            for error, own in zip(errors, changes, strict=True)
        ]
    )
    sizes = np.sqrt(np.mean(felt**2, axis=0))
    told = np.linalg.lstsq(felt / sizes, change, rcond=None)[0] / sizes
    taps, memory = np.split(told, [2 * NEAR + 1])
    beside = float(np.std(change - felt @ told))
    size = float(np.sqrt(np.mean(change**2)))
    return Chained(white.own, motion.chain(), taps, beside, memory, size)


def _before(change: FloatArray, count: int) -> FloatArray:
    """Return of each sample so many before it, the latest first, shape (n, count)."""
    before = [np.concatenate([np.zeros(lag), change[:-lag]]) for lag in range(1, count + 1)]
    return np.stack(before, axis=1) if before else np.zeros((change.size, 0))


def _neighbours(error: FloatArray) -> FloatArray:
    """Return the neighbours of each sample, the latest first, shape (n, 2 NEAR + 1)."""
    padded = np.pad(error, NEAR)
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * NEAR + 1)[:, ::-1]
