"""A motion of the coil as it was measured: smooth, and known before the record too.

Contents: a spline, and what came before it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BPoly, BSpline

from tissue_probe.challenge.instrument import CHALLENGE_RATE
from tissue_probe.signals import FloatArray


@dataclass(frozen=True, eq=False)
class Measured:
    """A motion as it was measured.

    Before a record that begins at rest the coil is held where the record begins. Before one that
    was cut out of a motion the motion goes round: from the record's beginning to where it comes
    nearest to that again, and what then differs is taken up by a polynomial of fifth order.

    Attributes
    ----------
    source : str
        Where it comes from.
    at_rest : bool
        Whether the coil rested before the record.
    duration : float
        Of the record [s], in whole samples of 2 kHz.
    preload : float
        Mean displacement [m].
    amplitude : float
        Largest displacement from the preload [m].
    highest : float
        Frequency below which 98 % of the motion's power lies [Hz].
    course : BSpline
        Displacement from the preload over the amplitude [-], by the time since the first sample.
    """

    source: str
    at_rest: bool
    duration: float
    preload: float
    amplitude: float
    highest: float
    course: BSpline

    @property
    def held(self) -> float:
        """Where the coil is held before it moves: from the preload, over the amplitude [-]."""
        return float(self.course(0.0)) if self.at_rest else 0.0

    def at(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the motion from where the coil is held, over the amplitude, and its derivative.

        Parameters
        ----------
        time : array
            Since the first sample [s]; negative only for a record cut out of a motion.
        """
        speed = self.course.derivative()
        if self.at_rest:
            return self.course(time) - self.held, speed(time)
        length, joint = self._round
        earlier = time < 0.0
        place = np.where(earlier, np.mod(time, length), time)
        # Before its own short time the joint is nothing.
        within = np.where(earlier, np.maximum(place - length, joint.x[0]), joint.x[0])
        return self.course(place) + joint(within), speed(place) + joint.derivative()(within)

    @cached_property
    def _round(self) -> tuple[float, BPoly]:
        """When the motion comes nearest to its beginning again [s], and what closes the round."""
        orders = [self.course.derivative(order) for order in range(3)]
        time = np.arange(round(self.duration * CHALLENGE_RATE)) / CHALLENGE_RATE
        off = sum(((each(time) - each(0.0)) / np.std(each(time))) ** 2 for each in orders)
        late = time.size // 2
        length = time[late + np.argmin(off[late:])]
        lacking = [float(each(0.0) - each(length)) for each in orders]
        short = min(2.0 * time_scale(self.course, self.duration), length)
        return length, BPoly.from_derivatives([-short, 0.0], [[0.0, 0.0, 0.0], lacking])


def time_scale(course: BSpline, duration: float) -> float:
    """Return the rms of a motion over that of its speed [s]."""
    time = np.arange(0.0, duration, 1.0 / CHALLENGE_RATE)
    return float(np.std(course(time)) / np.sqrt(np.mean(course.derivative()(time) ** 2)))
