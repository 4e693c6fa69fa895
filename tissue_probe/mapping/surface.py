"""A smooth surface through the cells of a map, and how far it can be trusted.

What belongs here: interpolation between cells. What does not: what the surface means
(``regions``) and how it looks (``figures``).

The surface is a Gaussian process: unknown constant mean, Matern-5/2 covariance
C(d) = s^2 (1 + q + q^2 / 3) exp(-q), q = sqrt(5) d / l, and each cell's own noise. The length l
and the amplitude s are those of the highest posterior density; the priors keep them sensible where
a 5x5 grid says little: a nodule is about a spacing wide, and tissue varies by some tens of per
cent.

C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning, 2006,
eqs. 2.42 (unknown mean), 4.17 (Matern) and 5.8 (marginal likelihood).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize
from scipy.spatial.distance import cdist

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.grid import Grid
from tissue_probe.signals import FloatArray

POINTS_PER_SPACING = 10

# Priors: log(l / spacing) and log(s / (EXPECTED_VARIATION * mean)) are normal, with these stddevs.
LENGTH_SPREAD = 0.5
AMPLITUDE_SPREAD = 2.0
EXPECTED_VARIATION = 0.3

_RELATIVE_JITTER = 1e-9  # of s^2, so that noiseless cells can be factorised


@dataclass(frozen=True)
class Surface:
    """A quantity over a fine grid that reaches half a spacing beyond the outermost cells.

    Attributes
    ----------
    x : array, shape (n,)
        [m], rising.
    y : array, shape (m,)
        [m], rising.
    mean, stddev : array, shape (m, n)
        The quantity and its standard deviation, in the quantity's unit.
    """

    x: FloatArray
    y: FloatArray
    mean: FloatArray
    stddev: FloatArray

    @property
    def step(self) -> float:
        """Distance between neighbouring points [m]."""
        return float(self.x[1] - self.x[0])


def interpolate(grid: Grid, values: FloatArray, stddev: FloatArray) -> Surface:
    """Lay a surface through the measured cells of a grid.

    Takes of the order of n^3 operations for n measured cells: 10 ms for 25, a second for 400.

    Parameters
    ----------
    grid : Grid
        Where the cells are.
    values : array, shape (rows, columns)
        The quantity in each cell, in any unit; NaN cells are left out.
    stddev : array, shape (rows, columns)
        Standard deviation of each value, in the same unit, at least 0.

    Raises
    ------
    ValueError
        If no cell has a value, or a value lacks its standard deviation.
    """
    measured = np.isfinite(values)
    if not measured.any():
        raise ParameterError(
            "no cell of the map has been measured; there is nothing to interpolate"
        )
    if not np.all(stddev[measured] >= 0.0):
        raise ParameterError("a measured cell has no standard deviation of 0 or above")
    x, y = _fine(grid.x, grid.spacing), _fine(grid.y, grid.spacing)
    process = _most_probable(
        _points(grid.x, grid.y)[measured.ravel()],
        values[measured],
        stddev[measured],
        grid.spacing,
    )
    mean, spread = process.predict(_points(x, y))
    shape = (y.size, x.size)
    return Surface(x, y, mean.reshape(shape), spread.reshape(shape))


def _fine(cells: FloatArray, spacing: float) -> FloatArray:
    count = cells.size * POINTS_PER_SPACING + 1
    return np.linspace(cells[0] - spacing / 2, cells[-1] + spacing / 2, count)


def _points(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return every (x, y), row by row, shape (len(y) * len(x), 2)."""
    columns, rows = np.meshgrid(x, y)
    return np.column_stack([columns.ravel(), rows.ravel()])


class _Process:
    """A Gaussian process of given length [m] and amplitude, conditioned on the cells' values."""

    def __init__(
        self,
        points: FloatArray,
        values: FloatArray,
        stddev: FloatArray,
        length: float,
        amplitude: float,
    ) -> None:
        self._points, self._length, self._amplitude = points, length, amplitude
        covariance = self._covariance(points)
        noise = stddev**2 + _RELATIVE_JITTER * amplitude**2
        self._factor = cho_factor(covariance + np.diag(noise), lower=True)
        ones = np.ones(len(values))
        self._weighted_ones = cho_solve(self._factor, ones)
        self._mean_precision = float(ones @ self._weighted_ones)
        self._mean = float(values @ self._weighted_ones) / self._mean_precision
        self._deviation = values - self._mean
        self._weighted_deviation = cho_solve(self._factor, self._deviation)

    def _covariance(self, points: FloatArray) -> FloatArray:
        q = math.sqrt(5.0) * cdist(points, self._points) / self._length
        return self._amplitude**2 * (1.0 + q + q**2 / 3.0) * np.exp(-q)

    def log_likelihood(self) -> float:
        """Return the log marginal likelihood, the mean integrated out, up to a constant."""
        determinant = 2.0 * np.log(np.diag(self._factor[0])).sum()
        misfit = float(self._deviation @ self._weighted_deviation)
        return -0.5 * (misfit + determinant + math.log(self._mean_precision))

    def predict(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return mean and standard deviation at each point, shape (n,)."""
        cross = self._covariance(points)
        mean = self._mean + cross @ self._weighted_deviation
        explained = np.einsum("ij,ji->i", cross, cho_solve(self._factor, cross.T))
        unknown_mean = (1.0 - cross @ self._weighted_ones) ** 2 / self._mean_precision
        variance = self._amplitude**2 - explained + unknown_mean
        return mean, np.sqrt(np.maximum(variance, 0.0))


def _most_probable(
    points: FloatArray, values: FloatArray, stddev: FloatArray, spacing: float
) -> _Process:
    """Return the process with length and amplitude of the highest posterior density."""
    expected = EXPECTED_VARIATION * np.abs(values).mean() + stddev.mean()
    expected = expected if expected > 0.0 else 1.0  # all values are exactly zero

    def process(logs: FloatArray) -> _Process:
        length, amplitude = spacing * math.exp(logs[0]), expected * math.exp(logs[1])
        return _Process(points, values, stddev, length, amplitude)

    def cost(logs: FloatArray) -> float:
        prior = (logs[0] / LENGTH_SPREAD) ** 2 + (logs[1] / AMPLITUDE_SPREAD) ** 2
        return 0.5 * prior - process(logs).log_likelihood()

    best = minimize(
        cost,
        x0=np.zeros(2),
        method="Nelder-Mead",
        bounds=[(-2.0, 2.0), (-12.0, 5.0)],
        options={
            "initial_simplex": [(0.0, 0.0), (0.5, 0.0), (0.0, -1.0)],
            "xatol": 0.02,
            "fatol": 0.02,
        },
    )
    return process(best.x)
