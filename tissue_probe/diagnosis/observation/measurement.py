"""Samples that a model is compared with: one stretch of a run.

Contents: measured position and force, at which times, and which of them count.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tissue_probe.diagnosis.observation.motion import MotionEstimate
from tissue_probe.diagnosis.observation.noise import UNKNOWN_NOISE, Noise
from tissue_probe.diagnosis.observation.resampling import AS_MEASURED, Resampling
from tissue_probe.diagnosis.residuals.noise_floor import (
    BY_CHANCE,
    EXACT,
    FELT,
    NOISY,
    noise_beside_steps,
    noise_floor,
    noise_not_felt,
)
from tissue_probe.physics.extent import Extent
from tissue_probe.physics.response import USUAL_FINENESS as COARSE
from tissue_probe.physics.response import Between, Fineness
from tissue_probe.physics.rigs import Rig
from tissue_probe.physics.scale import USUAL, Scale
from tissue_probe.physics.smooth_course import at_times
from tissue_probe.quantities import FORCE, Quantity, other
from tissue_probe.recording.clocks.even_grid import interpolate
from tissue_probe.signals import BoolArray, FloatArray

#: Finer steps of the position are digits of its text, not an encoder's [m].
FINEST = 5e-9
#: Time between samples from which a start's promise is told [s]: much less than a coil's period.
OFTEN = 1e-3
#: Noise of a command by the digits that it is written with, in shares of its rms: of four digits.
DIGITS_NOISE = 1e-4
#: Samples at the start from which the velocity there is told.
START_SAMPLES = 8
#: Noise of a channel that has none [its unit]: so little changes nothing, and can be divided by.
LEAST_NOISE = 1e-12
#: Time for which a tip must have been in the tissue [s]: about as long as it rings.
SETTLING_TIME = 15e-3
#: The least length, speed and force of a record [m, m/s, N]: to be divided by.
SMALLEST = 1e-9


@dataclass(frozen=True)
class Measurement:
    """Consecutive samples of one run.

    Attributes
    ----------
    position, force : array, shape (n,)
        Displacement of the coil [m], load-cell force [N], positive in compression; finite. Where
        a force drives: displacement of the tip, and that force, positive into the tissue.
    sample_period : float
        Time between two samples [s].
    at_rest : bool
        Whether the probe had been at rest before the first sample.
    noise : Noise
        Of the output; white, and estimated, where not given.
    used : array of bool, shape (n,)
        Which samples a fit weighs; all by default.
    output : Quantity
        The channel that a model predicts, ``FORCE`` or ``POSITION``; the other one is the input.
    misread : array, shape (n,), optional
        Of a position that was smoothed: one of the errors that it may still have [m].
    motion : Motion, optional
        The estimate of a noisy position that is the input: ``position`` is its mean.
    input_noise : float
        Standard deviation of the white noise of a force that drives, as a model told it [N]; NaN
        where none did: it is no more than the force is rough.
    coil_gain : float
        Way of the coil for each volt of its command [m/V]; NaN where that is not known.
    notes : tuple of str
        The changes made when it was read, in sentences: resampled, filled in, cut.
    source : str
        Where it came from, such as a file; faults of its samples are reported with that name.
    run : str
        Name of the run that it was cut from, others maybe too; without, a run of its own.
    begins : float
        Time of the first sample after the run's first [s].
    resampling : Resampling
        The change of white noise where times were uneven: ``noise`` is that before it.
    between : Between, optional
        How the input goes on from sample to sample. None where that is not known: smoothly then.
    fineness : Fineness
        How finely a response is computed for it.
    at : array, shape (n,), optional
        Time of each sample after the first, where these are not even [s]; ``sample_period`` is that
        of the even times at which a model is simulated then.
    time_doubt : float
        By how much position and force may be apart in time, which nothing tells [s].
    scale : Scale
        The size of the record that it belongs to.
    input2 : array, shape (n,), optional
        A further channel that may drive the force, in its unit; finite.
    """

    position: FloatArray
    force: FloatArray
    sample_period: float
    at_rest: bool = False
    noise: Noise = UNKNOWN_NOISE
    used: BoolArray = None  # type: ignore[assignment]  # all, where none are given
    output: Quantity = FORCE
    misread: FloatArray | None = None
    motion: MotionEstimate | None = None
    input_noise: float = np.nan
    coil_gain: float = np.nan
    notes: tuple[str, ...] = ()
    source: str = ""
    run: str = ""
    begins: float = 0.0
    resampling: Resampling = AS_MEASURED
    between: Between | None = None
    fineness: Fineness = COARSE
    at: FloatArray | None = None
    time_doubt: float = 0.0
    scale: Scale = USUAL
    input2: FloatArray | None = None

    def __post_init__(self) -> None:
        if self.used is None:
            object.__setattr__(self, "used", np.ones(self.force.size, dtype=bool))
        if not self.noise.own > 0:
            drive = self.input_values[self.used]
            floor = self._floor(self.output_values, drive)
            object.__setattr__(self, "noise", self.noise.with_own(floor))

    def _floor(self, output: FloatArray, drive: FloatArray | None = None) -> float:
        floor = noise_floor(output[self.used], drive, np.flatnonzero(self.used))
        return max(floor / self.resampling.left, LEAST_NOISE * self.scale.of(self.output.unit))

    @property
    def counted(self) -> BoolArray:
        """Which samples tell how large an error is, shape (n,)."""
        return self.noise.select_counted(self.used)

    @property
    def position_noise(self) -> float:
        """Standard deviation of the white noise of the position [m].

        0 where the position is only rounded (``NOISY``), and where the force feels its roughness,
        which is motion then (``FELT``). That few values come again and again, as of a sine whose
        period is a whole number of samples, is no step.
        """
        noise, felt = noise_not_felt(self.position, self.force)
        noise /= self.resampling.left
        least = max(NOISY * self.extent.step, EXACT * float(np.ptp(self.position)))
        alike = max(FELT, BY_CHANCE / np.sqrt(self.position.size))
        return noise if noise > least and abs(felt) < alike else 0.0

    @cached_property
    def rounded(self) -> float:
        """Standard deviation of the output's rounding where its noise is nothing else, or 0."""
        output = self.output_values[self.used]
        step = _step(output, EXACT * float(np.ptp(output)))
        return float(step / np.sqrt(12.0)) if self.noise.own < NOISY * step else 0.0

    @cached_property
    def stays_rounded(self) -> float:
        """The part of ``rounded`` that is not white: of samples that repeat the one before."""
        if not self.rounded:
            return 0.0
        repeated = np.diff(self.output_values[self.used]) == 0.0
        return float(self.rounded * np.sqrt(np.mean(repeated)))

    @property
    def is_commanded(self) -> bool:
        """Whether the force that drives is no measurement: it has no noise but that of digits."""
        if self.input is not FORCE:
            return False
        size = float(np.sqrt(np.mean(self.force**2)))
        return noise_beside_steps(self.force) <= DIGITS_NOISE * size

    @property
    def force_noise(self) -> float:
        """Standard deviation of the white noise of a force that drives, at the most [N].

        A command has none: the errors of its digits may add up, but are the same in every run.
        """
        if self.is_commanded:
            return 0.0
        rough = noise_beside_steps(self.force)
        return rough if np.isnan(self.input_noise) else min(rough, self.input_noise)

    @property
    def input(self) -> Quantity:
        """The channel that drives the model."""
        return other(self.output)

    @property
    def input_values(self) -> FloatArray:
        """The samples of the input."""
        values: FloatArray = getattr(self, self.input.name)
        return values

    @property
    def output_values(self) -> FloatArray:
        """The samples of the channel that a model predicts."""
        values: FloatArray = getattr(self, self.output.name)
        return values

    def over_noise(self, values: FloatArray) -> FloatArray:
        """Return values of the output, shape (n, ...), as multiples of its noise; unused ones 0."""
        return self.noise.white(values, self.used) if values.size else values

    @property
    def times(self) -> FloatArray:
        """Time of each sample after the first [s]."""
        if self.at is not None:
            return self.at
        return np.arange(self.position.size, dtype=float) * self.sample_period

    def on_grid(self, values: FloatArray) -> FloatArray:
        """Return values of the input at the even times at which a model is simulated."""
        return self._driven if values is self.input_values else self._take_evenly(values)

    @cached_property
    def _driven(self) -> FloatArray:
        """The input at even times: the same in all responses of a fit."""
        return self._take_evenly(self.input_values)

    def _take_evenly(self, values: FloatArray) -> FloatArray:
        if self.at is None:
            return values
        count = math.ceil(self.at[-1] / self.sample_period - 1e-6) + 1
        even = np.minimum(np.arange(count) * self.sample_period, self.at[-1])
        return interpolate(self.at, values, even, reach=np.inf)

    def interpolate_columns(self, columns: FloatArray) -> FloatArray:
        """Return a simulation's columns, shape (m, ...), at the times of the samples, (n, ...)."""
        if self.at is None:
            return columns
        return at_times(columns, self.sample_period, self.at)

    def approximate(self) -> Measurement:
        """Return the same with noise that puts starts in order as well, and costs less."""
        return replace(self, noise=self.noise.approximate())

    def thin_samples(self) -> Measurement:
        """Return the same in as few samples as tell which start of a search promises most.

        A filter that whitens needs all samples.
        """
        times = int(OFTEN * self.scale.time / self.sample_period + 1e-6)
        if times < 2 or not self.noise.is_white or self.at is not None:
            return self
        few = self._keep_only(slice(None, None, times))
        return replace(few, sample_period=self.sample_period * times, resampling=AS_MEASURED)

    def since(self, first: int, rig: Rig) -> Measurement:
        """Return the samples from one on, before which the tip touched nothing.

        Then no branch of a tissue is under load; the tip of a rig with a spring is moving, though.
        """
        return replace(
            self._keep_only(slice(first, None)),
            motion=None if self.motion is None else self.motion.since(first),
            at_rest=self.at_rest or rig.tip_is_position,
            begins=self.begins + float(self.times[first]),
        )

    def take_beginning(self, count: int) -> Measurement:
        """Return the first samples only."""
        return replace(self._keep_only(slice(count)), motion=None)

    def without(self, samples: BoolArray) -> Measurement:
        """Return the same, with some samples not used; its noise is estimated from the others."""
        if not samples.any():
            return self
        return replace(self, used=self.used & ~samples, noise=self.noise.restart_estimate())

    def within(self, residual: FloatArray, colour: bool = True) -> Measurement:
        """Return the same with no more noise than a model's residual, shape (n,), has.

        Where the model may lack an effect, the residual has the ``colour`` of that, and tells none.
        """
        own = min(self.noise.own, max(self._floor(residual), self.rounded))
        noise, of_input = self.noise.within(residual, self.used, own, colour)
        told = self.input_noise if np.isnan(of_input) else of_input
        return replace(self, noise=noise, input_noise=told)

    def _keep_only(self, kept: slice) -> Measurement:
        """Return some of the samples; their period, and the estimate of a motion, stay."""
        return replace(
            self,
            position=self.position[kept],
            force=self.force[kept],
            used=self.used[kept],
            misread=None if self.misread is None else self.misread[kept],
            input2=None if self.input2 is None else self.input2[kept],
            at=None if self.at is None else self.at[kept] - self.at[kept][0],
            noise=self.noise.of_some(),
        )

    def find_pressed(self, stiffness: float) -> BoolArray:
        """Which samples were taken with the tip in the tissue for 15 ms and more.

        The indentation is u - F / k0, ``stiffness`` being the load cell's k0 [N/m]; it must exceed
        a tenth of the coil's travel.
        """
        indentation = self.position - self.force / stiffness
        inside = indentation > 0.1 * self.extent.indentation
        settling = max(1, round(SETTLING_TIME * self.scale.time / self.sample_period))
        outside = np.convolve(~inside, np.ones(settling))[: inside.size] > 0.5
        return self.used & ~outside

    @cached_property
    def first_speed(self) -> float:
        """Velocity of the position at the first sample [m/s], by the parabola of the first few."""
        few = slice(0, START_SAMPLES)
        parabola = np.polynomial.Polynomial.fit(self.times[few], self.position[few], 2)
        return float(parabola.deriv()(0.0))

    @cached_property
    def extent(self) -> Extent:
        """How far position, speed and force reach."""
        rate = np.abs(np.diff(self.position) / np.diff(self.times))
        scale = self.scale
        return Extent(
            duration=float(self.times[-1]) + self.sample_period,
            indentation=float(np.ptp(self.position)) / 2 + SMALLEST * scale.length,
            depth=float(np.max(self.position)),
            speed=float(np.quantile(rate, 0.99)) + SMALLEST * scale.of("m/s"),
            force=float(np.std(self.force)) + SMALLEST * scale.force,
            pull=max(-float(np.min(self.force)), 0.0),
            step=_step(self.position[self.used], FINEST * scale.length),
        )


def _step(position: FloatArray, finest: float) -> float:
    """Return the step of which all differences of position are multiples [m]; 0 if there is none.

    Found as Euclid finds a common divisor: the remainder of the smallest is the next smallest.
    """
    moves = np.unique(np.abs(np.diff(position)))
    step = np.min(moves[moves > finest], initial=np.inf)
    while finest < step < np.inf:
        off = np.abs(moves - step * np.rint(moves / step))
        left = off[off > 0.05 * step]
        if not left.size:
            times = np.rint(moves / step)
            return float(moves @ times / (times @ times))
        step = np.min(left)
    return 0.0
