"""Figure 6: the free probe after an impulse, and the result of a fit of its motion.

No filter is involved; the fit is how the paper found k0 and beta0.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.identification.ring_down import fit_ring_down, ring_down
from tissue_probe.reproduction.drawing import legend, panels
from tissue_probe.reproduction.experiment import (
    FORCE_NOISE,
    LOAD_CELL_DAMPING,
    LOAD_CELL_STIFFNESS,
    SAMPLE_PERIOD,
    TIP_MASS,
)
from tissue_probe.reproduction.finding import ReproducedQuantity, Reproduction

KICK = 8e-3  # m/s of the tip; makes 0.15 N, as in the figure
RING_TIMES = np.arange(round(0.2 / SAMPLE_PERIOD), dtype=float) * SAMPLE_PERIOD


def fig6() -> Reproduction:
    """Draw the force after an impulse, and the fit."""
    noise = FORCE_NOISE * np.random.default_rng(0).standard_normal(RING_TIMES.size)
    force = ring_down(RING_TIMES, LOAD_CELL_STIFFNESS, LOAD_CELL_DAMPING, TIP_MASS, KICK) + noise
    found = fit_ring_down(force, SAMPLE_PERIOD, TIP_MASS)
    figure, axes = panels(["force [N]"], "time [s]")
    axes["force [N]"].plot(RING_TIMES, force, color="0.65", linewidth=3.0, label="measured")
    fitted = axes["force [N]"].plot(RING_TIMES[found.begin :], found.fitted, label="fit")[0]
    fitted.set(color="#0072B2", linestyle="--")
    legend(figure)
    stiffness = f"{found.stiffness:.0f} ± {found.stiffness_deviation:.0f} N/m"
    damping = f"{found.damping:.3f} ± {found.damping_deviation:.3f} N s/m"
    frequency = f"{found.frequency:.1f} Hz"
    return Reproduction(
        figure,
        (
            ReproducedQuantity("k0 of the free probe", "9700 N/m", stiffness, "the same fit"),
            ReproducedQuantity("β0 of the free probe", "0.8 N s/m", damping, "the same fit"),
            ReproducedQuantity("resonance", "78 Hz", frequency, "the same fit"),
        ),
    )
