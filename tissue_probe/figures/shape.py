"""The shape of a missing force as a picture: a curve with its band, or a surface.

Contents: how a learnt function looks, and that as text for a page.
"""

from __future__ import annotations

import io

import numpy as np
from matplotlib.figure import Figure

from tissue_probe.diagnosis.shape.learnt_curve import Curve
from tissue_probe.figures.shown_figure import ShownFigure
from tissue_probe.quantities import SIDE

#: Label of the axis of each variable, and by how much its SI unit is multiplied there.
VARIABLE_AXES = {
    "indentation": ("indentation [mm]", 1e3),
    "velocity": ("velocity [mm/s]", 1e3),
    "past": ("time since a step [s]", 1.0),
    "path": ("way since a reversal [mm]", 1e3),
    "force": ("force in the channel [N]", 1.0),
}
_BLUE = "#0072B2"


def draw_shape(curve: Curve) -> Figure:
    """Draw a learnt function over the range that the record visited."""
    figure = ShownFigure(figsize=(6.0, 4.0), layout="constrained")
    axes = figure.subplots()
    label, times = VARIABLE_AXES[curve.variables[0]]
    axes.set_xlabel(label)
    if len(curve.variables) == 1:
        large, unit = (1e3, "mN") if curve.unit == "N" else (1.0, curve.unit)
        grid, value, side = times * curve.grid[0], large * curve.value, SIDE * large * curve.sd
        axes.fill_between(grid, value - side, value + side, color=_BLUE, alpha=0.3, linewidth=0.0)
        axes.plot(grid, value, color=_BLUE)
        axes.set_ylabel(f"missing force [{unit}], 95 % band")
        if curve.variables == ("past",):
            axes.set_xscale("log")
            axes.set_ylabel(f"stiffness that is left [{unit}], 95 % band")
    else:
        other, by = VARIABLE_AXES[curve.variables[1]]
        axes.set_ylabel(other)
        shown = np.where(curve.visited, 1e3 * curve.value, np.nan).T
        drawn = axes.pcolormesh(times * curve.grid[0], by * curve.grid[1], shown, cmap="RdBu_r")
        figure.colorbar(drawn, label="missing force [mN]; white: never visited")
    return figure


def write_shape_picture(curve: Curve) -> str:
    """Return the drawn function as an SVG element, for a page of HTML."""
    file = io.StringIO()
    draw_shape(curve).savefig(file, format="svg")
    written = file.getvalue()
    return written[written.index("<svg") :]
