"""The numbers that a fit tells, and those that it cannot tell.

A number is told where its error makes less of a wrench than the sensor's own noise, in usual
motion: turned over in gravity, turning at 2 rad/s and 5 rad/s2, half a minute after.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.sensor.free_air import WRENCH_AXES, WRENCH_UNITS
from tissue_probe.sensor.numbers import (
    BIAS_PLACES,
    CORE,
    DELAY_PLACE,
    GAINS,
    LOAD,
    RATE_PLACES,
    Point,
    gain_columns,
)
from tissue_probe.signals import FloatArray

#: Usual motion: gravity [m/s2], angular velocity [rad/s] and acceleration [rad/s2], and how long
#: after [s].
TURNED_OVER, TURNING_SPEED, SPINS_UP, USED_FOR = 9.8, 2.0, 5.0, 30.0

#: Numbers whose part a cable's smooth function of the pose can play, too.
CABLE_SHARES = ("mass", "centre", "gain", "bias")


@dataclass(frozen=True)
class SensorNumber:
    """One number: name, unit, value, and the standard deviation of its error.

    ``error_of_wrench`` is how much of a wrench this error makes in usual motion, over the noise;
    ``one_function`` whether the cable can play its part, so that it is not told by itself.
    """

    name: str
    unit: str
    value: float
    deviation: float
    error_of_wrench: float
    one_function: bool = False

    @property
    def told(self) -> bool:
        """Whether the error counts for less than the sensor's noise."""
        return self.error_of_wrench < 1.0 and not self.one_function


def numbers(
    point: Point, covariance: FloatArray, noise: FloatArray, cabled: bool = False
) -> list[SensorNumber]:
    """Return mass, centre, inertia, ratios of gains, delay, biases and drifts.

    Parameters
    ----------
    point : Point
        The fitted one; a negative mass is that of a sensor that tells the reaction.
    covariance : array, shape (p, p)
        Of its errors; of p the first ``CORE`` count.
    noise : array, shape (6,)
        Standard deviation of the wrench's noise.
    cabled : bool
        Whether a cable is part of the fit.
    """
    values, covariance = point.values[:CORE], covariance[:CORE, :CORE]
    force, torque = noise[:3].max(), noise[3:].max()
    sign = polarity(point)
    rows: list[tuple[str, str, float, FloatArray, float]] = []

    def add(name: str, unit: str, value: float, columns: FloatArray, worth: float) -> None:
        rows.append((name, unit, value, columns, worth))

    unit = np.eye(CORE)
    mass = sign * values[0]
    add("mass", "kg", mass, unit[0], TURNED_OVER / force)
    heavy = max(mass, 1e-9)
    for axis, letter in enumerate("xyz"):
        centre = sign * values[1 + axis] / heavy
        slope = (unit[1 + axis] - centre * unit[0]) / heavy
        add(f"centre_{letter}", "m", centre, slope, TURNED_OVER * heavy / torque)
    for place, pair in enumerate(("xx", "yy", "zz", "xy", "xz", "yz"), 4):
        add(f"inertia_{pair}", "kg m2", sign * values[place], unit[place], SPINS_UP / torque)
    gains, slopes = point.gains, gain_columns()
    pulled = TURNED_OVER * np.abs(values[0]), TURNED_OVER * np.linalg.norm(values[1:4])
    for axis, name in enumerate(WRENCH_AXES):
        slope = np.zeros(CORE)
        slope[GAINS] = gains[axis] * slopes[axis]
        worth = pulled[axis // 3] / noise[axis]
        add(f"gain_{name}", "1", float(gains[axis]), slope, worth)
    add("delay", "s", values[DELAY_PLACE], unit[DELAY_PLACE], TURNING_SPEED * pulled[0] / force)
    for axis, name in enumerate(WRENCH_AXES):
        place = BIAS_PLACES.start + axis
        add(f"bias_{name}", WRENCH_UNITS[axis], values[place], unit[place], 1.0 / noise[axis])
    for axis, name in enumerate(WRENCH_AXES):
        place = RATE_PLACES.start + axis
        worth = USED_FOR / noise[axis]
        add(f"drift_{name}", f"{WRENCH_UNITS[axis]}/s", values[place], unit[place], worth)
    found = []
    for name, of_what, value, slope, worth in rows:
        deviation = float(np.sqrt(slope @ covariance @ slope))
        one = cabled and name.startswith(CABLE_SHARES)
        found.append(SensorNumber(name, of_what, float(value), deviation, deviation * worth, one))
    return found


def polarity(point: Point) -> float:
    """Return 1 where the sensor tells the pull of the load, -1 where the reaction to it."""
    return -1.0 if point.values[LOAD][0] < 0.0 else 1.0
