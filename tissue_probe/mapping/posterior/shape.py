"""The shape of one inclusion, as the tip feels it: from peaked to plateau, round to elliptic.

g = 2^-(rho / R)^p, where rho is the distance in the metric of an ellipse of area pi R^2. At half
its height, g = 1/2, lies the boundary of the inclusion, whatever the exponent p.
"""

from __future__ import annotations

import math

from numba import njit

from tissue_probe.mapping.posterior.prior import (
    ANGLE,
    LOG_ASPECT,
    LOG_EXPONENT,
    LOG_RADIUS,
    X,
    Y,
)
from tissue_probe.signals import FloatArray

_LOG_2 = math.log(2.0)
#: Where less than exp(-9) = 0.01 % is felt, nothing is.
FADED = 9.0


@njit(cache=True, nogil=True, error_model="numpy")
def metric(row: FloatArray) -> tuple[float, float, float]:
    """Return a, b, c with (rho / R)^2 = a dx^2 + 2 b dx dy + c dy^2, lengths in mm."""
    aspect, scale = math.exp(row[LOG_ASPECT]), math.exp(-2.0 * row[LOG_RADIUS])
    cosine, sine = math.cos(row[ANGLE]), math.sin(row[ANGLE])
    along, beside = scale / aspect, scale * aspect
    return (
        along * cosine**2 + beside * sine**2,
        (along - beside) * cosine * sine,
        along * sine**2 + beside * cosine**2,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def measure_distance(row: FloatArray, x: float, y: float) -> float:
    """Return (rho / R)^2 of a place [mm]; 1 on the boundary."""
    a, b, c = metric(row)
    across, up = x - row[X], y - row[Y]
    return float(a * across**2 + 2.0 * b * across * up + c * up**2)


@njit(cache=True, nogil=True, error_model="numpy")
def write_shape(row: FloatArray, x: FloatArray, y: FloatArray, out: FloatArray) -> None:
    """Write g at each place [mm] to ``out``; exactly 0 where it has faded."""
    half = 0.5 * math.exp(row[LOG_EXPONENT])
    reach = (FADED / _LOG_2) ** (1.0 / half)
    a, b, c = metric(row)
    for i in range(x.size):
        across, up = x[i] - row[X], y[i] - row[Y]
        squared = a * across**2 + 2.0 * b * across * up + c * up**2
        if squared < reach:
            out[i] = math.exp(-_LOG_2 * squared**half)
        else:
            out[i] = 0.0
