"""Free air as the fit sees it: smoothed, on a coarse grid, for any delay of the wrench."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from tissue_probe.sensor.cable import CableFunctions
from tissue_probe.sensor.free_air import SIZES, FreeAir
from tissue_probe.sensor.kinematics import motion
from tissue_probe.sensor.load import NUMBERS, load_columns
from tissue_probe.sensor.smoothing import LOAD_CUTOFF, Smoother
from tissue_probe.signals import FloatArray

LONGEST_SENSOR_DELAY = 0.1
"""The wrench is at most so much later than the pose, or earlier by half of it [s]: network and
filters of sensors take less."""
SHORTEST_AIR = 1.0
"""Shorter stretches tell nothing: the filter has half a second of ends [s]."""
FLOOR = 1e-5
"""Noise is not less than this [N], and as much of a torque: that of written digits. An axis that a
sensor does not have is 0 to the last bit."""


class Smoothed:
    """One stretch, its load's and its cable's columns through the same filter as its wrench.

    Parameters
    ----------
    run : FreeAir
        At least ``SHORTEST_AIR``.
    cable : CableFunctions or None
        None for no cable.

    Attributes
    ----------
    time : array, shape (n,)
        Of the coarse rows [s], as dense as the filter's cutoff needs.
    wrench : array, shape (n, 6)
        Smoothed.
    noise : array, shape (6,)
        Standard deviation of the wrench's white noise, before the filter; ``FLOOR`` at least.
    in_band : array, shape (6,)
        Variance of the part of it that passes.
    """

    def __init__(self, run: FreeAir, cable: CableFunctions | None = None) -> None:
        smooth = Smoother(run.period)
        raw = load_columns(motion(run.position, run.orientation, run.period))
        columns = [raw.reshape(-1, 6 * NUMBERS)]
        if cable is not None:
            columns.append(cable.columns(run)[1:-1])
        passed = smooth(np.concatenate(columns, axis=1))
        wrench = run.wrench[1:-1]
        low = smooth(wrench)
        fine = run.begin + run.period * (1 + smooth.half + np.arange(len(low), dtype=float))
        self._spline = CubicSpline(fine, passed)
        step = max(1, round(0.5 / (LOAD_CUTOFF * run.period)))
        ends = LONGEST_SENSOR_DELAY, 0.5 * LONGEST_SENSOR_DELAY
        kept = slice(round(ends[0] / run.period) + 1, len(low) - round(ends[1] / run.period), step)
        self.time, self.wrench = fine[kept], low[kept]
        rest = wrench[smooth.half : len(wrench) - smooth.half] - low
        noise = np.sqrt(np.mean(rest**2, axis=0) / smooth.left)
        self.noise = np.maximum(noise, FLOOR * SIZES)
        self.in_band = self.noise**2 * smooth.passed
        self._smooth, self._raw = smooth, raw

    def load(self, delay: float, order: int = 0) -> FloatArray:
        """Return the load's columns a delay ago, or a derivative, shape (n, 6, 10)."""
        return self._at(delay, order)[:, : 6 * NUMBERS].reshape(-1, 6, NUMBERS)

    def cable(self, delay: float, order: int = 0) -> FloatArray:
        """Return the cable's columns a delay ago, shape (n, count)."""
        return self._at(delay, order)[:, 6 * NUMBERS :]

    def _at(self, delay: float, order: int) -> FloatArray:
        found: FloatArray = self._spline(self.time - delay, order)
        return found

    def noise_of_pose(self, load: FloatArray) -> FloatArray:
        """Return the variance that the poses' noise leaves in a load's wrench, shape (6,)."""
        wrench = self._raw @ load
        half = self._smooth.half
        rest = wrench[half : len(wrench) - half] - self._smooth(wrench)
        found: FloatArray = np.mean(rest**2, axis=0) * self._smooth.passed_twice_differentiated
        return found
