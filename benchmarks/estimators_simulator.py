"""A probe on tissue, simulated independently of the package: no equation or code is shared.

The coil moves as u = A sin(w t + phi); coil, tip and the constant forces together are one linear
system, whose matrix exponential is exact. Between two changes of the tissue, which need not fall
on a sample, nothing is approximated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm, solve_sylvester


@dataclass(frozen=True)
class Experiment:
    """One simulated measurement; SI units.

    ``tissue`` holds (time from which it is under the tip, stiffness, damping), the first at 0. The
    tip begins at ``start`` (position, velocity), or in the motion long after its beginning.
    """

    tissue: tuple[tuple[float, float, float], ...] = ((0.0, 450.0, 5.0),)
    duration: float = 1.0
    frequency: float = 10.0
    amplitude: float = 1e-3
    phase: float = 0.0
    force_noise: float = 5e-3
    encoder_resolution: float = 1e-7
    force_offset: float = 0.0
    contact_zero: float = 0.0
    samples_late: int = 0
    sample_period: float = 5e-4
    seed: int = 0
    tip_mass: float = 0.04
    load_cell_stiffness: float = 9700.0
    load_cell_damping: float = 0.8
    start: tuple[float, float] = (0.0, 0.0)
    steady: bool = False

    def run(self) -> tuple[np.ndarray, np.ndarray]:
        """Return measured position [m] and force [N] (positive in compression) of each sample."""
        position, tip = _motion(replace(self, seed=0))
        force = self.load_cell_stiffness * (position - tip) + self.force_offset
        random = np.random.default_rng(self.seed)
        force += self.force_noise * random.standard_normal(force.size)
        if self.encoder_resolution:
            position = np.round(position / self.encoder_resolution) * self.encoder_resolution
        if self.samples_late:
            position = np.r_[np.full(self.samples_late, position[0]), position][: force.size]
        return position, force

    def truth(self) -> tuple[np.ndarray, np.ndarray]:
        """Return stiffness [N/m] and damping [N s/m] at each sample."""
        time = np.arange(round(self.duration / self.sample_period)) * self.sample_period
        starts, stiffness, damping = np.array(self.tissue).T
        piece = np.searchsorted(starts, time, side="right") - 1
        return stiffness[piece], damping[piece]

    def _motion(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        start = self._steady_state() if self.steady else self.start
        state = np.array([*start, np.sin(self.phase), np.cos(self.phase), 1.0])
        states = np.empty((time.size, 5))
        ends = [start for start, _, _ in self.tissue[1:]] + [np.inf]
        sample, now = 0, 0.0
        for (_, stiffness, damping), end in zip(self.tissue, ends, strict=True):
            matrix = self._matrix(stiffness, damping)
            step = expm(matrix * self.sample_period)
            if sample < time.size and time[sample] < end:
                state = expm(matrix * (time[sample] - now)) @ state
                now = time[sample]
                states[sample] = state
                sample += 1
                while sample < time.size and time[sample] < end:
                    state = step @ state
                    now = time[sample]
                    states[sample] = state
                    sample += 1
            if sample < time.size:
                state = expm(matrix * (end - now)) @ state
                now = end
        return self.amplitude * states[:, 2], states[:, 0]

    def _matrix(self, stiffness: float, damping: float) -> np.ndarray:
        """Rate of change of [x, x', sin, cos, 1]."""
        w, a, m = 2 * np.pi * self.frequency, self.amplitude, self.tip_mass
        matrix = np.zeros((5, 5))
        matrix[0, 1] = 1.0
        matrix[1] = [
            -(self.load_cell_stiffness + stiffness) / m,
            -(self.load_cell_damping + damping) / m,
            a * self.load_cell_stiffness / m,
            a * w * self.load_cell_damping / m,
            stiffness * self.contact_zero / m,
        ]
        matrix[2, 3], matrix[3, 2] = w, -w
        return matrix

    def _steady_state(self) -> np.ndarray:
        """Tip position and velocity of the motion long after its start."""
        _, stiffness, damping = self.tissue[0]
        matrix = self._matrix(stiffness, damping)
        coil = np.array([np.sin(self.phase), np.cos(self.phase)])
        rotation = matrix[2:4, 2:4]
        # x' = A x + B c and x = S c with c' = W c give the Sylvester equation A S - S W = -B.
        steady = solve_sylvester(matrix[:2, :2], -rotation, -matrix[:2, 2:4])
        still = np.linalg.solve(matrix[:2, :2], -matrix[:2, 4])
        return steady @ coil + still


@lru_cache(maxsize=64)
def _motion(experiment: Experiment) -> tuple[np.ndarray, np.ndarray]:
    """Coil and tip without noise [m], kept for the next seed: that of a ramp takes seconds."""
    time = np.arange(round(experiment.duration / experiment.sample_period))
    coil, tip = experiment._motion(time * experiment.sample_period)
    coil.flags.writeable = tip.flags.writeable = False
    return coil, tip


@dataclass(frozen=True)
class HardeningTissue(Experiment):
    """Tissue whose force is k x (1 + ``hardening`` (x / mm)^2): no Kelvin-Voigt model fits it."""

    hardening: float = 0.2

    def _motion(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        (_, k, b), *_ = self.tissue
        w, m = 2 * np.pi * self.frequency, self.tip_mass

        def rate(t: float, state: np.ndarray) -> list[float]:
            x, v = state
            u = self.amplitude * np.sin(w * t + self.phase)
            du = self.amplitude * w * np.cos(w * t + self.phase)
            load_cell = self.load_cell_stiffness * (u - x) + self.load_cell_damping * (du - v)
            tissue = k * x * (1 + self.hardening * (x / 1e-3) ** 2) + b * v
            return [v, (load_cell - tissue) / m]

        solution = solve_ivp(rate, (0, time[-1]), self.start, "DOP853", time, rtol=1e-9, atol=1e-12)
        return self.amplitude * np.sin(w * time + self.phase), solution.y[0]


def simulate_ramp(
    before: tuple[float, float],
    after: tuple[float, float],
    start: float,
    length: float,
    duration: float,
) -> Experiment:
    """Return an experiment whose stiffness and damping go from one pair to another.

    Within ``length`` [s], in steps of a tenth of a sample, each at the ramp's value in its middle.
    """
    width = 5e-5
    times = start + width * np.arange(round(length / width))
    shares = (times - start + width / 2) / length
    values = np.outer(1 - shares, before) + np.outer(shares, after)
    pieces = [(t, *value) for t, value in zip(times, values, strict=True)]
    tissue = ((0.0, *before), *pieces, (start + length, *after))
    return Experiment(tissue=tissue, duration=duration)
