"""The ladder of an improvement as a picture: the error of each model, falling to the noise.

Contents: how the ladder looks.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogFormatter

from tissue_probe.figures.shown_figure import ShownFigure
from tissue_probe.quantities import FORCE, Quantity
from tissue_probe.signals import FloatArray

RUNG_WIDTH = 2.0  # inches
CHARACTER = 0.09  # inches that one takes below the axis, at most
RATIO_WIDTH = 0.7  # inches that an error's multiple takes beside its mark
NARROW = 10  # characters: names that have less room than this are turned
HEAD = 24.0  # points above the axes that the legend takes
MARKS_APART = 0.9  # quotient of two errors from which on their marks lie on one another

# Okabe and Ito's colours, told apart by every eye; marks and dashes tell them apart in grey.
_TRAINING: dict[str, Any] = {
    "color": "#E69F00",
    "marker": "s",
    "linestyle": "--",
    "markersize": 13,
    "markerfacecolor": "none",
    "markeredgewidth": 1.8,
}
_HELDOUT: dict[str, Any] = {"color": "#0072B2", "marker": "o", "linestyle": "-", "markersize": 9}
_NOISE: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 1.6}


@dataclass(frozen=True)
class Rungs:
    """The models of a ladder, and how far each is from the measurement.

    Parameters
    ----------
    models : sequence of str
        Name of each step, in order: the base model, then the effects added or dropped.
    training, heldout : sequence of float
        Root mean square of measured minus predicted output; NaN where there is none.
    noise : float
        Standard deviation of the output's white noise, which no model can explain.
    output : Quantity
        The predicted channel.

    Raises
    ------
    ValueError
        If the sequences are empty or differ in length.
    """

    models: Sequence[str]
    training: Sequence[float]
    heldout: Sequence[float]
    noise: float
    output: Quantity = FORCE

    def __post_init__(self) -> None:
        if not self.models or not len(self.models) == len(self.training) == len(self.heldout):
            raise ValueError(
                f"{len(self.models)} models with {len(self.training)} training and "
                f"{len(self.heldout)} held-out errors; give one of each for every step"
            )


def draw_ladder(rungs: Rungs) -> Figure:
    """Draw the rms error of each model on the data it was fitted to, and on data held out.

    Parameters
    ----------
    rungs : Rungs
        The ladder.
    """
    width = max(6.0, min(12.0, RUNG_WIDTH * (len(rungs.models) + 1)))
    figure = ShownFigure(figsize=(width, 5.0), layout="constrained")
    draw_rungs(figure.subplots(), rungs, width)
    return figure


def draw_rungs(axes: Axes, rungs: Rungs, width: float) -> None:
    """Draw a ladder into axes.

    Parameters
    ----------
    axes : Axes
        Empty ones.
    rungs : Rungs
        The ladder.
    width : float
        How wide the axes will be [inches], roughly: names are broken, or turned, to fit.
    """
    output, steps = rungs.output, np.arange(len(rungs.models))
    training, heldout = (
        output.per_small * np.asarray(errors, dtype=np.float64)
        for errors in (rungs.training, rungs.heldout)
    )
    floor = output.per_small * rungs.noise
    axes.plot(steps, training, label="fitted data", linewidth=2.0, **_TRAINING)
    axes.plot(steps, heldout, label="held-out data", linewidth=2.0, **_HELDOUT)
    axes.axhline(floor, label=f"noise, {floor:.3g} {output.small}", **_NOISE)
    axes.axhspan(0.01 * floor, floor, color="0.92", zorder=0.0)
    _write_ratios(axes, training, heldout, floor)
    _name_steps(axes, rungs.models, width)
    axes.set_yscale("log")
    axes.set_ylim(*_limits(np.concatenate([training, heldout]), floor))
    for place in (axes.yaxis.set_major_formatter, axes.yaxis.set_minor_formatter):
        place(LogFormatter(minor_thresholds=(2.0, 0.7)))
    axes.set_ylabel(f"rms error [{output.small}]")
    axes.grid(axis="y", which="both", alpha=0.25)
    _add_legend(axes)


def _add_legend(axes: Axes) -> None:
    """Add a legend above the axes, where it hides neither marks nor numbers."""
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=3,
        fontsize=9,
        frameon=False,
        markerscale=0.6,
        handlelength=1.8,
        handletextpad=0.4,
        columnspacing=1.0,
        borderaxespad=0.2,
    )


def multiple(ratio: float) -> str:
    """Tell how many times the noise an error is."""
    return f"{ratio:.0f}×" if 1e3 <= ratio < 1e6 else f"{ratio:.3g}×"


def wrap_name(name: str, room: int) -> str:
    """Break a name behind spaces and underscores into lines of at most ``room`` characters.

    A part that is longer by itself stays whole.
    """
    lines = [""]
    for part in re.findall(r"[^ _]*[ _]?", name):
        if lines[-1] and len((lines[-1] + part).rstrip()) > room:
            lines.append("")
        lines[-1] += part
    return "\n".join(line.rstrip() for line in lines)


def _name_steps(axes: Axes, models: Sequence[str], width: float) -> None:
    """Name the steps, and leave room at both ends for the text beside the marks."""
    gaps = len(models) - 1
    step = min(width / len(models), (width - 2.0 * RATIO_WIDTH) / max(gaps, 1))
    margin = 0.5 * (width / step - gaps)
    axes.set_xlim(-margin, gaps + margin)
    room = int(step / CHARACTER)
    if room < NARROW:
        labels = [name.replace(", ", ",\n") for name in models]
        axes.set_xticks(range(len(models)), labels, rotation=35.0, ha="right", fontsize=9)
    else:
        axes.set_xticks(range(len(models)), [wrap_name(name, room) for name in models])


def _limits(errors: FloatArray, floor: float) -> tuple[float, float]:
    """Leave room above for a multiple, as a share of the errors' span."""
    known = np.r_[errors[np.isfinite(errors)], floor]
    least, most = known.min(), max(known.max(), 1.5 * floor)
    return 0.7 * least, most * max(1.8, (most / least) ** 0.2)


def _write_ratios(axes: Axes, training: FloatArray, heldout: FloatArray, floor: float) -> None:
    """Write each error as a multiple of the noise beside its mark, off the other mark."""
    judged = np.where(np.isfinite(heldout), heldout, training)
    for step, error in enumerate(judged):
        if not np.isfinite(error):
            continue
        below = error < MARKS_APART * training[step]
        axes.annotate(
            multiple(error / floor),
            (step, error),
            xytext=(-8, -8) if below else (8, 8),
            ha="right" if below else "left",
            va="top" if below else "bottom",
            textcoords="offset points",
            fontsize=11,
            fontweight="bold",
            color=(_HELDOUT if error == heldout[step] else _TRAINING)["color"],
            path_effects=[withStroke(linewidth=3.0, foreground="white")],
        )
