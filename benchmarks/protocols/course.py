"""Courses of a position or of a force: what a laboratory makes its machine do.

Contents: values and derivatives at any time, and where an integrator has to stop.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.interpolate import BPoly, BSpline, make_interp_spline

Array = np.ndarray
#: The ramp x for x > 0, 0 otherwise, after four moving averages of width 1: quintic pieces; its
#: first two derivatives.
_BUMP = BSpline.basis_element([-2, -1, 0, 1, 2])
_RAMPS = (_BUMP.antiderivative(2), _BUMP.antiderivative(1), _BUMP)


class Course(Protocol):
    """A quantity over time, at rest long before its first break."""

    breaks: Array
    """Times at which a derivative jumps [s]."""
    longest_step: float
    """Of an integrator [s]: no motion is shorter."""

    def __call__(self, time: Array, order: int = 0) -> Array:
        """Return the value, or its first or second derivative."""


class Path:
    """Straight lines between points, at rest before and after, with rounded corners.

    Parameters
    ----------
    times, values : sequences of float
        The points [s], [m or N].
    rounding : float
        Time that each corner takes [s]: there the course is the straight lines' average over a
        cubic B-spline, of which two derivatives are continuous.
    """

    longest_step = np.inf

    def __init__(self, times: Sequence[float], values: Sequence[float], rounding: float) -> None:
        times, values = np.asarray(times, float), np.asarray(values, float)
        slopes = np.concatenate([[0.0], np.diff(values) / np.diff(times), [0.0]])
        pieces = np.arange(-2.0, 3.0) * rounding / 4.0
        self.breaks = np.unique(np.add.outer(times, pieces))
        self.begin, self.end = self.breaks[0], self.breaks[-1]
        at_breaks = np.zeros((self.breaks.size, 3))
        at_breaks[:, 0] = values[0]
        for corner, turn in zip(times, np.diff(slopes), strict=True):
            at_breaks += turn * _ramp(self.breaks - corner, rounding / 4.0)
        # Each piece is a quintic, so that values and two derivatives at its ends are all of it.
        self._pieces = [BPoly.from_derivatives(self.breaks, at_breaks)]
        self._pieces += [self._pieces[0].derivative(order) for order in (1, 2)]

    def __call__(self, time: Array, order: int = 0) -> Array:
        """Return the value, or its first or second derivative."""
        found = self._pieces[order](np.clip(time, self.begin, self.end))
        if order == 0:
            return found
        return np.where((time > self.begin) & (time < self.end), found, 0.0)


def _ramp(time: Array, width: float) -> Array:
    """Return the rounded ramp and two derivatives at some times, shape (n, 3)."""
    place = time / width
    within = np.abs(place) < 2.0
    orders = []
    for order, past in enumerate((time, 1.0, 0.0)):
        spline = _RAMPS[order](np.where(within, place, 0.0)) * width ** (1 - order)
        orders.append(np.where(within, spline, np.where(place > 0.0, past, 0.0)))
    return np.stack(orders, axis=-1)


class Smooth:
    """A smooth function of time, as the quintic spline through its values at close times.

    Parameters
    ----------
    function : callable
        Of an array of times [s].
    begin, end : float
        Where it is needed [s]; before it is constant.
    fastest : float
        Highest frequency in it [Hz]: there are sixteen knots to each of its periods.
    """

    def __init__(
        self, function: Callable[[Array], Array], begin: float, end: float, fastest: float
    ) -> None:
        knots = np.linspace(begin, end, max(int(16.0 * fastest * (end - begin)), 20))
        self.begin, self.end = begin, end
        self._splines = [make_interp_spline(knots, function(knots), 5)]
        self._splines += [self._splines[0].derivative(order) for order in (1, 2)]
        self.breaks, self.longest_step = np.array([begin]), 0.1 / fastest

    def __call__(self, time: Array, order: int = 0) -> Array:
        """Return the value, or its first or second derivative."""
        time = np.asarray(time, float)
        found = self._splines[order](np.clip(time, self.begin, self.end))
        return found if order == 0 else np.where(time < self.begin, 0.0, found)


class Held:
    """Values that a converter holds from each time until the next; the first holds before, too."""

    longest_step = np.inf

    def __init__(self, times: Array, values: Array) -> None:
        self.times, self.values = np.asarray(times, float), np.asarray(values, float)

    @cached_property
    def breaks(self) -> Array:
        """Where the value changes [s]."""
        return self.times[1:][np.diff(self.values) != 0.0]

    def __call__(self, time: Array, order: int = 0) -> Array:
        """Return the value; its derivatives are 0 between jumps."""
        if order:
            return np.zeros(np.shape(time))
        place = np.searchsorted(self.times, time, side="right") - 1
        return self.values[np.maximum(place, 0)]

    def means(self, times: Array) -> Array:
        """Return the mean value from each of ascending times until the next, and the last value.

        Who holds these gives the same impulse, wherever in between the value changes.
        """
        ends = np.concatenate([self.times, np.maximum(times[-1:], self.times[-1]) + 1.0])
        begin = min(times[0], self.times[0])
        areas = np.concatenate([[0.0], np.cumsum(self.values * np.diff(ends))])
        areas += self.values[0] * (self.times[0] - begin)
        area = np.interp(times, np.append(begin, ends), np.append(0.0, areas))
        return np.append(np.diff(area) / np.diff(times), self(times[-1:]))


class Straight:
    """Values joined by straight lines, with sharp corners; a force, of which no rate is asked."""

    longest_step = np.inf

    def __init__(self, times: Array, values: Array) -> None:
        self.times, self.values = np.asarray(times, float), np.asarray(values, float)
        slopes = np.diff(self.values) / np.diff(self.times)
        turns = np.diff(np.concatenate([[0.0], slopes, [0.0]]))
        self.breaks = self.times[turns != 0.0]

    def __call__(self, time: Array, order: int = 0) -> Array:
        """Return the value."""
        if order:
            raise ValueError("a course of sharp corners has no derivatives")
        return np.interp(time, self.times, self.values)
