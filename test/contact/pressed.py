"""A tip that presses to and fro on a spring and a damper, as a robot's sensors tell it.

The motion is a formula, so that depth, speed and acceleration are exact at every time. It shares no
code with the package.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RATE = 250.0  # Hz
TRAVEL, PRELOAD = 1e-3, 2e-3  # m: half the way, and its middle
BIAS, DRIFT = 5.0, 1.0 / 60.0  # N, N/s


@dataclass(frozen=True)
class Pressed:
    """A robot on a tissue; the frequency sweeps from 1 to 4 Hz, or stays where ``sweep`` is 0."""

    stiffness: float = 1000.0
    damping: float = 3.0
    mass: float = 0.8
    delay: float = 4e-3
    seconds: float = 4.0
    sweep: float = 1.5  # Hz to either side of the middle
    middle: float = 2.5  # Hz
    touch: float = 0.0  # m
    noise: float = 0.1  # N
    place_noise: float = 1e-5  # m
    stiffening: float = 0.0  # N/m2, at the middle of the travel 0

    def table(self, seed: int = 0) -> dict[str, np.ndarray]:
        random = np.random.default_rng(seed)
        time = np.arange(round(self.seconds * RATE)) / RATE
        phases = random.uniform(0.0, 2.0 * np.pi, 2)
        depth, _, _ = self._motion(time, phases)
        felt, speed, acceleration = self._motion(time - self.delay, phases)
        tissue = self.stiffness * (felt - self.touch) + self.damping * speed
        tissue += self.stiffening * (felt - PRELOAD) ** 2
        tissue = np.where(felt > self.touch, np.maximum(tissue, 0.0), 0.0)
        force = tissue + self.mass * acceleration + BIAS + DRIFT * time
        return {
            "t": time,
            "position": depth + self.place_noise * random.normal(size=time.size),
            "force": force + self.noise * random.normal(size=time.size),
        }

    def _motion(self, time, phases):
        each = 0.5  # sweeps a second
        turned = 2.0 * np.pi * each * time + phases[0]
        phase = 2.0 * np.pi * self.middle * time + self.sweep / each * np.sin(turned) + phases[1]
        rate = 2.0 * np.pi * (self.middle + self.sweep * np.cos(turned))
        gain = -2.0 * np.pi * self.sweep * 2.0 * np.pi * each * np.sin(turned)
        speed = TRAVEL * rate * np.cos(phase)
        acceleration = TRAVEL * (gain * np.cos(phase) - rate**2 * np.sin(phase))
        return PRELOAD + TRAVEL * np.sin(phase), speed, acceleration
