"""The tool's stiffness and damping, from how its tip swings freely after an impulse (fig. 6).

With the coil at rest and no tissue, the paper's eq. 1 is m x'' + beta0 x' + k0 x = 0, and the force
F = -k0 x is

    F(t) = e^(-s t) (a cos w t + b sin w t) + c,  s = beta0 / 2m,  w^2 = k0 / m - s^2

with the load cell's zero c. Frequency and decay alone count: neither the force's unit nor its sign.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.optimize import curve_fit

from tissue_probe.identification.line import CONFIDENCE, Interval
from tissue_probe.signals import FloatArray

#: A fit needs so many swings after the first.
FEWEST_SWINGS = 3.0


@dataclass(frozen=True)
class RingDown:
    """Constants of the tool, estimated from an impulse.

    Attributes
    ----------
    stiffness, damping : float
        k0 [N/m] and beta0 [N s/m].
    stiffness_deviation, damping_deviation : float
        Standard deviations, with the tip mass's in them.
    frequency : float
        Resonance sqrt(k0 / m) / 2 pi [Hz].
    begin : int
        Number of the first sample that was fitted: one swing after the peak, so that the hammer has
        let go of the tip.
    fitted : array
        The fitted force from that sample on, in the unit of the force.
    degrees_of_freedom : int
        Samples less fitted numbers.
    """

    stiffness: float
    damping: float
    stiffness_deviation: float
    damping_deviation: float
    frequency: float
    begin: int
    fitted: FloatArray
    degrees_of_freedom: int

    @property
    def stiffness_interval(self) -> Interval:
        """95 % confidence interval of k0 [N/m]."""
        return self._interval(self.stiffness, self.stiffness_deviation)

    @property
    def damping_interval(self) -> Interval:
        """95 % confidence interval of beta0 [N s/m], not below 0."""
        low, high = self._interval(self.damping, self.damping_deviation)
        return max(0.0, low), high

    def _interval(self, value: float, deviation: float) -> Interval:
        quantile = stats.t.ppf(0.5 + CONFIDENCE / 2.0, self.degrees_of_freedom)
        return float(value - quantile * deviation), float(value + quantile * deviation)


def ring_down(
    time: FloatArray, stiffness: float, damping: float, tip_mass: float, kick: float
) -> FloatArray:
    """Return the force k0 x [N] of m x'' = -k0 x - beta0 x' from x = 0, x' = ``kick`` [m/s]."""
    decay = damping / (2.0 * tip_mass)
    rate = np.sqrt(stiffness / tip_mass - decay**2)
    force: FloatArray = stiffness * kick / rate * np.exp(-decay * time) * np.sin(rate * time)
    return force


def fit_ring_down(
    force: FloatArray, sample_period: float, tip_mass: float, tip_mass_deviation: float = 0.0
) -> RingDown:
    """Fit k0 and beta0 to the force after one impulse.

    Parameters
    ----------
    force : array, shape (n,)
        Force, in any unit and of either sign; it peaks at the impulse.
    sample_period : float
        Time between two samples [s].
    tip_mass, tip_mass_deviation : float
        Mass m that swings, and its standard deviation [kg].

    Raises
    ------
    ValueError
        If a sample is not finite, or the force does not swing and decay after its peak.
    """
    if not np.isfinite(force).all():
        raise ValueError("the force is missing in some samples: record the impulse again")
    peak = int(np.argmax(np.abs(force - np.median(force))))
    guess = _strongest_frequency(force[peak:], sample_period)
    begin = peak + round(1.0 / (guess * sample_period))
    swing = force[begin:]
    time = np.arange(swing.size, dtype=float) * sample_period
    if swing.size * sample_period * guess < FEWEST_SWINGS:
        raise ValueError(
            "the force does not swing after its peak: strike the tip once, in free air, and record "
            "until it is at rest"
        )
    scale = np.ptp(swing)
    start = (2.0 * np.pi * guess, guess, 0.3 * scale, 0.3 * scale, np.median(swing))
    try:
        found, covariance = curve_fit(_compute_swing, time, swing, start)
    except RuntimeError:
        raise ValueError("no decaying swing fits the force after its peak") from None
    rate, decay = abs(found[0]), found[1]
    rate_deviation, decay_deviation = np.sqrt(np.diagonal(covariance)[:2])
    if not (decay > 0.0 and rate_deviation < 0.1 * rate):
        raise ValueError(
            "the force after its peak does not decay as a swing: strike the tip once, in free air"
        )
    squared = rate**2 + decay**2
    of_squared = np.hypot(2.0 * rate * rate_deviation, 2.0 * decay * decay_deviation)
    of_mass = tip_mass_deviation / tip_mass
    return RingDown(
        stiffness=float(tip_mass * squared),
        damping=float(2.0 * tip_mass * decay),
        stiffness_deviation=float(tip_mass * np.hypot(of_squared, squared * of_mass)),
        damping_deviation=float(2.0 * tip_mass * np.hypot(decay_deviation, decay * of_mass)),
        frequency=float(np.sqrt(squared) / (2.0 * np.pi)),
        begin=begin,
        fitted=_compute_swing(time, *found),
        degrees_of_freedom=swing.size - found.size,
    )


def _compute_swing(
    time: FloatArray, rate: float, decay: float, cosine: float, sine: float, zero: float
) -> FloatArray:
    swing: FloatArray = cosine * np.cos(rate * time) + sine * np.sin(rate * time)
    return np.exp(-decay * time) * swing + zero


def _strongest_frequency(force: FloatArray, sample_period: float) -> float:
    """Return where the spectrum is highest, without its mean [Hz]; its lowest line at the least."""
    spectrum = np.abs(np.fft.rfft(force - force.mean()))
    line = 1 + int(np.argmax(spectrum[1:])) if spectrum.size > 1 else 1
    return line / (force.size * sample_period)
