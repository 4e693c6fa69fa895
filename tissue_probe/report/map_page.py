"""The map of a scan as one HTML page that needs nothing else, as the report of an improvement does.

Contents: its plots, and filling its template.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup
from plotly.offline import get_plotlyjs
from plotly.subplots import make_subplots

from tissue_probe.mapping.posterior.hidden_inclusions import LARGEST_HIDDEN
from tissue_probe.mapping.posterior.results import PosteriorMap, Raster
from tissue_probe.mapping.sites import Sites
from tissue_probe.report.numbers import significant
from tissue_probe.report.page import templates
from tissue_probe.signals import FloatArray

MILLIMETRES = 1e3
#: Inclusions whose boundaries are drawn: more likely there than not.
DRAWN_PROBABILITY = 0.5
#: Lines of a boundary: white on black is seen on every colour.
_LINE_STROKES = (("black", 4.0), ("white", 1.6))
#: Plotly's button that uploads the chart would send a patient's data away: it is left out.
_CONFIG = {
    "displaylogo": False,
    "responsive": True,
    "showSendToCloud": False,
    "plotlyServerURL": "",
}
_DASHES = {"boundary_50": "solid", "boundary_95": "dot"}


@dataclass(frozen=True)
class MapPage:
    """The contents of the page.

    Parameters
    ----------
    title : str
        Heading of the page.
    found : PosteriorMap
        The map.
    sites : Sites
        The sites that it was made of.
    told : sequence of str
        The use of the sites, the background, and further notes; a paragraph each.
    sources : sequence of str
        How the samples were read, in sentences.
    created : str
        Date and time; with the version of the program.
    """

    title: str
    found: PosteriorMap
    sites: Sites
    told: Sequence[str]
    sources: Sequence[str]
    created: str


def render_map(page: MapPage) -> str:
    """Return the page as HTML."""
    environment = templates()
    environment.filters["significant"] = significant
    return environment.get_template("map.html.jinja").render(
        page=page, plot=Markup(_plot(page)), plotly=Markup(get_plotlyjs())
    )


def _plot(page: MapPage) -> str:
    """Return stiffness, P(inclusion) and sizes that could hide, with sites and boundaries."""
    surface, hide = page.found.surface, page.found.could_hide
    radius = np.where(np.isnan(hide.radius), LARGEST_HIDDEN, MILLIMETRES * hide.radius)
    layers = (
        ("stiffness k [N/m]", surface, surface.mean, "Viridis", None),
        ("P(inclusion)", surface, surface.probability, "Magma", (0.0, 1.0)),
        (f"could hide, {hide.contrast:g} times stiffer: radius [mm]", hide, radius, "Cividis",
         (0.0, LARGEST_HIDDEN)),
    )  # fmt: skip
    figure = make_subplots(
        1, len(layers), subplot_titles=[name for name, *_ in layers], horizontal_spacing=0.09
    )
    for column, (name, raster, layer, colours, limits) in enumerate(layers, start=1):
        heat = _heat(name, raster, layer, colours, limits)
        place = figure.get_subplot(1, column).xaxis.domain
        heat.colorbar = {"x": place[1] + 0.005, "thickness": 10, "len": 0.8}
        figure.add_trace(heat, row=1, col=column)
        for trace in (*_boundaries(page.found), _dots(page.sites)):
            figure.add_trace(trace, row=1, col=column)
        axis = figure.get_subplot(1, column).xaxis.plotly_name.removeprefix("xaxis")
        figure.update_yaxes(scaleanchor=f"x{axis}", constrain="domain", row=1, col=column)
        figure.update_xaxes(title="x [mm]", constrain="domain", row=1, col=column)
    figure.update_yaxes(title="y [mm]", col=1)
    figure.update_layout(
        template="plotly_white", height=430, showlegend=False,
        margin={"l": 60, "r": 40, "t": 50, "b": 50},
        font={"family": "system-ui, sans-serif", "size": 13},
    )  # fmt: skip
    text: str = figure.to_html(
        full_html=False, include_plotlyjs=False, include_mathjax=False, config=_CONFIG
    )
    return text


def _heat(
    name: str,
    raster: Raster,
    layer: FloatArray,
    colours: str,
    limits: tuple[float, float] | None,
) -> go.Heatmap:
    low, high = limits or (None, None)
    return go.Heatmap(
        x=_mm(raster.x),
        y=_mm(raster.y),
        z=np.asarray(layer, dtype=np.float32),
        zmin=low,
        zmax=high,
        colorscale=colours,
        hovertemplate=f"x %{{x:.1f}} mm, y %{{y:.1f}} mm<br>{name}: %{{z:.4g}}<extra></extra>",
    )


def _boundaries(found: PosteriorMap) -> list[go.Scatter]:
    shown = [one for one in found.inclusions if one.probability >= DRAWN_PROBABILITY]
    return [
        go.Scatter(
            x=_mm(getattr(one, name)[:, 0]),
            y=_mm(getattr(one, name)[:, 1]),
            mode="lines",
            line={"color": colour, "width": width, "dash": dash},
            hoverinfo="skip",
        )
        for one, (name, dash), (colour, width) in product(shown, _DASHES.items(), _LINE_STROKES)
    ]


def _dots(sites: Sites) -> go.Scatter:
    told = [f"{k:.4g} ± {sd:.2g} N/m" for k, sd in zip(sites.k, sites.k_sd, strict=True)]
    return go.Scatter(
        x=_mm(sites.x),
        y=_mm(sites.y),
        mode="markers",
        text=[text if felt else "unknown" for text, felt in zip(told, sites.felt, strict=True)],
        marker={
            "size": 7,
            "color": "white",
            "symbol": ["circle" if felt else "x" for felt in sites.felt],
            "line": {"color": "black", "width": 1},
        },
        hovertemplate="site at x %{x:.2f} mm, y %{y:.2f} mm<br>%{text}<extra></extra>",
    )


def _mm(values: FloatArray) -> FloatArray:
    return np.asarray(MILLIMETRES * values, dtype=np.float32)
