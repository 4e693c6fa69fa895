"""How the sensor's frame turns and accelerates, in its own axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.signals import FloatArray

#: Standard gravity, down along the base's z [m/s2]. That of a place differs by .3 % at most, which
#: is as if the mass did.
GRAVITY = np.array([0.0, 0.0, -9.80665])


@dataclass(frozen=True)
class Motion:
    """Of the sensor's frame, in its own axes; each of shape (n, 3).

    ``pull`` is gravity less the acceleration of the origin [m/s2], ``rate`` the angular velocity
    [rad/s], ``turning`` the angular acceleration [rad/s2].
    """

    pull: FloatArray
    rate: FloatArray
    turning: FloatArray


def motion(position: FloatArray, orientation: FloatArray, period: float) -> Motion:
    """Return the motion at every pose but the first and the last.

    Nothing is smoothed: each row comes of three poses, so that a filter may follow that the wrench
    passes, too.

    Parameters
    ----------
    position, orientation : array, shape (n, 3) and (n, 4)
        As ``FreeAir`` has them.
    period : float
        Between two poses [s].
    """
    acceleration = np.diff(position, 2, axis=0) / period**2
    steps = rotation_between(orientation[:-1], orientation[1:]) / period
    # A turn about an axis does not move it: both neighbouring frames see a step alike.
    before, after = steps[:-1], steps[1:]
    return Motion(
        pull=into_frame(orientation[1:-1], GRAVITY - acceleration),
        rate=0.5 * (before + after),
        turning=(after - before) / period,
    )


def rotation_between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the vectors [rad] by which frames turn into others, in their own axes, (n, 3)."""
    axis = np.cross(second[:, :3], first[:, :3])
    axis += first[:, 3:] * second[:, :3] - second[:, 3:] * first[:, :3]
    cosine = np.sum(first * second, axis=1)
    axis *= np.where(cosine < 0.0, -1.0, 1.0)[:, None]
    sine = np.linalg.norm(axis, axis=1)
    angle = 2.0 * np.arctan2(sine, np.abs(cosine))
    return axis * np.where(sine > 0.0, angle / np.maximum(sine, 1e-300), 2.0)[:, None]


def turn_orientation(orientation: FloatArray, turns: FloatArray) -> FloatArray:
    """Return one orientation, shape (4,), turned by vectors [rad] in its own axes, shape (n, 4)."""
    half = 0.5 * np.linalg.norm(turns, axis=1)[:, None]
    axis, scalar = 0.5 * np.sinc(half / np.pi) * turns, np.cos(half)
    own, real = orientation[:3], orientation[3]
    vector = np.cross(own, axis) + real * axis + scalar * own
    return np.column_stack([vector, real * scalar[:, 0] - axis @ own])


def into_frame(orientation: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return vectors of the base in the axes of frames, shape (n, 3)."""
    found: FloatArray = np.einsum(
        "nji,nj->ni", rotation(orientation), np.broadcast_to(vectors, (len(orientation), 3))
    )
    return found


def rotation(orientation: FloatArray) -> FloatArray:
    """Return the matrices that turn the frames' axes into the base's, shape (n, 3, 3)."""
    x, y, z, w = orientation.T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=-1),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=-1),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=-2,
    )
