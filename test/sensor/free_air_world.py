"""A tool of point masses on a moved frame: what its sensor feels, by each mass's own acceleration.

Shares no code with what is tested: frames by SciPy's rotations, accelerations by differences of
places in a fine course of time.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from tissue_probe.sensor.sensor_tracks import Track

RATE = 250.0
FINE = 1e-4  # s, between places whose second difference is an acceleration
FORCE_NOISE, TORQUE_NOISE = 0.1, 3e-3
EPOCH = 1_700_000_000_000_000_000  # ns


def _tool() -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(7)
    return np.full(8, 0.1), random.uniform([-0.05, -0.03, 0.0], [0.03, 0.05, 0.1], (8, 3))


@dataclass
class World:
    """A sensor with bias, drift, delay, and perhaps a cable whose force goes with two angles."""

    seed: int = 0
    swing: np.ndarray = field(default_factory=lambda: np.array([0.9, 0.9, 0.9]))
    delay: float = 4e-3
    cable: float = 0.0
    bias: np.ndarray = field(default_factory=lambda: np.array([3.0, -2.0, 4.0, 0.1, -0.1, 0.05]))
    drift: np.ndarray = field(
        default_factory=lambda: np.array([1.0, 0.5, -0.5, 0.02, 0.01, 0.0]) / 60.0
    )
    gains: np.ndarray = field(default_factory=lambda: np.ones(6))

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(self.seed)
        self.masses, self.places = _tool()

    @property
    def mass(self) -> float:
        return float(self.masses.sum())

    @property
    def centre(self) -> np.ndarray:
        return self.masses @ self.places / self.mass

    @property
    def inertia(self) -> np.ndarray:
        square = np.sum(self.places**2, axis=1)
        return np.einsum("i,ijk->jk", self.masses, square[:, None, None] * np.eye(3)) - np.einsum(
            "i,ij,ik->jk", self.masses, self.places, self.places
        )

    def swings(self) -> tuple[np.ndarray, np.ndarray]:
        return self.random.uniform(0.06, 0.4, (2, 3, 4)), self.random.uniform(0, 6.3, (2, 3, 4))

    def move(self, begin: float, seconds: float) -> tuple[Track, Track, Track, np.ndarray]:
        """Return poses, wrenches and angles as measured, and the wrench without noise and delay."""
        swings = self.swings()
        time = begin + np.arange(round(seconds * RATE)) / RATE
        angles, place = self._course(time, swings)
        turn = Rotation.from_euler("XYZ", angles)
        true = self._felt(time, swings) + self.bias + time[:, None] * self.drift
        late = self._felt(time - self.delay, swings) + self.bias + time[:, None] * self.drift
        noise = np.repeat([FORCE_NOISE, TORQUE_NOISE], 3) * self.random.normal(size=true.shape)
        shaken = Rotation.from_rotvec(5e-5 * self.random.normal(size=place.shape))
        place = place + 1e-5 * self.random.normal(size=place.shape)
        stamps = EPOCH + np.round(time * 1e9).astype(np.int64)
        poses = np.hstack([place, (turn * shaken).as_quat()])
        return Track(stamps, poses), Track(stamps, late + noise), Track(stamps, angles), true

    def _course(self, time, swings):
        frequency, phase = swings
        waves = np.sin(2.0 * np.pi * frequency * time[:, None, None, None] + phase).sum(axis=3)
        return self.swing * waves[:, 0] / 1.4, 0.05 * waves[:, 1]

    def _felt(self, time, swings):
        courses = [self._course(time + step, swings) for step in (-FINE, 0.0, FINE)]
        turns = [Rotation.from_euler("XYZ", angles) for angles, _ in courses]
        wrench = np.zeros((time.size, 6))
        for mass, own in zip(self.masses, self.places, strict=True):
            at = [turn.apply(own) + place for turn, (_, place) in zip(turns, courses, strict=True)]
            acceleration = (at[0] - 2.0 * at[1] + at[2]) / FINE**2
            force = mass * turns[1].inv().apply([0.0, 0.0, -9.80665] - acceleration)
            wrench += np.hstack([force, np.cross(own, force)])
        angles = courses[1][0]
        pull = np.stack([np.sin(angles[:, 1]), np.cos(angles[:, 2] + angles[:, 0])], axis=1)
        wrench[:, :2] += self.cable * pull
        wrench[:, 3:5] += 0.05 * self.cable * pull[:, ::-1]
        return self.gains * wrench
