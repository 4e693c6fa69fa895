"""Poses and wrenches of a robot that touches nothing, on one even grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.signals import FloatArray

#: Of the wrench, in this order.
WRENCH_AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
#: Their unit.
WRENCH_UNITS = ("N", "N", "N", "N m", "N m", "N m")
#: A force's newton is so much of a torque [N m]: the length of a hand tool, some 3 cm.
SIZES = np.array([1.0, 1.0, 1.0, 0.03, 0.03, 0.03])


@dataclass(frozen=True)
class FreeAir:
    """One stretch without a hole, of the sensor's frame.

    Attributes
    ----------
    begin : float
        Time of the first row [s].
    period : float
        Between two rows [s].
    position : array, shape (n, 3)
        Of the sensor's origin in the base, whose z is up [m].
    orientation : array, shape (n, 4)
        Unit quaternion x, y, z, w that turns the sensor's axes into the base's.
    wrench : array, shape (n, 6)
        As measured: force [N] and torque [N m] in the sensor's axes.
    joints : array, shape (n, j)
        Angles of the joints that the cable runs along [rad]; j is 0 where they are not told.
    """

    begin: float
    period: float
    position: FloatArray
    orientation: FloatArray
    wrench: FloatArray
    joints: FloatArray

    @property
    def seconds(self) -> float:
        """How long it lasts."""
        return len(self.wrench) * self.period
