"""Where the search for a base model begins.

Contents: values read off the samples without simulating.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.transforms import smooth_values
from tissue_probe.quantities import FORCE

#: Stiffnesses [N/m] from which the force of a known motion is fitted.
STIFFNESSES = (300.0, 2000.0)
#: Samples, and degree, of the polynomials that give a motion's derivatives: of short ones noise
#: hides the mass, long ones flatten quick motion.
WINDOWS, DEGREE = (9, 33, 129), 4


def first_guesses(measurements: Sequence[Measurement]) -> list[dict[str, float]]:
    """Return values by name from which to begin, each in its turn.

    The force of a known motion is nearly linear in the unknowns, so that any stiffness will do.
    The motion under a known force is not: its resonance must be met. There the equation of motion
    itself is regressed first, on derivatives of the measured position.
    """
    if measurements[0].input is not FORCE:
        times = measurements[0].scale.of("N/m")
        return [{"stiffness": times * stiffness} for stiffness in STIFFNESSES]
    longest = max(measurements, key=lambda each: each.position.size)
    windows = [window for window in WINDOWS if 2 * window < longest.position.size]
    return [_regress_force(longest, window) for window in windows]


def _regress_force(measurement: Measurement, window: int) -> dict[str, float]:
    """Regress F = c + k x + beta x' + m x''; a negative value is left to its default."""
    period = measurement.sample_period
    orders = [
        smooth_values(measurement.position, window, DEGREE, order, period) for order in range(3)
    ]
    columns = np.stack([*orders, np.ones_like(orders[0])], axis=1)
    scale = np.abs(columns).max(axis=0) + 1e-300
    force = smooth_values(measurement.force, window, DEGREE)
    found = np.linalg.lstsq(columns / scale, force, rcond=None)[0] / scale
    names = ("stiffness", "damping", "tip_mass")
    return {name: value for name, value in zip(names, found[:3], strict=True) if value > 0}
