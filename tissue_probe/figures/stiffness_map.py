"""The stiffness map as a picture: stiffness, damping and covariance trace over the tissue.

What belongs here: how a map looks, after figure 12 of the paper. What does not: what is in it
(``mapping``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from tissue_probe.figures.shown_figure import ShownFigure
from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.regions import Region
from tissue_probe.mapping.stiffness_map import StiffnessMapData
from tissue_probe.mapping.surface import interpolate
from tissue_probe.mapping.verdict import Verdict
from tissue_probe.signals import FloatArray

MILLIMETRES = 1e3
PANEL_WIDTH = 3.75  # inches, a third of what the figure's axes take
ROOM_FOR_LEGENDS = 1.75  # inches above and below the panels
LEAST_RANGE = 0.1  # of the largest value: a uniform phantom shall not look like a mountain range

# White on black is seen on every colour of the map.
_OUTLINED = {"color": "white", "path_effects": [withStroke(linewidth=3.5, foreground="black")]}
_UNVISITED = {"facecolor": "0.92", "edgecolor": "0.6", "hatch": "///", "linewidth": 0.0}
_WITHOUT_VALUE = {"facecolor": "0.92", "edgecolor": "0.6", "linewidth": 0.5}
#: The letter in a palpated cell that is not simply measured, and its meaning.
_MARKS = {
    Verdict.NO_ESTIMATE: ("N", "no estimate"),
    Verdict.NOT_CONVERGED: ("U", "unsure: not converged"),
    Verdict.NO_CONTACT: ("A", "in air: no contact"),
    Verdict.MODEL_REJECTED: ("R", "rejected: the model is wrong"),
    Verdict.DISTURBED: ("D", "measured, disturbed by another force"),
}


def draw_map(
    stiffness_map: StiffnessMapData,
    found: Sequence[Region] = (),
    nodules: Sequence[tuple[float, float, float]] = (),
) -> Figure:
    """Draw stiffness, damping and covariance trace as interpolated heat maps side by side.

    Parameters
    ----------
    stiffness_map : StiffnessMapData
        Cells that were not palpated are hatched; a letter tells why a palpated cell has no value,
        or that it was disturbed.
    found : sequence of Region
        Stiff regions, marked by a cross, with their stiffness over the background's.
    nodules : sequence of (float, float, float)
        x, y and depth of each true nodule [m], where they are known; each is a circle of its
        depth's radius.
    """
    zero = np.where(stiffness_map.measured, 0.0, np.nan)
    rows, columns = stiffness_map.grid.shape
    height = PANEL_WIDTH * min(max(rows / columns, 0.3), 2.0) + ROOM_FOR_LEGENDS
    figure = ShownFigure(figsize=(12.0, height), layout="constrained")
    panels = zip(
        figure.subplots(1, 3, sharey=True),
        ("stiffness k [N/m]", "damping β [N s/m]", "covariance trace, mixed units"),
        (stiffness_map.stiffness, stiffness_map.damping, stiffness_map.covariance_trace),
        (stiffness_map.stiffness_stddev, stiffness_map.damping_stddev, zero),
        strict=True,
    )
    for axes, label, values, stddev in panels:
        if stiffness_map.measured.any():
            image = _draw_surface(axes, stiffness_map.grid, values, stddev)
            bar = figure.colorbar(image, ax=axes, orientation="horizontal", label=label, aspect=30)
            bar.locator = MaxNLocator(5)  # more long numbers do not fit side by side
            bar.update_ticks()
        else:
            axes.set_title(f"{label}: nothing measured", fontsize=10)
        _draw_sites(axes, stiffness_map)
        _draw_nodules(axes, nodules)
        _draw_found(axes, found)
    _write_depths(figure.axes[0], nodules)
    _write_ratios(figure.axes[0], found)
    figure.axes[0].set_ylabel("y [mm]")
    figure.legend(
        handles=_legend(stiffness_map, found, nodules), loc="outside upper center", ncols=4
    )
    return figure


def _draw_surface(axes: Axes, grid: Grid, values: FloatArray, stddev: FloatArray) -> AxesImage:
    surface = interpolate(grid, values, stddev)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    widening = max(0.0, LEAST_RANGE * max(abs(low), abs(high)) - (high - low)) / 2.0
    return axes.imshow(
        surface.mean,
        origin="lower",
        extent=_extent(grid),
        vmin=low - widening,
        vmax=high + widening,
        cmap="viridis",
        interpolation="bilinear",
    )


def _extent(grid: Grid) -> tuple[float, float, float, float]:
    """Left, right, bottom and top of the map [mm], half a spacing beyond the outermost cells."""
    half = grid.spacing / 2.0
    edges = (grid.x[0] - half, grid.x[-1] + half, grid.y[0] - half, grid.y[-1] + half)
    return tuple(MILLIMETRES * edge for edge in edges)


def _draw_sites(axes: Axes, stiffness_map: StiffnessMapData) -> None:
    grid = stiffness_map.grid
    x, y = np.meshgrid(MILLIMETRES * grid.x, MILLIMETRES * grid.y)
    measured, size = stiffness_map.measured, MILLIMETRES * grid.spacing
    for row, column in np.argwhere(~measured):
        corner = (x[row, column] - size / 2, y[row, column] - size / 2)
        palpated = stiffness_map.verdict[row, column] != Verdict.NOT_PALPATED
        style = _WITHOUT_VALUE if palpated else _UNVISITED
        axes.add_patch(Rectangle(corner, size, size, **style))
    axes.plot(x[measured], y[measured], ".", color="white", markeredgecolor="black", markersize=6)
    for verdict, (mark, _) in _MARKS.items():
        for row, column in np.argwhere(stiffness_map.verdict == verdict):
            beside = (7.0, 7.0) if measured[row, column] else (0.0, 0.0)
            _write(axes, mark, (x[row, column], y[row, column]), beside, "center")
    left, right, bottom, top = _extent(grid)
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xlabel="x [mm]")


def _draw_nodules(axes: Axes, nodules: Sequence[tuple[float, float, float]]) -> None:
    for x, y, depth in MILLIMETRES * np.reshape(nodules, (-1, 3)):
        axes.add_patch(Circle((x, y), depth, fill=False, linewidth=1.5, **_OUTLINED))


def _draw_found(axes: Axes, found: Sequence[Region]) -> None:
    for region in found:
        centre = (MILLIMETRES * region.x, MILLIMETRES * region.y)
        axes.plot(*centre, "x", markersize=9, markeredgewidth=1.5, **_OUTLINED)


def _write_depths(axes: Axes, nodules: Sequence[tuple[float, float, float]]) -> None:
    """Write each nodule's depth beside its circle, towards the middle of the map."""
    middle = sum(axes.get_xlim()) / 2.0
    for x, y, depth in MILLIMETRES * np.reshape(nodules, (-1, 3)):
        side, alignment = (-1.0, "right") if x > middle else (1.0, "left")
        edge, gap = (x + side * depth, y), (5.0 * side, 0.0)
        _write(axes, f"{depth:g} mm", edge, gap, alignment)


