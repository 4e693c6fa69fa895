"""A probe on tissue to test residuals with: Runge-Kutta at 40 kHz, sharing no code with physics.

Returned are the forces with and without noise, so that a test knows both the truth and what a
Kelvin-Voigt model would have predicted of the same motion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from scipy.optimize import least_squares

STEPS = 20  # of the integrator to a sample


@njit(cache=True)
def _rate(x, v, u, du, tissue):
    stiffness, damping, cubic, coulomb, losing = tissue
    force = stiffness * x + damping * v + cubic * x**3
    if losing and (x < 0.0 or force < 0.0):
        force = 0.0
    force += coulomb * np.tanh(v / 1e-4)
    return (9700.0 * (u - x) + 0.8 * (du - v) - force) / 0.04


@njit(cache=True)
def _tip(u, du, step, tissue, x):
    """Return the tip's position at every second point of u, which has two points to a step."""
    tip, v = np.empty(u.size // 2 + 1), 0.0
    for n in range(tip.size):
        tip[n] = x
        if n == tip.size - 1:
            break
        a, b, c = 2 * n, 2 * n + 1, 2 * n + 2
        k1, l1 = v, _rate(x, v, u[a], du[a], tissue)
        k2 = v + step / 2 * l1
        l2 = _rate(x + step / 2 * k1, k2, u[b], du[b], tissue)
        k3 = v + step / 2 * l2
        l3 = _rate(x + step / 2 * k2, k3, u[b], du[b], tissue)
        k4 = v + step * l3
        l4 = _rate(x + step * k3, k4, u[c], du[c], tissue)
        x += step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        v += step / 6 * (l1 + 2 * l2 + 2 * l3 + l4)
    return tip


@dataclass(frozen=True)
class Specimen:
    """Tissue under the paper's probe; SI units. ``noise`` is white, of the force."""

    stiffness: float = 800.0
    damping: float = 4.0
    cubic: float = 0.0
    coulomb: float = 0.0
    contact_loss: bool = False
    preload: float = 0.0
    noise: float = 5e-3
    sample_period: float = 5e-4

    def steps(self, duration):
        """Return the times at which the integrator looks at the motion [s]."""
        count = round(duration / self.sample_period)
        return self.sample_period / STEPS / 2 * np.arange(2 * STEPS * (count - 1) + 1)

    def measure(self, motion, duration=2.0, seed=0):
        """Return position, tip position, force without noise and measured force, each (N,)."""
        half = self.sample_period / STEPS / 2
        count = round(duration / self.sample_period)
        u = motion(self.steps(duration)) + self.preload
        tissue = (self.stiffness, self.damping, self.cubic, self.coulomb, self.contact_loss)
        start = self.preload * 9700.0 / (9700.0 + self.stiffness)
        tip = _tip(u, np.gradient(u, half), 2 * half, tissue, start)[::STEPS]
        position = u[:: 2 * STEPS]
        force = 9700.0 * (position - tip)
        noise = self.noise * np.random.default_rng(seed).standard_normal(count)
        return position, tip, force, force + noise


def sine(frequency=10.0, amplitude=1e-3):
    """Return A sin(2 pi f t)."""
    return lambda t: amplitude * np.sin(2 * np.pi * frequency * t)


def chirp(start=1.0, stop=60.0, duration=4.0, amplitude=1e-3):
    """Return a sine whose frequency rises evenly from ``start`` to ``stop``."""
    return lambda t: (
        amplitude * np.sin(2 * np.pi * (start * t + (stop - start) * t**2 / (2 * duration)))
    )


def multisine(lines=range(1, 61), amplitude=1e-3, seed=0):
    """Return a multisine of random phases on whole frequencies; its rms is amplitude / sqrt(2)."""
    lines = np.array(lines, dtype=float)
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, lines.size)
    scale = amplitude / np.sqrt(lines.size)
    return lambda t: (
        scale
        * sum(np.sin(2 * np.pi * f * t + p) - np.sin(p) for f, p in zip(lines, phases, strict=True))
    )


def kelvin_voigt_residual(specimen, motion, duration=2.0, seed=0):
    """Return position, tip position, predicted force and residual of the best Kelvin-Voigt fit."""
    coil = motion(specimen.steps(duration))
    position, _, _, measured = specimen.measure(lambda _: coil, duration, seed)

    def model(parameters):
        stiffness, damping = parameters
        plain = Specimen(stiffness, damping, preload=specimen.preload, noise=0.0)
        return replace(plain, sample_period=specimen.sample_period).measure(
            lambda _: coil, duration
        )

    fit = least_squares(
        lambda p: model(p)[2] - measured, (specimen.stiffness, specimen.damping), x_scale=(100, 1)
    )
    _, tip, predicted, _ = model(fit.x)
    return position, tip, predicted, measured - predicted
