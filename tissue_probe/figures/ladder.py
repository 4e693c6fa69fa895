"""The ladder of an improvement as a picture: the error of each model, falling to the noise.

What belongs here: how the ladder looks. What does not: which effect is added when
(``diagnosis``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogFormatter

from tissue_probe.quantities import FORCE, Quantity
from tissue_probe.signals import FloatArray

STEP_WIDTH = 2.0  # inches
LONG = 20  # characters

# Okabe and Ito's colours, told apart by every eye; marks and dashes tell them apart in grey.
_TRAINING = {
    "color": "#E69F00",
    "marker": "s",
    "linestyle": "--",
    "markersize": 13,
    "markerfacecolor": "none",
    "markeredgewidth": 1.8,
}
_HELDOUT = {"color": "#0072B2", "marker": "o", "linestyle": "-", "markersize": 9}
_NOISE = {"color": "black", "linestyle": ":", "linewidth": 1.6}


def draw_ladder(
    models: Sequence[str],
    training: Sequence[float],
    heldout: Sequence[float],
    noise: float,
    output: Quantity = FORCE,
) -> Figure:
    """Draw the rms error of each model on the data it was fitted to, and on data held out.

    Parameters
    ----------
    models : sequence of str
        Name of each step, in order: the base model, then what was added or dropped.
    training, heldout : sequence of float
        Root mean square of measured minus predicted output; NaN where there is none.
    noise : float
        Standard deviation of the output's white noise: what no model can explain.
    output : Quantity
        What the models predict.

    Raises
    ------
    ValueError
        If the sequences are empty or differ in length.
    """
    if not models or not len(models) == len(training) == len(heldout):
        raise ValueError(
            f"{len(models)} models with {len(training)} training and {len(heldout)} held-out "
            "errors; give one of each for every step"
        )
    steps = np.arange(len(models))
    errors = {
        "fitted data": (output.per_small * np.asarray(training, dtype=np.float64), _TRAINING),
        "held-out data": (output.per_small * np.asarray(heldout, dtype=np.float64), _HELDOUT),
    }
    floor = output.per_small * noise
    figure = Figure(figsize=(max(6.0, min(12.0, STEP_WIDTH * (len(models) + 1))), 5.0))
    figure.set_layout_engine("constrained")
    axes = figure.subplots()
    for label, (values, style) in errors.items():
        axes.plot(steps, values, label=label, linewidth=2.0, **style)
    axes.axhline(floor, label=f"noise, {floor:.3g} {output.small}", **_NOISE)
    axes.axhspan(0.01 * floor, floor, color="0.92", zorder=0.0)
    judged = errors["held-out data"][0]
    _write_ratios(axes, np.where(np.isfinite(judged), judged, errors["fitted data"][0]), floor)
    axes.set_xticks(steps, [_wrapped(name) for name in models])
    axes.set_xlim(-0.5, len(models) - 0.5)
    axes.set_yscale("log")
    axes.set_ylim(*_limits(np.concatenate([values for values, _ in errors.values()]), floor))
    for place in (axes.yaxis.set_major_formatter, axes.yaxis.set_minor_formatter):
        place(LogFormatter(minor_thresholds=(2.0, 0.7)))
    axes.set_ylabel(f"rms error [{output.small}]")
    axes.grid(axis="y", which="both", alpha=0.25)
    axes.legend(loc="upper right")
    return figure


def _limits(errors: FloatArray, floor: float) -> tuple[float, float]:
    known = np.r_[errors[np.isfinite(errors)], floor]
    return 0.7 * known.min(), 1.8 * max(known.max(), 1.5 * floor)


def _wrapped(name: str) -> str:
    """Break a name where a long one would run into its neighbours."""
    return name.replace("_", "_\n", 1) if len(name) > LONG else name


def _write_ratios(axes: Axes, errors: FloatArray, floor: float) -> None:
    """Write each error as a multiple of the noise beside its mark."""
    for step, error in enumerate(errors):
        if np.isfinite(error):
            axes.annotate(
                f"{error / floor:.3g}×",
                (step, error),
                xytext=(8, 8),
                textcoords="offset points",
                fontsize=11,
                fontweight="bold",
                color=_HELDOUT["color"],
                path_effects=[withStroke(linewidth=3.0, foreground="white")],
            )
