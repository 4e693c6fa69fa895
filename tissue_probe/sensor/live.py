"""The wrench that is left, sample by sample, as pose and wrench come.

Gravity is that of the orientation as it comes, between two poses. Inertia needs derivatives: of a
cubic through the poses of a window, which ends at the newest pose that may be waited for. The
window is longer where poses are few.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from tissue_probe.sensor.compensation import Compensation
from tissue_probe.sensor.free_air import FreeAir
from tissue_probe.sensor.kinematics import (
    GRAVITY,
    Motion,
    into_frame,
    rotation_between,
    turn_orientation,
)
from tissue_probe.sensor.sensor_tracks import LOWEST_SAMPLE_RATE
from tissue_probe.signals import NANOSECONDS, FloatArray, IntArray

POSE_WINDOW = 0.12
"""Of the poses whose derivatives are taken [s]. At its end noise of the poses grows with a shorter
window, and the cubic's error with a longer one: an arm at .5 m/s2 has .03 N of the first at 0.8 kg,
and .07 N at most of the second where it turns with 4 rad/s."""
WINDOW_MIDDLE = 0.5 * POSE_WINDOW
"""So long after a moment its window ends at best [s]: the acceleration that a window tells is a
mean over all of it, which is nearest to that of its middle."""
FEWEST_POSES = 8
"""Poses in a window: two for each number of the cubic. ``POSE_WINDOW`` with fewer is longer."""
LONGEST_WINDOW = FEWEST_POSES / LOWEST_SAMPLE_RATE
"""So long at most [s]: at the slowest rate that is identified one pose may be missing."""
COVERED = 0.75
"""Of a window poses must cover so much: a shorter one has twice the noise."""
HOLE = 0.5 * POSE_WINDOW
"""A longer time without a pose [s] is a hole: beside it the cubic would hold on to one half."""
KEPT = 2.0
"""Poses are kept so long [s]: longer than any delay and any window."""


@dataclass(frozen=True)
class Left:
    """The wrench that is left at a stamp [ns], its standard deviation, and how the sensor moved.

    ``wrench``, ``deviation``, and ``biased``, from which the bias is not taken, have shape (6,),
    ``moved`` (3,): acceleration [m/s2], angular velocity [rad/s] and acceleration [rad/s2].
    """

    stamp: int
    wrench: FloatArray
    deviation: FloatArray
    biased: FloatArray
    moved: FloatArray


class LiveCompensation:
    """Takes poses and wrenches in the order of each; gives the wrench that is left.

    Parameters
    ----------
    model : Compensation
        Of the sensor.
    late : float
        The wrench is given so long after the pose that belongs to it [s]; with ``WINDOW_MIDDLE``
        its inertia is most exact, with 0 it is given at once.

    Attributes
    ----------
    model : Compensation
        May be exchanged at any time.
    """

    def __init__(self, model: Compensation, late: float) -> None:
        self.model = model
        self._ahead = min(late, WINDOW_MIDDLE)
        self._stamps: IntArray = np.empty(0, dtype=np.int64)
        self._rows: FloatArray = np.empty((0, 7))
        self._new: list[tuple[int, FloatArray]] = []
        self._waiting: deque[tuple[int, FloatArray]] = deque()

    def take_pose(self, stamp: int, row: FloatArray) -> None:
        """Take a pose: x, y, z [m], quaternion x, y, z, w, and the joints of a cable [rad]."""
        last = self._new[-1][0] if self._new else self._stamps[-1] if self._stamps.size else None
        if last is not None and stamp <= last:
            if last - stamp < KEPT * NANOSECONDS:
                return
            self.forget()  # the clock was set back
        self._new.append((stamp, row))

    def take_wrench(self, stamp: int, wrench: FloatArray) -> None:
        """Take a wrench: force [N], torque [N m], in the sensor's axes."""
        self._waiting.append((stamp, wrench))
        # No pose comes for these any more: the poses have ended, or a clock was set.
        while abs(stamp - self._waiting[0][0]) > KEPT * NANOSECONDS:
            self._waiting.popleft()

    def forget(self) -> None:
        """Forget all poses and wrenches."""
        self._stamps, self._rows, self._new = self._stamps[:0], self._rows[:0], []
        self._waiting.clear()

    def take_known(self) -> list[Left]:
        """Return those that have become known; wrenches without poses about them are let go."""
        self._keep()
        known: list[tuple[int, FloatArray, FloatArray]] = []
        while self._waiting and len(self._stamps) >= FEWEST_POSES:
            stamp, wrench = self._waiting[0]
            moment = stamp - round(self.model.delay * NANOSECONDS)
            last = moment + round(self._ahead * NANOSECONDS)
            if self._stamps[-1] < last:
                break
            self._waiting.popleft()
            if (state := self._state(moment, last)) is not None:
                known.append((stamp, wrench, state))
        return self._compensated(known) if known else []

    def _keep(self) -> None:
        """Add the new poses, and let the old ones go."""
        if not self._new:
            return
        stamps = [stamp for stamp, _ in self._new]
        first = int(np.searchsorted(self._stamps, stamps[-1] - KEPT * NANOSECONDS))
        rows = np.array([row for _, row in self._new])
        before = self._rows[first:] if self._rows.shape[1] == rows.shape[1] else rows[:0]
        self._stamps = np.append(self._stamps[first:][: len(before)], stamps).astype(np.int64)
        self._rows = np.concatenate([before, rows])
        self._new = []

    def _state(self, moment: int, last: int) -> FloatArray | None:
        """Return accelerations, rates, and the pose itself at a moment; none in a hole of poses."""
        first = last - round(POSE_WINDOW * NANOSECONDS)
        # The moment lies between two poses: one at its end, or after it, belongs to the window.
        begin, end = np.searchsorted(self._stamps, (first, last)) + np.array([0, 1])
        part = slice(max(0, min(begin, end - FEWEST_POSES)), end)
        time = (self._stamps[part] - moment) / NANOSECONDS
        after = int(np.searchsorted(time, 0.0))
        if len(time) < FEWEST_POSES or not 0 < after < len(time):
            return None
        if (
            not COVERED * POSE_WINDOW <= time[-1] - time[0] <= LONGEST_WINDOW
            or np.diff(time).max() > HOLE
        ):
            return None
        near = self._rows[part]
        turns, reference = near[:, 3:7], near[after - 1, 3:7]
        angles = rotation_between(np.broadcast_to(reference, turns.shape), turns)
        powers = (time / POSE_WINDOW)[:, None] ** np.arange(4)
        course = np.hstack([near[:, :3], angles])
        cubic = np.linalg.solve(powers.T @ powers, powers.T @ course)
        share = -time[after - 1] / (time[after] - time[after - 1])
        now = near[after - 1] + share * (near[after] - near[after - 1])
        now[3:7] = turn_orientation(reference, share * angles[after : after + 1])[0]
        return np.concatenate([2.0 * cubic[2] / POSE_WINDOW**2, cubic[1, 3:] / POSE_WINDOW, now])

    def _compensated(self, known: list[tuple[int, FloatArray, FloatArray]]) -> list[Left]:
        states = np.array([state for _, _, state in known])
        acceleration, turning, rate = states[:, :3], states[:, 3:6], states[:, 6:9]
        position, orientation, joints = states[:, 9:12], states[:, 12:16], states[:, 16:]
        moved = Motion(into_frame(orientation, GRAVITY - acceleration), rate, turning)
        empty = np.zeros((len(states), 6))
        pulled = self.model.predict_pull(
            moved, FreeAir(0.0, 1.0, position, orientation, empty, joints)
        )
        sizes = np.stack(
            [np.linalg.norm(each, axis=1) for each in (acceleration, rate, turning)], axis=1
        )
        found = []
        for (stamp, wrench, _), pull, size in zip(known, pulled, sizes, strict=True):
            bias, deviation = self.model.predict_bias(stamp)
            biased = wrench - pull
            found.append(Left(stamp, biased - bias, deviation, biased, size))
        return found
