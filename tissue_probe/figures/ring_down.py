"""The force after an impulse on the free tip, and the swing that was fitted to it."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from tissue_probe.figures.shown_figure import ShownFigure
from tissue_probe.identification.ring_down import RingDown
from tissue_probe.signals import FloatArray

#: Swings shown after the fit's begin.
SWINGS = 20


def draw_ring_down(force: FloatArray, sample_period: float, found: RingDown) -> Figure:
    """Draw force and fit against the time since the impulse.

    Parameters
    ----------
    force : array, shape (n,)
        The fitted force, in any unit.
    sample_period : float
        Time between two samples [s].
    found : RingDown
        The fit.
    """
    swing = round(1.0 / (found.frequency * sample_period))
    impulse = max(0, found.begin - swing)
    time = (np.arange(force.size) - impulse) * sample_period
    last = found.begin + SWINGS * swing
    shown, fitted = slice(max(0, impulse - swing), last), slice(found.begin, last)
    figure = ShownFigure(figsize=(8.0, 4.5), layout="constrained")
    axes = figure.subplots()
    axes.plot(time[shown], force[shown], color="0.65", linewidth=3.0, label="measured")
    drawn = found.fitted[: SWINGS * swing]
    axes.plot(time[fitted], drawn, linestyle="--", color="#0072B2", label="fit")
    axes.set(xlabel="time [s]", ylabel="force, as recorded")
    axes.set_title(
        f"k0 = {found.stiffness:.0f} N/m, β0 = {found.damping:.3g} N s/m, {found.frequency:.1f} Hz"
    )
    axes.grid(alpha=0.3)
    axes.legend()
    return figure
