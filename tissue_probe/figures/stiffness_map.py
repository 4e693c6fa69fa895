"""The map as a picture: stiffness, P(inclusion), and the inclusions that could still hide.

Contents: how a map looks.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from tissue_probe.figures.shown_figure import ShownFigure
from tissue_probe.mapping.posterior.hidden_inclusions import LARGEST_HIDDEN
from tissue_probe.mapping.posterior.results import Inclusion, PosteriorMap, Raster
from tissue_probe.mapping.sites import Sites
from tissue_probe.signals import FloatArray

MILLIMETRES = 1e3
PANEL_WIDTH = 3.75  # inches, a third of the width of the figure's axes
ROOM_FOR_LEGENDS = 1.75  # inches above and below the panels
LEAST_RANGE = 0.1  # of the largest value: a uniform phantom shall not look like a mountain range
BESIDE_SITES = 3.0  # mm, of the unknown tissue around the map
#: Inclusions that are drawn: more likely there than not.
DRAWN_FROM = 0.5

# White on black is seen on every colour of the map.
_OUTLINED: dict[str, Any] = {
    "color": "white",
    "path_effects": [withStroke(linewidth=3.5, foreground="black")],
}
_UNKNOWN: dict[str, Any] = {
    "facecolor": "0.92",
    "edgecolor": "0.6",
    "hatch": "///",
    "linewidth": 0.0,
}
_BOUNDARY_STYLES = {"boundary_50": "-", "boundary_95": ":"}


def draw_map(
    found: PosteriorMap,
    sites: Sites,
    nodules: Sequence[tuple[float, float, float]] = (),
) -> Figure:
    """Draw stiffness, P(inclusion) and the size that could hide side by side.

    Parameters
    ----------
    found : PosteriorMap
        Places that no site is near are hatched.
    sites : Sites
        Dots where they tell a stiffness, crosses where they do not.
    nodules : sequence of (float, float, float)
        x, y and radius of each true nodule [m], where they are known.
    """
    surface, hide = found.surface, found.could_hide
    shown = [one for one in found.inclusions if one.probability >= DRAWN_FROM]
    height = PANEL_WIDTH * min(max(np.ptp(surface.y) / np.ptp(surface.x), 0.3), 2.0)
    figure = ShownFigure(figsize=(12.0, height + ROOM_FOR_LEGENDS), layout="constrained")
    contrast = f"{hide.contrast:g}"
    panels = (
        ("stiffness k [N/m]", surface, surface.mean, _range(surface.mean), "viridis"),
        ("P(inclusion)", surface, surface.probability, (0.0, 1.0), "magma"),
        (
            f"could hide, {contrast} times stiffer: radius [mm]",
            hide,
            np.where(np.isnan(hide.radius), LARGEST_HIDDEN, MILLIMETRES * hide.radius),
            (0.0, LARGEST_HIDDEN),
            "cividis",
        ),
    )
    for axes, (label, raster, layer, limits, colours) in zip(
        figure.subplots(1, 3, sharex=True, sharey=True), panels, strict=True
    ):
        axes.patch.set(facecolor="0.92", edgecolor="0.6", hatch="///")
        image = _draw_layer(axes, raster, layer, limits, colours)
        bar = figure.colorbar(image, ax=axes, orientation="horizontal", label=label, aspect=30)
        bar.locator = MaxNLocator(5)  # more long numbers do not fit side by side
        bar.update_ticks()
        _draw_sites(axes, sites)
        _draw_nodules(axes, nodules)
        _draw_inclusions(axes, shown)
        axes.set(
            aspect="equal",
            xlabel="x [mm]",
            xlim=_choose_range(surface.x),
            ylim=_choose_range(surface.y),
        )
    _write_contrasts(figure.axes[0], shown)
    figure.axes[0].set_ylabel("y [mm]")
    handles = _legend(found, sites, shown, nodules)
    figure.legend(handles=handles, loc="outside upper center", ncols=4)
    return figure


def _choose_range(axis: FloatArray) -> tuple[float, float]:
    """Return the shown range of an axis [mm]: the raster, and a little of the unknown around it."""
    return MILLIMETRES * axis[0] - BESIDE_SITES, MILLIMETRES * axis[-1] + BESIDE_SITES


def _range(layer: FloatArray) -> tuple[float, float]:
    low, high = float(np.nanmin(layer)), float(np.nanmax(layer))
    widening = max(0.0, LEAST_RANGE * max(abs(low), abs(high)) - (high - low)) / 2.0
    return low - widening, high + widening


def _draw_layer(
    axes: Axes, raster: Raster, layer: FloatArray, limits: tuple[float, float], colours: str
) -> AxesImage:
    half_x, half_y = ((axis[1] - axis[0]) / 2.0 for axis in (raster.x, raster.y))
    edges = (
        raster.x[0] - half_x,
        raster.x[-1] + half_x,
        raster.y[0] - half_y,
        raster.y[-1] + half_y,
    )
    return axes.imshow(
        layer,
        origin="lower",
        extent=tuple(MILLIMETRES * edge for edge in edges),
        vmin=limits[0],
        vmax=limits[1],
        cmap=colours,
    )


def _draw_sites(axes: Axes, sites: Sites) -> None:
    x, y, felt = MILLIMETRES * sites.x, MILLIMETRES * sites.y, sites.felt
    axes.plot(x[felt], y[felt], ".", color="white", markeredgecolor="black", markersize=5)
    axes.plot(x[~felt], y[~felt], "x", color="tab:red", markersize=6)


def _draw_nodules(axes: Axes, nodules: Sequence[tuple[float, float, float]]) -> None:
    for x, y, radius in MILLIMETRES * np.reshape(nodules, (-1, 3)):
        axes.add_patch(
            Circle((x, y), radius, fill=False, linewidth=1.0, linestyle="--", **_OUTLINED)
        )


def _draw_inclusions(axes: Axes, shown: Sequence[Inclusion]) -> None:
    for one in shown:
        for name, style in _BOUNDARY_STYLES.items():
            axes.plot(*(MILLIMETRES * getattr(one, name).T), style, linewidth=1.5, **_OUTLINED)


def _write_contrasts(axes: Axes, shown: Sequence[Inclusion]) -> None:
    """Write how many times stiffer each inclusion is, and how probable, in its middle."""
    for one in shown:
        axes.annotate(
            f"{one.contrast:.1f}×\nP {one.probability:.2f}",
            (MILLIMETRES * one.x, MILLIMETRES * one.y),
            fontsize=8,
            fontweight="bold",
            ha="center",
            va="center",
            **_OUTLINED,
        )


def _legend(
    found: PosteriorMap,
    sites: Sites,
    shown: Sequence[Inclusion],
    nodules: Sequence[tuple[float, float, float]],
) -> list[Line2D | Patch]:
    """Return one handle for each kind of mark that is drawn."""
    dot: dict[str, Any] = {"linestyle": "none", "color": "white", "markeredgecolor": "black"}
    entries: list[tuple[bool | np.bool_, Line2D | Patch]] = [
        (sites.felt.any(), Line2D([], [], marker=".", markersize=8, label="site measured", **dot)),
        (
            (~sites.felt).any(),
            Line2D([], [], marker="x", linestyle="none", color="tab:red", label="site unknown"),
        ),
        (np.isnan(found.surface.mean).any(), Patch(label="no site near", **_UNKNOWN)),
        (
            bool(shown),
            Line2D([], [], color="black", linestyle="-", label="inclusion, likely boundary"),
        ),
        (
            bool(shown),
            Line2D([], [], color="black", linestyle=":", label="holds all of it, 95 %"),
        ),
        (
            len(nodules) > 0,
            Line2D([], [], color="black", linestyle="--", label="true nodule"),
        ),
    ]
    return [handle for drawn, handle in entries if drawn]
