"""What load cell, encoder and converter make of force and position.

Contents: gain, offset, lag, delay, lines, noise, encoder errors, clipping, stuck channels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from tissue_probe.signals import FloatArray

CHALLENGE_RATE = 2_000
"""Samples a second [Hz]."""

FORCE_NOISE = 0.005
"""Standard deviation of the white noise of the force [N]."""

ENCODER_STEP = 1e-7
"""Resolution of a sound encoder [m]."""


@dataclass(frozen=True)
class InstrumentErrors:
    """Errors of the two channels; SI units, defaults without effect.

    Attributes
    ----------
    gain : float
        The force reads 1 + gain times too much [-].
    bias, drift : float
        Added to the force: constant [N], and by time since the first sample [N/s].
    hum, hum_frequency, hum_phase : float
        Amplitude [N], frequency [Hz] and phase [rad] of a sine on the force.
    settling, settling_time : float
        Force added that comes up as 1 - exp(-t / settling_time) [N], [s].
    jump, jump_time : float
        Force added from a time on [N], [s].
    burst, burst_frequency, burst_period : float
        Amplitude of a sine on the force [N], its frequency [Hz], and the time between the starts
        of its bursts, each a third as long [s].
    lag, delay : float
        Time constant of a first-order low-pass and pure delay of the force channel [s].
    encoder_step : float
        Resolution of the encoder [m].
    ripple, grating, ripple_phase : float
        Amplitude of the encoder's error [m], its period in the position [m], phase [rad].
    clipped : float
        Share of the force's range, from its top, that the converter cannot tell.
    stuck : int
        Samples for which the force channel repeats its value at a time; 0 for never.
    stuck_times : tuple of float
        When it does, as shares of the record.
    contact_zero : float
        What the position reads where the tip touches the surface [m].
    pink_noise : float
        Rms of 1/f noise on the force [N].
    """

    gain: float = 0.0
    bias: float = 0.0
    drift: float = 0.0
    hum: float = 0.0
    hum_frequency: float = 50.0
    hum_phase: float = 0.0
    settling: float = 0.0
    settling_time: float = 1.0
    jump: float = 0.0
    jump_time: float = 0.0
    burst: float = 0.0
    burst_frequency: float = 137.3
    burst_period: float = 0.7
    lag: float = 0.0
    delay: float = 0.0
    encoder_step: float = ENCODER_STEP
    ripple: float = 0.0
    grating: float = 20e-6
    ripple_phase: float = 0.0
    clipped: float = 0.0
    stuck: int = 0
    stuck_times: tuple[float, ...] = ()
    contact_zero: float = 0.0
    pink_noise: float = 0.0

    def force(self, force: FloatArray, rate: int, before: int, noise: FloatArray) -> FloatArray:
        """Return what the force channel gives, sampled at 2 kHz.

        Parameters
        ----------
        force : array, shape (before + n * rate / 2000,)
            On the load cell [N], positive in compression, at ``rate`` [Hz].
        rate : int
            A multiple of 2 kHz.
        before : int
            Values of ``force`` before the first sample.
        noise : array, shape (n,)
            Added before the converter clips or repeats [N].
        """
        late = self._late(force, rate)[before :: rate // CHALLENGE_RATE]
        time = np.arange(late.size) / CHALLENGE_RATE
        return self._convert_force((1.0 + self.gain) * late + self._add_disturbances(time) + noise)

    def position(self, u: FloatArray) -> FloatArray:
        """Return what the encoder reads [m] at the coil's displacements [m]."""
        angle = 2.0 * np.pi * u / self.grating + self.ripple_phase
        read = u + self.contact_zero + self.ripple * np.sin(angle)
        return np.round(read / self.encoder_step) * self.encoder_step

    def _late(self, force: FloatArray, rate: int) -> FloatArray:
        """Delay, then smooth: y' = (F - y) / lag, exact for a force linear between two steps."""
        if self.delay:
            steps = np.arange(force.size)
            at = np.maximum(steps - self.delay * rate, 0.0)
            force = CubicSpline(steps, force)(at)
        if self.lag:
            x = 1.0 / (rate * self.lag)
            pole = np.exp(-x)
            new, old = 1.0 + np.expm1(-x) / x, -np.expm1(-x) / x - pole
            start = np.array([force[0] * (1.0 - new)])
            force = lfilter([new, old], [1.0, -pole], force, zi=start)[0]
        return force

    def _add_disturbances(self, time: FloatArray) -> FloatArray:
        added = self.bias + self.drift * time
        added += self.hum * np.sin(2.0 * np.pi * self.hum_frequency * time + self.hum_phase)
        added -= self.settling * np.expm1(-time / self.settling_time)
        added += self.jump * (time >= self.jump_time)
        if self.burst:
            on = np.mod(time, self.burst_period) > self.burst_period * 2.0 / 3.0
            added += self.burst * on * np.sin(2.0 * np.pi * self.burst_frequency * time)
        return added

    def _convert_force(self, force: FloatArray) -> FloatArray:
        if self.clipped:
            force = np.minimum(force, force.max() - self.clipped * np.ptp(force))
        for share in self.stuck_times if self.stuck else ():
            first = round(share * (force.size - self.stuck - 1))
            force[first : first + self.stuck] = force[first]
        return force


def pink_noise(count: int, random: np.random.Generator) -> FloatArray:
    """Return noise whose power falls as 1/f from 1 / duration to 1 kHz, rms 1 (expected)."""
    frequency = np.fft.rfftfreq(count, 1.0 / CHALLENGE_RATE)
    weight = np.zeros_like(frequency)
    weight[1:] = frequency[1:] ** -0.5
    shaped = np.fft.irfft(np.fft.rfft(random.standard_normal(count)) * weight, count)
    noise: FloatArray = shaped / np.sqrt(np.sum(weight[1:] ** 2) * 2.0 / count)
    return noise
