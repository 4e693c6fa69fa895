"""Figure 6: the free probe after an impulse, and what a fit of its motion gives.

No filter is involved; the fit is how the paper found k0 and beta0.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import curve_fit

from tissue_probe.reproduction.drawing import legend, panels
from tissue_probe.reproduction.experiment import (
    FORCE_NOISE,
    LOAD_CELL_DAMPING,
    LOAD_CELL_STIFFNESS,
    SAMPLE_PERIOD,
    TIP_MASS,
)
from tissue_probe.reproduction.finding import Finding, Reproduction
from tissue_probe.signals import FloatArray

KICK = 8e-3  # m/s of the tip; makes 0.15 N, as in the figure
TIME = np.arange(round(0.2 / SAMPLE_PERIOD)) * SAMPLE_PERIOD


def ring_down(time: FloatArray, stiffness: float, damping: float, kick: float) -> FloatArray:
    """Return the force [N] of m x'' = -k0 x - beta0 x' that begins at x = 0, x' = kick [m/s]."""
    decay = damping / (2.0 * TIP_MASS)
    rate = np.sqrt(stiffness / TIP_MASS - decay**2)
    return stiffness * kick / rate * np.exp(-decay * time) * np.sin(rate * time)


def fig6() -> Reproduction:
    """Draw the force after an impulse, and the fit."""
    noise = FORCE_NOISE * np.random.default_rng(0).standard_normal(TIME.size)
    force = ring_down(TIME, LOAD_CELL_STIFFNESS, LOAD_CELL_DAMPING, KICK) + noise
    start = (0.9 * LOAD_CELL_STIFFNESS, 2.0 * LOAD_CELL_DAMPING, KICK)
    found, covariance = curve_fit(ring_down, TIME, force, start)
    figure, axes = panels(["force [N]"], "time [s]")
    axes["force [N]"].plot(TIME, force, color="0.65", linewidth=3.0, label="measured")
    fit = ring_down(TIME, *found)
    axes["force [N]"].plot(TIME, fit, color="#0072B2", linestyle="--", label="fit")
    legend(figure)
    deviation = np.sqrt(np.diagonal(covariance))
    stiffness = f"{found[0]:.0f} ± {deviation[0]:.0f} N/m"
    damping = f"{found[1]:.3f} ± {deviation[1]:.3f} N s/m"
    frequency = f"{np.sqrt(found[0] / TIP_MASS) / (2.0 * np.pi):.1f} Hz"
    return Reproduction(
        figure,
        (
            Finding("k0 of the free probe", "9700 N/m", stiffness, "the same fit"),
            Finding("β0 of the free probe", "0.8 N s/m", damping, "the same fit"),
            Finding("resonance", "78 Hz", frequency, "the same fit"),
        ),
    )
