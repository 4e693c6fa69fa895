"""The report's interactive plots, as pieces of HTML that need Plotly's script once on the page.

What belongs here: what is drawn with Plotly. What does not: pictures for print (``figures``).
"""

from __future__ import annotations

import math

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from tissue_probe.diagnosis.residuals.localise import Localisation, Profile
from tissue_probe.quantities import Quantity
from tissue_probe.report.contents import Report, ReportSignals
from tissue_probe.signals import FloatArray

SPANS_MUCH = 10.0  # times the noise, from which on an axis is logarithmic
FEW = 8  # samples in a bin, from which on its error is shown

# Okabe and Ito's colours, told apart by every eye.
_GREY, _ORANGE, _BLUE, _REGION = "#9a9a9a", "#D55E00", "#0072B2", "#E69F00"
#: Plotly's button that uploads the chart would send a patient's data away: it is left out.
_CONFIG = {
    "displaylogo": False,
    "responsive": True,
    "showSendToCloud": False,
    "plotlyServerURL": "",
}
_LAYOUT = {
    "template": "plotly_white",
    "margin": {"l": 70, "r": 20, "t": 40, "b": 50},
    "legend": {"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0.0, "xanchor": "left"},
    "font": {"family": "system-ui, sans-serif", "size": 13},
}


def draw_ladder(report: Report) -> str:
    """Return the ladder: error of each step on fitted and on held-out data, and the noise."""
    names = [f"{number}. {step.model}" for number, step in enumerate(report.steps)]
    floor = report.output.per_small * report.noise_floor
    figure = go.Figure()
    for name, errors, style in (
        (
            "fitted data",
            [step.training_rmse for step in report.steps],
            {"line": {"color": _ORANGE, "dash": "dash"}, "marker": {"symbol": "square-open"}},
        ),
        (
            "held-out data",
            [step.heldout_rmse for step in report.steps],
            {"line": {"color": _BLUE}, "marker": {"symbol": "circle"}},
        ),
    ):
        values = report.output.per_small * np.array(errors)
        style["marker"] = {**style["marker"], "size": 12, "line": {"width": 2}}
        figure.add_scatter(
            x=names,
            y=values,
            customdata=values / floor,
            name=name,
            mode="lines+markers",
            hovertemplate=f"%{{y:.3g}} {report.output.small}, %{{customdata:.3g}} times the noise",
            **style,
        )
    figure.add_scatter(
        x=names,
        y=np.full(len(names), floor),
        name=f"noise, {floor:.3g} {report.output.small}",
        mode="lines",
        line={"color": "black", "dash": "dot"},
        hoverinfo="skip",
    )
    errors = [error for step in report.steps for error in (step.training_rmse, step.heldout_rmse)]
    known = report.output.per_small * np.array([*errors, report.noise_floor])
    known = known[np.isfinite(known) & (known > 0.0)]
    figure.update_yaxes(
        title=f"rms error [{report.output.small}]",
        **_logarithmic(0.7 * known.min(), 1.6 * known.max()),
    )
    figure.update_layout(height=380, **_LAYOUT)
    return as_html(figure)


def draw_signals(signals: ReportSignals, noise: float, output: Quantity) -> str:
    """Return measured and predicted signal, and below them the errors with the noise's band."""
    figure = make_subplots(2, 1, shared_xaxes=True, vertical_spacing=0.06, row_heights=[0.55, 0.45])
    # Six digits are more than any load cell has, and a third of the page's size.
    time, measured, base, final = (
        _rounded(each)
        for each in (
            signals.time,
            *(output.per_drawn * x for x in (signals.measured, signals.base, signals.final)),
        )
    )
    one = np.array_equal(signals.base, signals.final)
    models = [("model", final, _BLUE)]
    if not one:
        models = [("base model", base, _ORANGE), ("last model", final, _BLUE)]
    figure.add_scatter(
        x=time, y=measured, name="measured", line={"color": _GREY, "width": 4}, row=1, col=1
    )
    for name, predicted, colour in models:
        line = {"color": colour, "width": 1.5}
        figure.add_scatter(
            x=time, y=predicted, name=name, legendgroup=name, line=line, row=1, col=1
        )
        error = _rounded(output.per_small * (signals.measured - predicted))
        line = {"color": colour, "width": 1.0}
        figure.add_scatter(
            x=time, y=error, name=name, legendgroup=name, line=line, showlegend=False, row=2, col=1
        )
    twice = 2.0 * output.per_small * noise
    figure.add_hrect(-twice, twice, fillcolor="black", opacity=0.18, line_width=0, row=2, col=1)
    figure.update_yaxes(title=f"{output.name} [{output.drawn}]", row=1, col=1)
    figure.update_yaxes(title=f"error [{output.small}]", row=2, col=1)
    figure.update_xaxes(title="time [s]", row=2, col=1)
    figure.update_layout(height=560, hovermode="x unified", **_LAYOUT)
    return as_html(figure)


def draw_where(signals: ReportSignals, noise: float) -> str:
    """Return the rms error over the noise, by each quantity; the base model's regions shaded."""
    base, final = signals.base_localisation, signals.final_localisation
    shown = base or final
    titles = [_title(profile) for profile in shown.profiles]
    figure = make_subplots(
        2,
        3,
        subplot_titles=titles,
        shared_yaxes="all",
        vertical_spacing=0.16,
        horizontal_spacing=0.04,
    )
    for name, localisation, colour in (("base model", base, _ORANGE), ("last model", final, _BLUE)):
        for place, profile in enumerate(_of(localisation)):
            figure.add_trace(
                _stairs(profile, noise, name, colour, legend=place == 0),
                row=place // 3 + 1,
                col=place % 3 + 1,
            )
    for place, profile in enumerate(shown.profiles):
        row, column = place // 3 + 1, place % 3 + 1
        _mark(figure, profile, row, column)
        figure.add_hline(1.0, line={"dash": "dash", "color": "black"}, row=row, col=column)
        if profile.quantity == "frequency":
            figure.update_xaxes(type="log", dtick=1, row=row, col=column)
        if profile.quantity == "phase":
            figure.update_xaxes(tickvals=[-180, -90, 0, 90, 180], row=row, col=column)
        if profile.labels:
            middles = 0.5 * (profile.edges[:-1] + profile.edges[1:])
            figure.update_xaxes(tickvals=middles, ticktext=profile.labels, row=row, col=column)
    ratios = np.concatenate([_ratio(each, noise) for each in (*_of(base), *_of(final))])
    if np.nanmax(ratios, initial=1.0) > SPANS_MUCH:
        figure.update_yaxes(**_logarithmic(0.5, 1.5 * np.nanmax(ratios)))
    else:
        figure.update_yaxes(rangemode="tozero")
    figure.update_yaxes(title="rms error / noise", col=1)
    figure.update_layout(height=560, **{**_LAYOUT, "margin": {"l": 70, "r": 20, "t": 70, "b": 40}})
    figure.update_layout(legend={"y": 1.07})
    return as_html(figure)


def _title(profile: Profile) -> str:
    unit = f" [{profile.unit}]" if profile.unit else ""
    share = f", here {100.0 * min(profile.here.share, 1.0):.0f} %" if profile.here else ""
    return f"{profile.quantity}{unit}{share}"


def _ratio(profile: Profile, noise: float) -> FloatArray:
    return np.sqrt(np.where(profile.expected < FEW * noise**2, np.nan, profile.excess))


def _stairs(profile: Profile, noise: float, name: str, colour: str, legend: bool) -> go.Scatter:
    """Return a line that is level over each bin."""
    return go.Scatter(
        x=_rounded(np.repeat(profile.edges, 2)[1:-1]),
        y=_rounded(np.repeat(_ratio(profile, noise), 2)),
        name=name,
        legendgroup=name,
        showlegend=legend,
        mode="lines",
        line={"color": colour, "width": 2},
    )


def _mark(figure: go.Figure, profile: Profile, row: int, column: int) -> None:
    here = profile.here
    if here is None:
        return
    pieces = [(here.begin, here.end)]
    if here.begin > here.end:
        pieces = [(here.begin, profile.edges[-1]), (profile.edges[0], here.end)]
    for begin, end in pieces:
        figure.add_vrect(
            begin, end, fillcolor=_REGION, opacity=0.25, line_width=0, row=row, col=column
        )


def _of(localisation: Localisation | None) -> tuple[Profile, ...]:
    return localisation.profiles if localisation else ()


def _logarithmic(low: float, high: float) -> dict:
    """Return a logarithmic axis with its ticks written out: Plotly shortens 0.2, 2, 20 to 2."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    steps = (1, 2, 5) if len(decades) < 5 else (1,)
    ticks = [step * 10.0**decade for decade in decades for step in steps]
    text = [f"{tick:g}" for tick in ticks]
    span = [math.log10(low), math.log10(high)]
    return {"type": "log", "range": span, "tickvals": ticks, "ticktext": text}


def _rounded(values: FloatArray) -> FloatArray:
    """Return values in single precision, which a page stores in half the room."""
    return np.asarray(values, dtype=np.float32)


def as_html(figure: go.Figure) -> str:
    """Return a plot as a piece of a page that has Plotly's script."""
    return figure.to_html(
        full_html=False,
        include_plotlyjs=False,
        include_mathjax=False,
        config=_CONFIG,
    )
