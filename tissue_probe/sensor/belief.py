"""The belief about a sensor, with its errors: it ages, and measurements are added to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre

from tissue_probe.sensor.noise import Colour
from tissue_probe.sensor.numbers import BIAS_PLACES, RATE_PLACES, Point
from tissue_probe.sensor.smoothed_air import Smoothed
from tissue_probe.signals import FloatArray

BELIEVED = 600.0
"""A drift's rate may have changed by as much as itself after so long [s]: sensors warm up in some
minutes to an hour."""
CHANGES = np.logspace(-4.0, 2.0, 61)
"""How fast rates change, as parts of that, among which a zero that is taken again chooses."""
DOUBT = np.log(30.0)
"""By this factor how fast a rate changes is uncertain before that (standard deviation of its
logarithm): drifts are as linear as 1 % in an hour, or settle in minutes."""


@dataclass(frozen=True)
class Belief:
    """Numbers with their covariance.

    Attributes
    ----------
    point : Point
        The numbers.
    covariance : array, shape (p, p)
        Of their errors.
    colours : tuple of Colour
        Of the noise of the six axes.
    unrest : array, shape (6,)
        How fast the rates of the drift change: variance that they gain in a second.
    unexplained : array, shape (6,)
        Variance of the wrench that the model left beyond noise: new poses have it, too.
    """

    point: Point
    covariance: FloatArray
    colours: tuple[Colour, ...]
    unrest: FloatArray
    unexplained: FloatArray

    def at(self, time: float) -> Belief:
        """Return the same at another time: rates forgotten, the bias carried on by them."""
        passed = time - self.point.time
        moved = np.eye(self.point.values.size)
        moved[range(10, 16), range(16, 22)] = passed
        covariance = moved @ self.covariance @ moved.T + _forgotten(moved, self.unrest, passed)
        return replace(self, point=Point(moved @ self.point.values, time), covariance=covariance)

    def deviation(self, run: Smoothed) -> FloatArray:
        """Return the standard deviation of the wrench it makes, shape (n, 6)."""
        _, slopes = self.point.wrench(run)
        variance = np.einsum("naj,jk,nak->na", slopes, self.covariance, slopes, optimize=True)
        passed = np.abs(run.time - self.point.time)[:, None]
        forgotten = self.unrest * passed**3 / 3.0
        found: FloatArray = np.sqrt(np.maximum(variance, 0.0) + forgotten + self.unexplained)
        return found

    def with_zero(self, run: Smoothed) -> Belief:
        """Return the belief after a stretch of free air: the bias anew, rates by how it went.

        How fast rates change is judged first, by how far the bias is from where they led.
        """
        middle = float(run.time.mean())
        aged = replace(self, unrest=self._judged(run, middle)).at(middle)
        wrench, slopes = aged.point.wrench(run)
        left = run.wrench - wrench
        information = np.linalg.inv(aged.covariance)
        hessian, gradient = normal_equations([left], [slopes], self.colours)
        covariance: FloatArray = np.asarray(np.linalg.inv(information + hessian), float)
        values = aged.point.values + covariance @ gradient
        return replace(aged, point=Point(values, middle), covariance=covariance)

    def _judged(self, run: Smoothed, middle: float) -> FloatArray:
        """Return how fast rates change, of forces and of torques."""
        calm = replace(self, unrest=np.zeros(6)).at(middle)
        wrench, slopes = calm.point.wrench(run)
        missed = (run.wrench - wrench).mean(axis=0)
        mean = slopes.mean(axis=0)
        variance = np.einsum("aj,jk,ak->a", mean, calm.covariance, mean) + self.unexplained
        variance += [colour.of_mean(len(wrench)) for colour in self.colours]
        gained = abs(middle - self.point.time) ** 3 / 3.0
        return likely_unrest(self.unrest, missed[None], variance[None], np.array([gained]))


def first_unrest(
    rates: FloatArray,
    covariance: FloatArray,
    times: Sequence[FloatArray],
    left: Sequence[FloatArray],
    colours: Sequence[Colour],
) -> FloatArray:
    """Return how fast rates change, by how bent in time the rest beside straight drifts is.

    Before that is looked at they change by their own size in ``BELIEVED``.
    """
    square = rates**2 + np.diagonal(covariance)
    unrest = np.repeat([square[:3].mean(), square[3:].mean()], 3) / BELIEVED
    time, rest = np.concatenate(times), np.concatenate(left)
    span = float(np.ptp(time))
    share = 2.0 * (time - time.min()) / span - 1.0
    bends = np.stack([legendre.legval(share, unit) * np.sqrt(2 * k + 1) for k, unit in _BENDS])
    missed = bends @ rest / len(time)
    variance = np.tile([colour.of_mean(len(time)) for colour in colours], (len(_BENDS), 1))
    return likely_unrest(unrest, missed, variance, span**3 * _bent())


def likely_unrest(
    unrest: FloatArray, missed: FloatArray, variance: FloatArray, gained: FloatArray
) -> FloatArray:
    """Return the mean of ``CHANGES``, as likely as they are, times a former unrest.

    For forces and for torques, each alone.

    Parameters
    ----------
    unrest : array, shape (6,)
        The former.
    missed, variance : array, shape (k, 6)
        By how much something is off, and the variance that it has with steady rates.
    gained : array, shape (k,)
        The variance that it gains by an unrest of 1.
    """
    judged = np.empty(6)
    for axes in (slice(0, 3), slice(3, 6)):
        added = CHANGES[:, None, None] * unrest[axes] * gained[:, None]
        total = variance[:, axes] + added
        fit = -0.5 * np.sum(missed[:, axes] ** 2 / total + np.log(total), axis=(1, 2))
        likely = fit - 0.5 * (np.log(CHANGES) / DOUBT) ** 2
        weight = np.exp(likely - likely.max())
        judged[axes] = (weight @ CHANGES) / weight.sum() * unrest[axes]
    return judged


#: Legendre's polynomials that no straight line resembles.
_BENDS = tuple((k, np.eye(k + 1)[k]) for k in (2, 3, 4))


def _bent() -> FloatArray:
    """Return the variance of each bend of a walk of unrest 1 over a time of 1, shape (3,)."""
    t = (np.arange(200) + 0.5) / 200
    first, second = np.minimum(t[:, None], t), np.maximum(t[:, None], t)
    walk = first**2 * (3.0 * second - first) / 6.0
    bends = [legendre.legval(2.0 * t - 1.0, unit) * np.sqrt(2 * k + 1) for k, unit in _BENDS]
    return np.array([bend @ walk @ bend for bend in bends]) / t.size**2


def normal_equations(
    left: Sequence[FloatArray], slopes: Sequence[FloatArray], colours: Sequence[Colour]
) -> tuple[FloatArray, FloatArray]:
    """Return information and gradient of all stretches, shape (p, p) and (p,)."""
    size = slopes[0].shape[2]
    hessian, gradient = np.zeros((size, size)), np.zeros(size)
    for rest, slope in zip(left, slopes, strict=True):
        for axis, colour in enumerate(colours):
            if len(rest) < 2 * len(colour.whitener):
                continue
            columns, values = colour.white(slope[:, axis]), colour.white(rest[:, axis])
            hessian += columns.T @ columns
            gradient += columns.T @ values
    return hessian, gradient


def _forgotten(moved: FloatArray, unrest: FloatArray, passed: float) -> FloatArray:
    """Return the covariance that a random walk of the rates adds."""
    added, t = np.zeros_like(moved), abs(passed)
    bias, rate = (
        np.arange(BIAS_PLACES.start, BIAS_PLACES.stop),
        np.arange(RATE_PLACES.start, RATE_PLACES.stop),
    )
    added[bias, bias] = unrest * t**3 / 3.0
    added[rate, rate] = unrest * t
    added[bias, rate] = added[rate, bias] = np.sign(passed) * unrest * t**2 / 2.0
    return added