def _write_ratios(axes: Axes, found: Sequence[Region]) -> None:
    """Write each found nodule's stiffness over the background's above its cross."""
    for region in found:
        centre = (MILLIMETRES * region.x, MILLIMETRES * region.y)
        _write(axes, f"{region.ratio:.1f}×", centre, (0.0, 34.0), "center")


def _write(
    axes: Axes, text: str, place: tuple[float, float], gap: tuple[float, float], alignment: str
) -> None:
    """Write text at a distance [points] from a place [mm]."""
    axes.annotate(
        text,
        place,
        xytext=gap,
        textcoords="offset points",
        fontsize=9,
        fontweight="bold",
        ha=alignment,
        va="center",
        **_OUTLINED,
    )


def _legend(
    stiffness_map: StiffnessMapData,
    found: Sequence[Region],
    nodules: Sequence[tuple[float, float, float]],
) -> list[Line2D | Patch]:
    """Return one handle for each kind of mark that is drawn."""
    marker = {"linestyle": "none", "color": "white", "markeredgecolor": "black"}
    letter = {"linestyle": "none", "color": "black"}
    entries = [
        (
            stiffness_map.measured.any(),
            Line2D([], [], marker=".", markersize=8, label="site measured", **marker),
        ),
        (
            (stiffness_map.verdict == Verdict.NOT_PALPATED).any(),
            Patch(label="not palpated", **_UNVISITED),
        ),
        *(
            (
                (stiffness_map.verdict == verdict).any(),
                Line2D([], [], marker=f"${mark}$", markersize=8, label=meaning, **letter),
            )
            for verdict, (mark, meaning) in _MARKS.items()
        ),
        (
            len(nodules) > 0,
            Line2D(
                [], [], marker="o", markersize=10, label="true nodule, radius = depth", **marker
            ),
        ),
        (
            len(found) > 0,
            Line2D(
                [],
                [],
                marker="X",
                markersize=9,
                label="nodule found, stiffness over background",
                **marker,
            ),
        ),
    ]
    return [handle for drawn, handle in entries if drawn]
