"""The load cell's zero, found in free air while the coil moves; refused in contact.

In free air the tip's inertia is all that the load cell feels, and in contact the tissue's force
comes to it (the paper's eq. 1, without the load cell's own small damping):

    F = m x'' + beta x' + k x + c,   x = u - F / k0

The fit of k and beta tells contact from free air, so that no tissue is ever tared away. An error of
m counts as (2 pi f)^2 of stiffness for each kilogram: drive the coil at 10 Hz or slower.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from tissue_probe.errors import TissueProbeError
from tissue_probe.signals import FloatArray

#: Below this stiffness the tip is in free air, as the estimators have it [N/m].
CONTACT_STIFFNESS = 20.0
#: Longest window of the derivatives [s]: far shorter than a swing of the coil.
DERIVATIVE_WINDOW = 0.01
#: Less than this between its ends is no motion of the tip [m].
LEAST_MOTION = 5e-5


class Refused(TissueProbeError):
    """No zero can be taken now; the message says why, and the remedy."""


def free_air_zero(
    position: FloatArray,
    force: FloatArray,
    sample_period: float,
    tip_mass: float,
    load_cell_stiffness: float,
) -> float:
    """Return the force c [N] that the load cell shows without load.

    Parameters
    ----------
    position : array, shape (n,)
        Displacement of the coil [m], positive into the tissue; a second or more.
    force : array, shape (n,)
        Force [N], positive in compression.
    sample_period : float
        Time between two samples [s].
    tip_mass, load_cell_stiffness : float
        The tool's m [kg] and k0 [N/m].

    Raises
    ------
    Refused
        If a sample is not finite, the coil does not move enough to tell contact from free air, or
        the tip is in contact.
    """
    if not (np.isfinite(position).all() and np.isfinite(force).all()):
        raise Refused("a sample is missing: no zero is taken")
    window = max(5, round(DERIVATIVE_WINDOW / sample_period) | 1)
    if position.size < 10 * window:
        raise Refused(f"{position.size} samples are too few to take a zero")
    tip = position - force / load_cell_stiffness
    x, v, a = _derivatives(tip, window, sample_period)
    half = window // 2
    load = force[half:-half] - tip_mass * a
    columns = np.stack([x, v, np.ones(x.size)], axis=1)
    if np.ptp(x) < LEAST_MOTION:
        raise Refused("the coil does not move, so that contact cannot be told from an offset")
    (stiffness, _, zero), deviation = _least_squares(columns, load)
    if stiffness - 2.0 * deviation > CONTACT_STIFFNESS:
        raise Refused(
            f"the probe is in contact: it feels {stiffness:.0f} N/m; lift it, then tare again"
        )
    if stiffness + 2.0 * deviation > CONTACT_STIFFNESS:
        raise Refused(
            f"the coil moves too little to tell contact from free air ({stiffness:.0f} ± "
            f"{2.0 * deviation:.0f} N/m): give it more amplitude"
        )
    return float(zero)


def _derivatives(values: FloatArray, window: int, sample_period: float) -> list[FloatArray]:
    """Return value, rate and acceleration at the middle of each window, shape (n - window + 1,).

    From the quartic that fits the window best (Savitzky and Golay, 1964). SciPy has it, but takes
    a second to load, which every start of the driver would cost.
    """
    times = np.arange(window) - window // 2
    fits = np.linalg.pinv(np.vander(times, 5, increasing=True))[:3]
    return [
        np.correlate(values, factorial(order) * fit / sample_period**order, "valid")
        for order, fit in enumerate(fits)
    ]


def _least_squares(columns: FloatArray, values: FloatArray) -> tuple[FloatArray, float]:
    """Return the coefficients, and the standard deviation of the first."""
    scale = np.sqrt(np.mean(columns**2, axis=0))
    scaled = columns / scale
    found = np.linalg.lstsq(scaled, values, rcond=None)[0]
    variance = np.mean((values - scaled @ found) ** 2) * np.linalg.inv(scaled.T @ scaled)[0, 0]
    return found / scale, float(np.sqrt(variance) / scale[0])
