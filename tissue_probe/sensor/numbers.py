"""The numbers that a fit finds: their places in one vector, their sizes, the wrench they make."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.sensor.free_air import SIZES
from tissue_probe.sensor.load import NUMBERS
from tissue_probe.sensor.smoothed_air import Smoothed
from tissue_probe.signals import FloatArray

LOAD = slice(0, NUMBERS)
BIAS_PLACES = slice(10, 16)
RATE_PLACES = slice(16, 22)
#: Logarithms of the axes' gains over their geometric mean: two of the forces, two of the torques.
GAINS = slice(22, 26)
DELAY_PLACE = 26
CORE = 27

#: Two directions of three gains that leave their product as it is.
CONTRASTS = np.array([[2.0, -1.0, -1.0], [0.0, 1.0, -1.0]]).T / np.array(
    [np.sqrt(6.0), np.sqrt(2.0)]
)

#: Before anything is measured, numbers are 0 within these: wider than any robot's, so that they
#: count only where poses tell nothing. Gains of makers' calibrations agree within some per cent.
PRIOR_DEVIATIONS = np.concatenate(
    [
        *([10.0], np.full(3, 1.0), np.full(6, 1.0)),  # kg, kg m, kg m2
        *(1e3 * SIZES, SIZES),  # N, N m; in a second
        *(np.full(4, 0.03), [0.05]),  # s
    ]
)


@dataclass(frozen=True)
class Point:
    """Numbers, shape (p,), and at which time the bias is told [s]."""

    values: FloatArray
    time: float

    @property
    def gains(self) -> FloatArray:
        """Of the six axes; those of force, and of torque, multiply to 1."""
        return np.exp(gain_columns() @ self.values[GAINS])

    @property
    def weights(self) -> FloatArray:
        """Of the cable's functions, shape (6, count)."""
        return self.values[CORE:].reshape(6, -1)

    def wrench(self, run: Smoothed) -> tuple[FloatArray, FloatArray]:
        """Return the wrench that they make, shape (n, 6), and its derivatives, (n, 6, p)."""
        delay, gains = self.values[DELAY_PLACE], self.gains
        load = gains[:, None] * run.load(delay)
        pulled = load @ self.values[LOAD]
        passed = (run.time - self.time)[:, None]
        slopes = np.zeros((*pulled.shape, self.values.size))
        slopes[:, :, LOAD] = load
        slopes[:, range(6), range(10, 16)] = 1.0
        slopes[:, range(6), range(16, 22)] = passed
        slopes[:, :, GAINS] = pulled[:, :, None] * gain_columns()
        slopes[:, :, DELAY_PLACE] = -gains * (run.load(delay, 1) @ self.values[LOAD])
        wrench = pulled + self.values[BIAS_PLACES] + passed * self.values[RATE_PLACES]
        if self.values.size > CORE:
            functions = run.cable(delay)
            count = functions.shape[1]
            for axis in range(6):
                first = CORE + axis * count
                slopes[:, axis, first : first + count] = functions
            wrench = wrench + functions @ self.weights.T
            slopes[:, :, DELAY_PLACE] -= run.cable(delay, 1) @ self.weights.T
        return wrench, slopes


def gain_columns() -> FloatArray:
    """Return how the four numbers of the gains act on the six axes, shape (6, 4)."""
    columns = np.zeros((6, 4))
    columns[:3, :2] = columns[3:, 2:] = CONTRASTS
    return columns
