"""The way from a flat map into space, of places and of their errors."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tissue_probe.signals import FloatArray

#: Over so far a surface is taken for flat, where the error of a place is laid on it [m].
_LOCAL = 0.5e-3


class Lift(Protocol):
    """The way from a flat map into space."""

    def __call__(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return where places of the map [m], shape (n,) each, lie in space, shape (n, 3)."""
        ...


def covariance_in_space(lift: Lift, x: float, y: float, covariance: FloatArray) -> FloatArray:
    """Return the covariance in space [m^2], shape (3, 3), of a place of the map [m]."""
    beside = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]]) * _LOCAL
    right, left, up, down = lift(x + beside[0], y + beside[1])
    across = np.column_stack([right - left, up - down]) / (2.0 * _LOCAL)
    return np.asarray(across @ covariance @ across.T)
