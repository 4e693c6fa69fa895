"""How the figures look: lines of filters over time or frequency, one panel a quantity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from tissue_probe.reproduction.filters import ShownFilter
from tissue_probe.signals import FloatArray, TissueEstimates

LABELS = {
    "stiffness": "stiffness k [N/m]",
    "damping": "damping β [N s/m]",
    "covariance_trace": "covariance trace, mixed units",
}
TRUTH: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 1.6, "zorder": 5.0}

Runs = Mapping[ShownFilter, TissueEstimates]
Truth = tuple[FloatArray, FloatArray]


def panels(names: Sequence[str], x_label: str) -> tuple[Figure, dict[str, Axes]]:
    """Return a figure with one panel for each quantity, side by side."""
    layout = ConstrainedLayoutEngine(w_pad=0.1)
    figure = Figure(figsize=(4.4 * max(len(names), 1.5), 3.8), layout=layout)
    axes = dict(zip(names, figure.subplots(1, len(names), squeeze=False)[0], strict=True))
    for name, panel in axes.items():
        panel.set(xlabel=x_label, ylabel=LABELS.get(name, name))
        panel.grid(alpha=0.3)
    return figure, axes


def draw_line(axes: Axes, x: FloatArray, y: FloatArray, of: ShownFilter) -> None:
    """Draw a filter's estimates."""
    axes.plot(x, y, color=of.color, linestyle=of.dashes, label=of.label)


def draw_runs(time: FloatArray, runs: Runs, truth: Truth, names: Sequence[str]) -> Figure:
    """Draw estimates over time, with the truth dotted; the axes hold values near the truth."""
    figure, axes = panels(names, "time [s]")
    for name, panel in axes.items():
        for each, estimates in runs.items():
            draw_line(panel, time, getattr(estimates, name), each)
        if name == "covariance_trace":
            panel.set_yscale("log")
    for name, known in zip(("stiffness", "damping"), truth, strict=True):
        if name in axes:
            axes[name].plot(time, known, label="true", **TRUTH)
            axes[name].set_ylim(-0.25 * known.max(), 1.6 * known.max())
    legend(figure)
    return figure


def legend(figure: Figure) -> None:
    """Name the lines once, above the panels."""
    entries = {
        label: handle
        for axes in figure.axes
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    widest = 3 if figure.get_figwidth() < 8.0 else 6
    columns = -(-len(entries) // -(-len(entries) // widest))
    figure.legend(
        entries.values(), entries.keys(), loc="outside upper center", ncols=columns, fontsize=9
    )


def band(axes: Axes, time: FloatArray, values: FloatArray, of: ShownFilter) -> None:
    """Draw median and range of several runs, shape (runs, n)."""
    low, high = np.min(values, axis=0), np.max(values, axis=0)
    axes.fill_between(time, low, high, color=of.color, alpha=0.2, linewidth=0.0)
    draw_line(axes, time, np.median(values, axis=0), of)
