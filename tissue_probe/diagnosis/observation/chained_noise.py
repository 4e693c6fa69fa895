"""The noise that errors of a noisy position leave in the output of a model that it drives.

Contents: how such errors go on from sample to sample, and the white noise beside them.

An error of the position is a chain: each value follows from the three before and something new
(``MotionEstimate.chain``). The output has a few neighbours of it, each times a tap, and its own
white noise; where the tip moves by itself, it rings with earlier errors. Kalman's filter then
predicts each sample from the earlier ones; the difference, over its deviation, is white and of
variance 1 (B. Anderson, J. Moore, Optimal Filtering (1979), section 5.3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from tissue_probe.diagnosis.observation.noise import Noise
from tissue_probe.signals import BoolArray, FloatArray

#: Neighbours on either side whose errors an output feels: the spline through the samples forgets
#: one by a factor of 3.7, and the derivative that it has there by the slope of a straight line of
#: so many to 3 %.
NEAR = 4


@dataclass(frozen=True)
class Chained(Noise):
    """White noise, and the noise that an error of the position makes in the output.

    Attributes
    ----------
    own : float
        See ``Noise``.
    chain : array, shape (n, 4)
        Of the error at each sample: the weights of the three before, and the deviation of the new
        independent part [m].
    taps : array, shape (2 NEAR + 1,)
        The derivative of the output by the error of each neighbour, the latest first [unit / m].
    beside : float
        Deviation of the noise that does not come through the taps [unit of the output].
    memory : array, shape (k,)
        The share of each of the k earlier effects in a sample, the latest first [-].
    size : float
        Deviation of all that it makes in the output [unit of the output].
    """

    chain: FloatArray
    taps: FloatArray
    beside: float
    memory: FloatArray = field(default_factory=lambda: np.zeros(0))
    size: float = 0.0

    _filters: dict[bytes, tuple[FloatArray, FloatArray]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    is_white: ClassVar[bool] = False
    #: A motion that is smoother than its jerk lets expect has smaller errors.
    is_upper_limit: ClassVar[bool] = True
    counted_too: ClassVar[str] = "the force that errors of the position make"

    @property
    def by_input(self) -> float:
        """Standard deviation of the noise that errors of the input make [unit of the output]."""
        return self.size

    def within(
        self, residual: FloatArray, used: BoolArray, own: float, colour: bool
    ) -> tuple[Noise, float]:
        """Return noise by no more errors of the position than a residual has: see ``Noise``.

        They are told from how the motion changes from sample to sample. A motion that changes less
        at random than that, such as a sine, has smaller ones.
        """
        beyond = float(np.mean(residual[self.select_counted(used)] ** 2)) - self.own**2
        if beyond <= 0.0:
            return Noise(own), math.nan
        return self.times(min(math.sqrt(beyond) / self.size, 1.0)), math.nan

    def select_counted(self, used: BoolArray) -> BoolArray:
        """Return which of the samples that are used have neighbours on both sides, shape (n,).

        A state at the start is bound by none of the others.
        """
        inside = used.copy()
        inside[:NEAR] = inside[-NEAR:] = False
        return inside

    def white(self, values: FloatArray, used: BoolArray) -> FloatArray:
        """Return each sample of values, shape (n, ...), less its prediction from those before.

        Those that are not used are 0, and the first and last few: they lack neighbours, and the
        course through the samples is bound less there.
        """
        if not values.size:
            return values
        from tissue_probe.diagnosis.observation.innovations import gains, white  # compiled code

        counted = self.select_counted(used)
        about = self.chain, self.taps, self.memory
        key = counted.tobytes()
        if key not in self._filters:
            self._filters[key] = gains(*about, self.own**2, self.beside**2, counted)
        columns = np.ascontiguousarray(values.reshape(values.shape[0], -1))
        whitened: FloatArray = white(*about, *self._filters[key], columns).reshape(values.shape)
        return whitened

    def of_some(self) -> Noise:
        """Return the white noise alone: the chain is that of all samples."""
        return Noise(self.own)

    def approximate(self) -> Noise:
        """Return white noise of the same power: it needs no filter."""
        return Noise(math.sqrt(self.power))

    def times(self, factor: float) -> Chained:
        """Return the same for errors of the position that are so many times larger."""
        chain = self.chain * (1.0, 1.0, 1.0, factor)
        return replace(self, chain=chain, beside=factor * self.beside, size=factor * self.size)
