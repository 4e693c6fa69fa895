"""A further channel that drives the tip of a clean specimen: its force in closed form.

A clean specimen is linear: the force of the channel adds to that of the motion, and passes the tip
as (k0 + beta0 s) / (m s^2 + (beta0 + beta) s + k0 + k).

Contents: the course of a channel, its force, and how strong it is made.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lsim

from tissue_probe.challenge.change import log_uniform
from tissue_probe.challenge.instrument import CHALLENGE_RATE, FORCE_NOISE
from tissue_probe.challenge.kelvin_voigt import fit_residual
from tissue_probe.challenge.simulator import Challenge, HiddenTruth, SimulatedRecord
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.signals import FloatArray

#: A pressure that swings by itself, as a pump's [kPa].
MEAN, SWING = 12.0, 3.0
#: Corrections of the strength: the residual grows about as the strength, so that few are enough.
CORRECTIONS = 4


@dataclass(frozen=True)
class ChannelLaw:
    """A force c (v + square v^2) on the tip, v = w / MEAN after a lag.

    Attributes
    ----------
    strength : float
        c [N], positive against indentation.
    square : float
        Share of the square [-]; 0: a gain alone.
    lag : float
        Time constant of the first-order lag [s]; 0: none.
    """

    strength: float
    square: float
    lag: float

    def drive(self, channel: FloatArray, tip: Specimen) -> FloatArray:
        """Return the measured force of a channel that was still until the first sample [N]."""
        felt = channel / MEAN
        if self.lag:
            felt = felt[0] + _pass((1.0,), (self.lag, 1.0), felt - felt[0])
        push = self.strength * (felt + self.square * felt**2)
        k0, beta0 = tip.load_cell_stiffness, tip.load_cell_damping
        poles = (tip.tip_mass, beta0 + tip.damping, k0 + tip.stiffness)
        return push[0] * k0 / poles[-1] + _pass((beta0, k0), poles, push - push[0])


def _pass(over: tuple[float, ...], under: tuple[float, ...], signal: FloatArray) -> FloatArray:
    """Return the response to a signal that runs straight between its samples, from rest."""
    times = np.arange(signal.size) / CHALLENGE_RATE
    passed: FloatArray = lsim((over, under), signal, times)[1]
    return passed


def draw_channel(random: np.random.Generator, samples: int) -> FloatArray:
    """Draw the course of a channel: three sines about a mean."""
    times = np.arange(samples) / CHALLENGE_RATE
    course = np.full(samples, MEAN)
    for _ in range(3):
        angle = random.uniform(0.0, 2.0 * np.pi)
        course += SWING * np.sin(2.0 * np.pi * log_uniform(random, 0.5, 8.0) * times + angle)
    return course


def hide_channel(
    clean: Challenge, random: np.random.Generator, leaves: float
) -> tuple[Challenge, FloatArray, FloatArray, float]:
    """Drive a clean specimen by a channel.

    Returns
    -------
    Challenge
        Both recordings with the force.
    array, array
        The channel of each.
    float
        The rms that the best Kelvin-Voigt fit leaves, in units of the noise.
    """
    tip, zero = _tip(clean.answer), clean.answer.rig["contact_zero"]
    first, second = (
        draw_channel(random, each.force.size) for each in (clean.recording, clean.second)
    )
    lag = log_uniform(random, 0.01, 0.2) if random.random() < 0.5 else 0.0
    law = ChannelLaw(0.1, float(random.choice((0.0, -0.3, 0.5))), lag)
    ratio = 1.0
    for _ in range(CORRECTIONS):
        force = clean.recording.force + law.drive(first, tip)
        left = fit_residual(clean.recording.position - zero, force, tip)
        ratio = float(np.sqrt(np.mean(left**2)) / FORCE_NOISE)
        missing = (leaves**2 - 1.0) / max(ratio**2 - 1.0, 1e-3)
        if abs(missing - 1.0) < 0.05:
            break
        law = replace(law, strength=law.strength * np.sqrt(missing))
    driven = (
        _add(clean.recording, law.drive(first, tip)),
        _add(clean.second, law.drive(second, tip)),
    )
    return Challenge(*driven, clean.answer), first, second, ratio


def _add(record: SimulatedRecord, force: FloatArray) -> SimulatedRecord:
    return replace(record, force=record.force + force)


def _tip(answer: HiddenTruth) -> Specimen:
    constants = ("tip_mass", "load_cell_stiffness", "load_cell_damping")
    return Specimen(**answer.tissue, **{name: answer.rig[name] for name in constants})
