"""What errors of a noisy position leave in the output of a model that it drives.

What belongs here: how such errors go on from sample to sample, and what is white beside them. What
does not: the motion (``motion``), noise of a force that drives (``coloured``).

An error of the position is a chain: each value follows from the three before and something new
(``Motion.chain``). The output has a few neighbours of it, each times a tap, and its own white
noise; where the tip moves by itself, it rings with what it felt before. Kalman's filter then tells
of each sample what the earlier ones let expect; the rest, over its deviation, is white and of
variance 1 (B. Anderson, J. Moore, Optimal Filtering (1979), section 5.3).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.motion import Felt, Motion, motion
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.signals import BoolArray, FloatArray

#: Neighbours on either side whose errors an output feels: the spline through the samples forgets
#: one by a factor of 3.7, and the derivative that it has there by the slope of a straight line of
#: so many to 3 %.
NEAR = 4
#: How many of the samples before a tip that moves by itself remembers: a resonance has two, and
#: what relaxes beside it one each.
REMEMBERED = 2
#: What is fainter than this share of the output's own noise is left aside.
FAINT = 0.1
#: Errors drawn to tell the taps: of some hundred samples each then tells them to a twentieth.
DRAWS = 4


@dataclass(frozen=True)
class Shaken:
    """Noise that an error of the position makes in the output.

    Attributes
    ----------
    chain : array, shape (n, 4)
        Of the error at each sample: the weights of the three before, and the deviation of what is
        new [m].
    taps : array, shape (2 NEAR + 1,)
        What the error of each neighbour does to the output, the latest first [unit / m].
    beside : float
        Deviation of what the taps do not tell [unit of the output].
    memory : array, shape (k,)
        What a sample has of what each of the k before felt, the latest first [-].
    size : float
        Deviation of all that it makes in the output [unit of the output].
    """

    chain: FloatArray
    taps: FloatArray
    beside: float
    memory: FloatArray = field(default_factory=lambda: np.zeros(0))
    size: float = 0.0

    def times(self, factor: float) -> Shaken:
        """Return the same for errors of the position that are so many times larger."""
        chain = self.chain * (1.0, 1.0, 1.0, factor)
        return replace(self, chain=chain, beside=factor * self.beside, size=factor * self.size)

    def innovations(self, noise: float, used: BoolArray) -> tuple[FloatArray, FloatArray]:
        """Return gains, shape (n, taps + k + 1), and deviations, shape (n,), of Kalman's filter.

        Parameters
        ----------
        noise : float
            Standard deviation of the output's own white noise [its unit].
        used : array of bool, shape (n,)
            Which samples count; the deviation of the others is infinite, and that of the first and
            last few: they lack neighbours, and the course through the samples is bound less there.
        """
        from tissue_probe.diagnosis.fitting.innovations import gains  # compiled code, seldom needed

        return gains(
            self.chain, self.taps, self.memory, noise**2, self.beside**2, self.inside(used)
        )

    def inside(self, used: BoolArray) -> BoolArray:
        """Return which of the samples that count have neighbours on both sides, shape (n,)."""
        inside = used.copy()
        inside[:NEAR] = inside[-NEAR:] = False
        return inside

    def white(self, columns: FloatArray, gains: FloatArray, deviations: FloatArray) -> FloatArray:
        """Return what each sample of columns, shape (n, m), has beside what those before tell."""
        from tissue_probe.diagnosis.fitting.innovations import white

        columns = np.ascontiguousarray(columns)
        return white(self.chain, self.taps, self.memory, gains, deviations, columns)


def felt(fit: Fit) -> list[Measurement]:
    """Return the measurements of a fit, their motions told by what the output shows of them, too.

    Of a channel that is more precise than the position: where a corner of the motion is hidden in
    its noise, the output shows it. Not where that rings: what it shows of a corner comes late.
    """
    return [
        each
        if each.motion is None or each.shaken is None or each.shaken.memory.size
        else _felt(each, each.motion, each.shaken, fit.residuals[index])
        for index, each in enumerate(fit.measurements)
    ]


def felt_anew(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    """Return the measurements of a fit with motions that the output shows by it; None if none move.

    The motion was told by a model that lacks an effect: where that moved it away from its samples,
    the output told nothing.
    """
    if all(each.motion is None for each in fit.measurements):
        return None
    seen = replace(fit, measurements=tuple(shaken(fit, instrument)))
    told = felt(seen)
    pairs = zip(told, fit.measurements, strict=True)
    if not any(_moved(*pair) for pair in pairs):
        return None
    return shaken(replace(fit, measurements=tuple(told)), instrument)


def _moved(new: Measurement, old: Measurement) -> bool:
    if old.motion is None:
        return False
    moved = float(np.sqrt(np.mean((new.position - old.position) ** 2)))
    return moved > FAINT * old.motion.noise


def _felt(
    measurement: Measurement, known: Motion, noise: Shaken, residual: FloatArray
) -> Measurement:
    shown = Felt(
        residual, measurement.position, noise.taps, np.hypot(measurement.noise, noise.beside)
    )
    told = motion(known.samples, known.noise, shown).surer(known.share)
    return replace(measurement, position=told.position, motion=told, shaken=None)


def no_louder(fit: Fit) -> list[Measurement]:
    """Return the measurements of a fit, errors of the position no larger than its residual is.

    They are told from how the motion changes from sample to sample. A motion that changes less at
    random than that, such as a sine, has smaller ones. An effect that a model lacks makes its
    residual larger, never smaller.
    """
    return [
        each if each.shaken is None else _limited(each, each.shaken, misfit / np.sum(each.used))
        for each, misfit in zip(fit.measurements, fit.misfits, strict=True)
    ]


def _limited(measurement: Measurement, noise: Shaken, left: float) -> Measurement:
    """Return a measurement whose noise is so large that of its square this share is left."""
    square = left * measurement.noise_power - measurement.noise**2
    if square >= noise.size**2:
        return measurement
    told = noise.times(np.sqrt(square) / noise.size) if square > 0.0 else None
    return replace(measurement, shaken=told)


def shaken(fit: Fit, instrument: Instrument) -> list[Measurement]:
    """Return the measurements of a fit with the noise that errors of the position leave in each.

    Errors are drawn as the samples of the position leave them possible, and the model is run with
    each.
    """
    problem = Problem(fit.composition, fit.measurements, instrument)
    return [
        each
        if each.motion is None
        else replace(each, shaken=_shaken(problem, fit, index, each.motion))
        for index, each in enumerate(fit.measurements)
    ]


def _shaken(problem: Problem, fit: Fit, index: int, motion: Motion) -> Shaken | None:
    position, random = fit.measurements[index].position, np.random.default_rng(0)
    values, start = fit.values, fit.starts[index]
    right = problem.response(index, position, values, start).output
    errors = [motion.error(random) for _ in range(DRAWS)]
    changes = [
        problem.response(index, position + error, values, start).output - right for error in errors
    ]
    # Where samples are left out the model may switch with an error: that is no sum of taps.
    inside = NEAR + np.flatnonzero(fit.measurements[index].used[NEAR:-NEAR])
    change = np.concatenate([each[inside] for each in changes])
    shaken_by = float(np.sqrt(np.mean(change**2)))
    if not shaken_by > FAINT * fit.measurements[index].noise:
        return None
    rings = REMEMBERED if "free" in problem.kernel.spreads else 0
    felt = np.concatenate(
        [
            np.column_stack([_neighbours(error), _before(own, rings)])[inside]
            for error, own in zip(errors, changes, strict=True)
        ]
    )
    size = np.sqrt(np.mean(felt**2, axis=0))
    told = np.linalg.lstsq(felt / size, change, rcond=None)[0] / size
    taps, memory = np.split(told, [2 * NEAR + 1])
    beside = float(np.std(change - felt @ told))
    return Shaken(motion.chain(), taps, beside, memory, shaken_by)


def _before(change: FloatArray, count: int) -> FloatArray:
    """Return of each sample so many before it, the latest first, shape (n, count)."""
    before = [np.concatenate([np.zeros(lag), change[:-lag]]) for lag in range(1, count + 1)]
    return np.stack(before, axis=1) if before else np.zeros((change.size, 0))


def _neighbours(error: FloatArray) -> FloatArray:
    """Return the neighbours of each sample, the latest first, shape (n, 2 NEAR + 1)."""
    padded = np.pad(error, NEAR)
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * NEAR + 1)[:, ::-1]
