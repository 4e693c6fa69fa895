"""The wrench of a load that hangs rigidly on a sensor.

With mass m, centre c and inertia I about the sensor's origin, all in the sensor's axes, s gravity
less the origin's acceleration, w and a the angular velocity and acceleration:

    f = m s - a x mc - w x (w x mc)
    t = mc x s - I a - w x I w

(Newton and Euler): linear in m, mc, I, which are the ten numbers of a rigid body.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.sensor.kinematics import Motion
from tissue_probe.signals import FloatArray

#: m [kg], m c [kg m], I [kg m2] as xx, yy, zz, xy, xz, yz.
NUMBERS = 10
_PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def load_columns(motion: Motion) -> FloatArray:
    """Return the wrench that a unit of each of the ten numbers adds, shape (n, 6, 10)."""
    s, w, a = motion.pull, motion.rate, motion.turning
    columns = np.zeros((len(s), 6, NUMBERS))
    columns[:, :3, 0] = s
    for axis, unit in enumerate(np.eye(3)):
        columns[:, :3, 1 + axis] = -np.cross(a, unit) - np.cross(w, np.cross(w, unit))
        columns[:, 3:, 1 + axis] = np.cross(unit, s)
    for number, (i, j) in enumerate(_PLACES):
        inertia = np.zeros((3, 3))
        inertia[i, j] = inertia[j, i] = 1.0
        columns[:, 3:, 4 + number] = -a @ inertia - np.cross(w, w @ inertia)
    return columns
