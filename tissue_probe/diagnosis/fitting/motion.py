"""The motion in a noisy position: what drives a model, where the encoder's noise would shake it.

What belongs here: the most likely motion, and others as likely. What does not: coarse steps of an
encoder (``physics.rounding``), what errors of the motion do to a model (``shaken``).

A mass makes newtons of noise that is differentiated twice; and a fit takes such a mass for smaller
than it is, since the force shows nothing of that noise. The mean of all motions that the samples
leave possible has errors of another kind, with which a fit is right on average (J. Berkson, J. Am.
Stat. Assoc. 45 (1950), 164).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.ndimage import uniform_filter1d

from tissue_probe.signals import FloatArray

#: Third differences: of samples a period T apart T^3 times the jerk.
JERK = np.array([-1.0, 3.0, -3.0, 1.0])
#: Samples in which the jerk counts as equally strong: so many tell a variance to a third.
ALIKE = 25
#: How often strength and motion are found from one another: a further time moves the position by
#: less than a tenth of the noise (in a hold, where the strength is all but none and not settled).
ROUNDS = 12
#: Variance of the noise over that of the third differences. At the largest a sample counts as much
#: as a hundredth of the mean, and at the smallest the noise is smaller than any motion.
LARGEST, SMALLEST = 1e9, 1e-3


@dataclass(frozen=True)
class Motion:
    """What is known of a motion whose samples are noisy.

    Attributes
    ----------
    position : array, shape (n,)
        The mean of what it may have been [unit of the samples].
    noise : float
        Standard deviation of the samples' white noise, same unit.
    calmness : array, shape (n - 3,)
        Variance of the noise over that of the third differences, about each.
    """

    position: FloatArray
    noise: float
    calmness: FloatArray

    def since(self, first: int) -> Motion:
        """Return the same from a sample on."""
        return Motion(self.position[first:], self.noise, self.calmness[first:])

    def noise_left(self, random: np.random.Generator) -> FloatArray:
        """Draw noise as the position still has it, shape (n,)."""
        shaken = random.standard_normal(self.position.size)
        return self.noise * _solved(_factor(self.calmness), shaken)

    def error(self, random: np.random.Generator) -> FloatArray:
        """Draw an error that the position may have, shape (n,)."""
        shaken = random.standard_normal(self.position.size)
        jerks = np.sqrt(self.calmness) * random.standard_normal(self.calmness.size)
        return self.noise * _solved(_factor(self.calmness), shaken + _spread(jerks))


def motion(samples: FloatArray, noise: float) -> Motion:
    """Tell the motion from its samples: smooth at rest, and free to move where it moves.

    The jerk is white noise whose strength changes along the record and is told from the motion (an
    integrated random walk: G. Wahba, J. R. Stat. Soc. B 40 (1978), 364). About each sample the
    strength is the one at which the mean square of the jerk found is the one expected (D. MacKay,
    Neural Computation 4 (1992), 415, eq. 4.9).

    Parameters
    ----------
    samples : array, shape (n,)
        Evenly spaced, n >= 4, in any unit.
    noise : float
        Standard deviation of their white noise, same unit; positive.
    """
    calmness = np.ones(samples.size - 3)
    for _ in range(ROUNDS):
        found = _solved(_factor(calmness), samples)
        jerk = uniform_filter1d((np.diff(found, 3) / noise) ** 2, ALIKE, mode="nearest")
        calmness = _share(calmness) / np.maximum(jerk, np.finfo(float).tiny)
        calmness = np.clip(calmness, SMALLEST, LARGEST)
    return Motion(_solved(_factor(calmness), samples), noise, calmness)


def _factor(calmness: FloatArray) -> FloatArray:
    """Return Cholesky's factor of 1 + D^T diag(calmness) D, with the differences D, as a band."""
    band = np.zeros((JERK.size, calmness.size + 3))
    band[-1] = 1.0
    for i, one in enumerate(JERK):
        for j, other in enumerate(JERK[i:], i):
            band[3 - (j - i), j : j + calmness.size] += one * other * calmness
    return cholesky_banded(band)


def _solved(factor: FloatArray, right: FloatArray) -> FloatArray:
    return cho_solve_banded((factor, False), right)


def _spread(jerks: FloatArray) -> FloatArray:
    """Return D^T times jerks: what each does to the four samples that it is told from."""
    return np.convolve(jerks, JERK[::-1])


def _share(calmness: FloatArray) -> FloatArray:
    """Return how much of itself each found value is, where the calmness is the same throughout."""
    return np.interp(np.log(calmness), *_shares())


@cache
def _shares() -> tuple[FloatArray, FloatArray]:
    """Return logarithms of the calmness, and the means of 1 / (1 + calmness |D|^2)."""
    logarithms = np.linspace(np.log(SMALLEST), np.log(LARGEST), 200)
    angles = (np.arange(2000) + 0.5) * np.pi / 2000
    gains = (2.0 - 2.0 * np.cos(angles)) ** 3
    means = [float(np.mean(1.0 / (1.0 + np.exp(each) * gains))) for each in logarithms]
    return logarithms, np.array(means)
