"""The wrench of a cable: a smooth function of where its ends are to one another.

A cable from the forearm to the tool pulls by how the joints between them stand: products of 1,
cosine and sine of the angles of up to three joints. Where these are not told, the orientation's
angles and the place stand for them, which is the same only as long as the arm before the wrist
hardly moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.sensor.free_air import FreeAir
from tissue_probe.sensor.kinematics import rotation
from tissue_probe.signals import FloatArray

#: More joints would need more functions than a minute of poses can tell: 3 to their power.
MOST_JOINTS = 3


@dataclass(frozen=True)
class CableFunctions:
    """The functions, which are the same in all axes of the wrench.

    Attributes
    ----------
    joints : int
        How many joints are told; 0 for the pose.
    frame : array, shape (3, 3)
        An orientation in the middle of all, from which angles count.
    place : array, shape (3,)
        The middle of all places [m].
    reach : float
        How far places are from it, rms [m].
    """

    joints: int
    frame: FloatArray
    place: FloatArray
    reach: float

    @classmethod
    def about(cls, runs: list[FreeAir]) -> CableFunctions:
        """Return the functions about the middle of all poses."""
        position = np.concatenate([run.position for run in runs])
        turns = rotation(np.concatenate([run.orientation for run in runs]))
        u, _, v = np.linalg.svd(turns.mean(axis=0))
        frame = u @ np.diag([1.0, 1.0, np.linalg.det(u @ v)]) @ v
        place = position.mean(axis=0)
        reach = float(np.sqrt(np.mean((position - place) ** 2)))
        return cls(runs[0].joints.shape[1], frame, place, max(reach, 1e-3))

    @property
    def groups(self) -> list[slice]:
        """Functions whose weights are of one size."""
        if self.joints:
            return [slice(0, 3**self.joints - 1)]
        return [slice(0, 26), slice(26, 29), slice(29, 56)]

    @property
    def count(self) -> int:
        """How many there are."""
        return int(self.groups[-1].stop)

    def columns(self, run: FreeAir) -> FloatArray:
        """Return their values, shape (n, count)."""
        if self.joints:
            return _products(run.joints)
        turned = self.frame.T @ rotation(run.orientation)
        away = (run.position - self.place) / self.reach
        both = (away[:, :, None] * turned.reshape(-1, 1, 9)).reshape(-1, 27)
        return np.concatenate([_products(_angles(turned)), away, both], axis=1)


def _products(angles: FloatArray) -> FloatArray:
    """Return all products of 1, cosine and sine of each angle, but the constant."""
    columns = np.ones((len(angles), 1))
    for angle in angles.T:
        factors = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=1)
        columns = (columns[:, :, None] * factors[:, None]).reshape(len(angles), -1)
    return columns[:, 1:]


def _angles(turned: FloatArray) -> FloatArray:
    """Return the angles about x, y, z that make up a turn, one after another, shape (n, 3)."""
    x = np.arctan2(-turned[:, 1, 2], turned[:, 2, 2])
    y = np.arcsin(np.clip(turned[:, 0, 2], -1.0, 1.0))
    z = np.arctan2(-turned[:, 0, 1], turned[:, 0, 0])
    return np.stack([x, y, z], axis=1)
