"""The motion in a noisy position: the input of a model that the encoder's noise would shake.

Contents: the most likely motion, and others as likely.

A mass makes newtons of noise that is differentiated twice; and a fit takes such a mass for smaller
than it is, since the force shows nothing of that noise. The mean of all motions that the samples
leave possible has errors of another kind, with which a fit is right on average (J. Berkson, J. Am.
Stat. Assoc. 45 (1950), 164).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from tissue_probe.signals import FloatArray

#: Third differences: of samples a period T apart T^3 times the jerk.
JERK = np.array([-1.0, 3.0, -3.0, 1.0])
#: Samples in which the jerk counts as equally strong: as long as a corner of a course that is drawn
#: by straight lines; so many tell a deviation to a quarter.
JERK_SPAN = 9
#: Mean square of so many samples' departures, over the noise's, from which on they are no noise:
#: one in a million is. There the model is wrong by which the other channel tells of the motion.
DEPARTS = 5.0
#: How often strength and motion are found from one another: a further time moves the position by
#: less than a tenth of the noise (in a hold, where the strength is all but none and not settled).
MOTION_ROUNDS = 12
#: Variance of the noise over that of the third differences. At the largest a sample counts as much
#: as a hundredth of the mean, and at the smallest the noise is smaller than any motion.
LARGEST, SMALLEST = 1e9, 1e-3
#: Logarithms of the calmness at which it is told how much the samples tell, and frequencies over
#: which that is averaged [angle between two samples].
LOGARITHMS = np.linspace(np.log(SMALLEST), np.log(LARGEST), 200)
ANGLES = (np.arange(2000) + 0.5) * np.pi / 2000


@dataclass(frozen=True)
class MotionEstimate:
    """The estimate of a motion whose samples are noisy.

    Attributes
    ----------
    samples : array, shape (n,)
        As they were read.
    noise : float
        Standard deviation of the samples' white noise, same unit.
    calmness : array, shape (n - 3,)
        Variance of the noise over that of the third differences, about each.
    share : float
        How large errors of the position are, of those that the samples leave possible [-].
    """

    samples: FloatArray
    noise: float
    calmness: FloatArray
    share: float = 1.0

    @cached_property
    def position(self) -> FloatArray:
        """The mean of the motion's posterior, shape (n,) [unit of the samples]."""
        return (
            _solve_factored(_factor(self.calmness), self.samples)
            if self.calmness.any()
            else self.samples
        )

    def since(self, first: int) -> MotionEstimate:
        """Return the same from a sample on."""
        return MotionEstimate(self.samples[first:], self.noise, self.calmness[first:], self.share)

    def surer(self, share: float) -> MotionEstimate:
        """Return the same with errors of the position that are so many times as large."""
        return replace(self, share=share * self.share)

    def noise_left(self, random: np.random.Generator) -> FloatArray:
        """Draw noise as the position still has it, shape (n,)."""
        shaken = random.standard_normal(self.samples.size)
        return self.noise * _solve_factored(_factor(self.calmness), shaken)

    def error(self, random: np.random.Generator) -> FloatArray:
        """Draw an error that the position may have, shape (n,)."""
        shaken = random.standard_normal(self.samples.size)
        jerks = np.sqrt(self.calmness) * random.standard_normal(self.calmness.size)
        size = self.share * self.noise
        return size * _solve_factored(_factor(self.calmness), shaken + _spread(jerks))

    def chain(self) -> FloatArray:
        """Return how the error goes on, shape (n, 4).

        Each value is the three before, times the weights that stand first, and something new of the
        deviation that stands last [unit of the samples]: Cholesky's factor, from the last sample
        to the first, of the precision of the errors.
        """
        precision = _band(self.calmness)
        backwards = np.zeros_like(precision)
        for distance, row in enumerate(precision[::-1]):  # the matrix with its order turned round
            backwards[-1 - distance, distance:] = row[distance:][::-1]
        factor = cholesky_banded(backwards)
        root = factor[-1][::-1]
        chain = np.zeros((root.size, JERK.size))
        for distance in range(1, JERK.size):
            own = factor[-1 - distance, distance:][::-1]
            chain[distance:, distance - 1] = -own / root[distance:]
        chain[:, -1] = self.share * self.noise / root
        return chain


@dataclass(frozen=True)
class MotionInformation:
    """The information of another channel on the same motion, by a fitted model.

    Attributes
    ----------
    residual : array, shape (n,)
        Its samples, less those of the model at ``position`` [its unit].
    position : array, shape (n,)
        At which the model was run [unit of the samples].
    taps : array, shape (k,), k odd
        The derivative of a sample by the position at each neighbour, the latest neighbour
        first [unit / unit].
    noise : float
        Standard deviation of its own white noise [its unit].
    """

    residual: FloatArray
    position: FloatArray
    taps: FloatArray
    noise: float


