"""A probe's signals in free air and in contact, from the exact transfer function."""

from __future__ import annotations

import numpy as np

PERIOD = 5e-4
MASS, K0, BETA0 = 0.04, 9700.0, 0.8


def steady(
    lines: dict[float, float],
    duration: float,
    stiffness: float = 0.0,
    damping: float = 0.0,
    delay: float = 0.0,
    noise: float = 0.0,
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Position [m] and force [N] of a steady motion, amplitude [m] by frequency [Hz].

    The tip is on Kelvin-Voigt tissue of k [N/m] and beta [N s/m] (0: free air), F = k0 (u - x). The
    force comes ``delay`` [s] late.
    """
    time = np.arange(round(duration / PERIOD)) * PERIOD
    position, force = np.zeros(time.size), np.zeros(time.size)
    for frequency, amplitude in lines.items():
        s = 2.0j * np.pi * frequency
        tip = (K0 + BETA0 * s) / (MASS * s**2 + (BETA0 + damping) * s + K0 + stiffness)
        position += amplitude * np.sin(s.imag * time)
        force += (amplitude * K0 * (1.0 - tip) * np.exp(s * (time - delay))).imag
    rng = np.random.default_rng(seed)
    return np.round(position / 1e-7) * 1e-7, force + noise * rng.standard_normal(time.size)
