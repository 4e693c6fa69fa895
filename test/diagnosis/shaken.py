"""A mass on tissue under a known force, by SciPy's integrator: no code is shared with the fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

PERIOD, DURATION, ENCODER = 5e-4, 2.0, 2e-7
FREQUENCIES = np.arange(1.0, 61.0, 2.0)
TIMES = np.arange(round(DURATION / PERIOD)) * PERIOD


@dataclass(frozen=True)
class Specimen:
    """What is shaken [SI units]; dry friction turns at 1 mm/s."""

    mass: float = 0.08
    stiffness: float = 600.0
    damping: float = 6.0
    cubic: float = 0.0
    relaxing: float = 0.0
    relaxation_rate: float = 40.0
    friction: float = 0.0
    leaves: bool = False

    def rates(self, force: float, state: np.ndarray) -> list[float]:
        """Return the derivatives of position, speed and the relaxing branch's force."""
        x, v, branch = state
        tissue = self.stiffness * x + self.damping * v + self.cubic * x**3 + branch
        if self.leaves and x < 0:
            tissue = 0.0
        drag = self.friction * np.tanh(v / 1e-3)
        relaxed = self.relaxing * v - self.relaxation_rate * branch
        return [v, (force - tissue - drag) / self.mass, relaxed]


def push(times: np.ndarray, preload: float = 1.0, amplitude: float = 1.2) -> np.ndarray:
    """Force of a multisine, begun gently about a preload [N]."""
    phases = np.random.default_rng(3).uniform(0, 2 * np.pi, FREQUENCIES.size)
    waves = np.sin(2 * np.pi * np.outer(times, FREQUENCIES) + phases)
    sizes = amplitude / np.sqrt(FREQUENCIES.size) / np.sqrt(1 + (FREQUENCIES / 15.0) ** 2)
    return preload + waves @ sizes * np.minimum(times / 0.05, 1.0) ** 2


def shaken(specimen: Specimen, **of_push: float) -> np.ndarray:
    """Return the position [m] at ``TIMES``, from rest under the preload, as an encoder reads it."""
    force = push(np.zeros(1), **of_push)[0]
    begin = brentq(lambda x: specimen.stiffness * x + specimen.cubic * x**3 - force, 0.0, 1.0)
    solved = solve_ivp(
        lambda t, state: specimen.rates(push(np.array([t]), **of_push)[0], state),
        (0.0, TIMES[-1]),
        [begin, 0.0, 0.0],
        "DOP853",
        TIMES,
        rtol=1e-8,
        atol=1e-11,
        max_step=2e-3,
    )
    return solved.y[0] + ENCODER * np.random.default_rng(1).standard_normal(TIMES.size)