def motion(
    samples: FloatArray, noise: float, felt: MotionInformation | None = None
) -> MotionEstimate:
    """Tell the motion from its samples: smooth at rest, and free to move where it moves.

    The jerk is white noise whose strength changes along the record and is told from the motion (an
    integrated random walk: G. Wahba, J. R. Stat. Soc. B 40 (1978), 364). About each sample the
    strength is the one at which the mean square of the jerk found is the one expected (D. MacKay,
    Neural Computation 4 (1992), 415, eq. 4.9). Another channel may show a jerk that the samples'
    noise hides: it tells the strength only, and the motion is that of the samples. Where it moves
    the motion away from the samples it tells nothing.

    Parameters
    ----------
    samples : array, shape (n,)
        Evenly spaced, n >= 4, in any unit.
    noise : float
        Standard deviation of their white noise, same unit; positive.
    felt : Felt, optional
        The other channel.
    """
    alone, _ = _strength(samples, samples, noise, np.zeros(ANGLES.size))
    if felt is None:
        return MotionEstimate(samples, noise, alone)
    weight = (noise / felt.noise) ** 2
    through = np.convolve(felt.position, felt.taps, mode="same")
    told = samples + weight * np.convolve(felt.residual + through, felt.taps[::-1], mode="same")
    by_force = weight * np.correlate(felt.taps, felt.taps, mode="full")[felt.taps.size - 1 :]
    turned = np.exp(1j * np.outer(ANGLES, np.arange(felt.taps.size))) @ felt.taps
    both, found = _strength(samples, told, noise, weight * np.abs(turned) ** 2, by_force)
    departs = (
        uniform_filter1d(((found - samples) / noise) ** 2, JERK_SPAN, mode="nearest") > DEPARTS
    )
    near = maximum_filter1d(departs, 2 * JERK_SPAN + 1)
    return MotionEstimate(
        samples, noise, np.where(sliding_window_view(near, JERK.size).any(axis=1), alone, both)
    )


def _strength(
    samples: FloatArray,
    told: FloatArray,
    noise: float,
    gains: FloatArray,
    more: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return the calmness, shape (n - 3,), and the motion that goes with it, shape (n,).

    ``told`` is the right side of the normal equations of all channels. ``gains`` is the weight of
    the other channel at each of ``ANGLES``, over the weight of the samples; ``more`` is that weight
    as the diagonals of a band.
    """
    calmness, found, shares = np.ones(samples.size - 3), samples, _shares(gains)
    for _ in range(MOTION_ROUNDS):
        found = _solve_factored(_factor(calmness, more), told)
        jerk = uniform_filter1d((np.diff(found, 3) / noise) ** 2, JERK_SPAN, mode="nearest")
        share = np.interp(np.log(calmness), LOGARITHMS, shares)
        calmness = share / np.maximum(jerk, np.finfo(float).tiny)
        calmness = np.clip(calmness, SMALLEST, LARGEST)
    return calmness, found


def _factor(calmness: FloatArray, more: FloatArray | None = None) -> FloatArray:
    """Return Cholesky's factor of the band, with the same diagonals more on all of it."""
    band = _band(calmness)
    if more is not None:
        wider = np.zeros((more.size, band.shape[1]))
        wider[-band.shape[0] :] = band
        band = wider + more[::-1, None]
    factor: FloatArray = cholesky_banded(band)
    return factor


def _band(calmness: FloatArray) -> FloatArray:
    """Return 1 + D^T diag(calmness) D, with the third differences D, as a band."""
    band = np.zeros((JERK.size, calmness.size + 3))
    band[-1] = 1.0
    for i, one in enumerate(JERK):
        for j, other in enumerate(JERK[i:], i):
            band[3 - (j - i), j : j + calmness.size] += one * other * calmness
    return band


def _solve_factored(factor: FloatArray, right: FloatArray) -> FloatArray:
    solution: FloatArray = cho_solve_banded((factor, False), right)
    return solution


def _spread(jerks: FloatArray) -> FloatArray:
    """Return D^T times jerks: the share of each in the four samples that it is computed from."""
    return np.convolve(jerks, JERK[::-1])


def _shares(gains: FloatArray) -> FloatArray:
    """Return how much of itself each found jerk is, where the calmness is the same throughout.

    That is, at each of ``LOGARITHMS``, how many of the motion's values the samples tell, and not
    the calmness. ``gains`` is the information of the other channel at ``ANGLES``, over that of the
    samples.
    """
    stiff = np.exp(LOGARITHMS)[:, None] * (2.0 - 2.0 * np.cos(ANGLES)) ** 3
    shares: FloatArray = np.mean((1.0 + gains) / (1.0 + gains + stiff), axis=1)
    return shares
