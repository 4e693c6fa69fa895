"""What a laboratory's channels make of position and force: gain, zero, delay, noise.

Contents: the channels, and how much noise they leave to the best of models.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.protocols.course import Array, Course
from benchmarks.protocols.motion import COMPLIANT, DRIVEN, RIGID, Motion, Rig, simulate
from benchmarks.protocols.specimen import Specimen

#: Frequencies over which a spectrum is averaged, in angles between two samples.
_ANGLES = np.pi * (np.arange(512) + 0.5) / 512


@dataclass(frozen=True)
class Sensors:
    """The two channels.

    Attributes
    ----------
    force_noise, position_noise : float
        Standard deviations of white noise [N], [m].
    gain, bias, drift : float
        The force reads (1 + gain) F + bias + drift t [-], [N], [N/s].
    settling, settling_time : float
        And settling exp(-t / settling_time) beside [N], [s].
    delay : float
        The force is late by so much [s].
    """

    force_noise: float
    position_noise: float = 0.0
    gain: float = 0.0
    bias: float = 0.0
    drift: float = 0.0
    settling: float = 0.0
    settling_time: float = 1.0
    delay: float = 0.0

    def zero(self, times: Array) -> Array:
        """Return what the force channel reads without a load [N]."""
        return self.bias + self.drift * times + self.settling * np.exp(-times / self.settling_time)


@dataclass(frozen=True)
class Bench:
    """One specimen under one rig with its sensors."""

    rig: Rig
    specimen: Specimen
    sensors: Sensors

    def without_noise(self, course: Course, times: Array, begin: float) -> Motion:
        """Return what is read of position and force, noise apart, from rest at ``begin``."""
        rig, late = self.rig, self.sensors.delay
        found = simulate(rig, self.specimen, course, times, begin)
        force = found.force
        if late:
            force = simulate(rig, self.specimen, course, times - late, begin - late).force
        position = found.position if rig.name == DRIVEN else course(times)
        return Motion(position, (1.0 + self.sensors.gain) * force + self.sensors.zero(times))

    def read(
        self, course: Course, times: Array, begin: float, random: np.random.Generator
    ) -> Motion:
        """Return what is read of position and force."""
        found = self.without_noise(course, times, begin)
        position = found.position + self.sensors.position_noise * random.standard_normal(times.size)
        force = found.force + self.sensors.force_noise * random.standard_normal(times.size)
        return Motion(position, force)

    def noise(self, period: float, position: Array) -> float:
        """Return the rms that the noise of both channels leaves to the true model [N or m].

        The input's noise passes the true model, which takes the input for the cubic spline through
        its samples. That is what the spline's derivatives are of white noise: at an angle w between
        two samples i 3 sin w / (2 + cos w), and 6 (cos w - 1) / (2 + cos w). A model that smooths
        its input leaves less.

        Parameters
        ----------
        period : float
            Mean time between samples [s].
        position : array
            Of the tip [m]: where the slope of a curved law is taken.
        """
        own, through = self.sensors.force_noise, self.sensors.position_noise
        if self.rig.name == DRIVEN:
            own, through = through, own
        gains = np.abs(self._answer(period, self._slope(position)))
        return float(np.hypot(own, through * np.sqrt(np.mean(gains**2))))

    def _slope(self, position: Array) -> float:
        """Return the mean stiffness against fast motions [N/m]."""
        specimen = self.specimen
        depth = position - specimen.touch
        step = 1e-4 * (float(np.ptp(depth)) or 1.0)
        slope = (specimen.spring(depth + step) - specimen.spring(depth - step)) / (2.0 * step)
        return float(slope.mean()) + sum(specimen.branch_stiffness)

    def _answer(self, period: float, slope: float) -> Array:
        """Return how the output answers to the input at ``_ANGLES``."""
        rate = 3j * np.sin(_ANGLES) / (2.0 + np.cos(_ANGLES)) / period
        curvature = 6.0 * (np.cos(_ANGLES) - 1.0) / (2.0 + np.cos(_ANGLES)) / period**2
        tissue = slope + self.specimen.damping * rate + self.specimen.mass * curvature
        if self.rig.name == RIGID:
            return tissue
        # These answer by themselves, whatever the spline's derivatives are.
        rate = 1j * _ANGLES / period
        tissue = slope + self.specimen.damping * rate + self.specimen.mass * rate**2
        if self.rig.name == DRIVEN:
            return 1.0 / tissue
        assert self.rig.name == COMPLIANT
        cell, grip = self.rig.cell_stiffness, self.rig.cell_damping * rate
        return cell * tissue / (cell + grip + tissue)
