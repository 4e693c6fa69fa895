"""Noise of the output, whose whitening makes the residual of a right model white, of variance 1.

Contents: the interface of all kinds of noise, and the kind that is white already.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from tissue_probe.signals import BoolArray, FloatArray

#: Noise fainter than this share of the output's own white noise is left aside: it adds half a
#: percent to the deviation.
FAINT_NOISE = 0.1


@dataclass(frozen=True)
class Noise:
    """White noise of the output; a kind that derives from this has other noise beside it.

    Attributes
    ----------
    own : float
        Standard deviation of the white noise [unit of the output]; 0 where it is not known yet.
    """

    own: float

    #: Whether samples may be left out without more ado.
    is_white: ClassVar[bool] = True
    #: Whether more may be counted than there is, so that too little noise is no fault of a model.
    is_upper_limit: ClassVar[bool] = False
    #: The noise that is counted beside the white noise, in words.
    counted_too: ClassVar[str] = "known 1/f noise and rounding"

    @property
    def by_input(self) -> float:
        """Standard deviation of the noise that errors of the input make [unit of the output]."""
        return 0.0

    @property
    def power(self) -> float:
        """Mean square of all noise in a sample."""
        return self.own**2 + self.by_input**2

    def select_counted(self, used: BoolArray) -> BoolArray:
        """Return which of the samples that are used tell how large an error is, shape (n,)."""
        return used

    def white(self, values: FloatArray, used: BoolArray) -> FloatArray:
        """Return values, shape (n, ...), in which the noise is white and of variance 1.

        Those that are not used are 0.
        """
        return (values.T * (used / self.own)).T

    def with_own(self, own: float) -> Noise:
        """Return the same with another standard deviation of the white noise."""
        return replace(self, own=own)

    def within(
        self, residual: FloatArray, used: BoolArray, own: float, colour: bool
    ) -> tuple[Noise, float]:
        """Return noise that is no more than a residual, and that of a driving force by it.

        Parameters
        ----------
        residual : array, shape (n,)
            Of a model.
        used : array of bool, shape (n,)
            Which samples count.
        own : float
            Standard deviation of the white noise, if all of the residual is white.
        colour : bool
            Whether the colour of the residual is that of its noise.

        Returns
        -------
        Noise
        float
            Standard deviation of the white noise of the force [N]; NaN where none is told.
        """
        return Noise(own), float("nan")

    def restart_estimate(self) -> Noise:
        """Return the same, its white noise to be estimated from the samples that are left."""
        return self.with_own(0.0)

    def of_some(self) -> Noise:
        """Return the noise of some of the samples."""
        return self

    def approximate(self) -> Noise:
        """Return noise of the same power that puts starts in the same order, and costs less."""
        return self


#: To be estimated from the samples.
UNKNOWN_NOISE = Noise(0.0)


def faint(values: FloatArray, noise: Noise) -> bool:
    """Whether a change of the output is left aside beside its noise."""
    return not np.sqrt(np.mean(values**2)) > FAINT_NOISE * noise.own
