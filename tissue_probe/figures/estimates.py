"""Estimates over time as a picture: the first second at one site, and the whole scan.

Contents: how estimates look beside the measured force, after figures 7 and 8 of the paper.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import cycle
from typing import Any, overload

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter
from numpy.typing import NDArray

from tissue_probe.figures.shown_figure import ShownFigure
from tissue_probe.signals import (
    NANOSECONDS,
    FloatArray,
    IntArray,
    Recording,
    Status,
    TissueEstimates,
)

DETAIL_DURATION = 1.0  # s shown of one site
INNOVATION_INTERVAL = 0.1  # s over which its root mean square is taken
MILLINEWTONS = 1e3
STARTUP_WIDTH = 0.4  # width of a line before the filter has converged, over its width after
LABELLED_SITES = 25  # more numbers do not fit side by side

# Okabe and Ito's colours, told apart by every eye; the dashes part filters that agree.
_FILTER_STYLES: tuple[dict[str, Any], ...] = (
    {"color": "#0072B2", "linestyle": "-", "linewidth": 2.2},
    {"color": "#E69F00", "linestyle": (0, (5, 2)), "linewidth": 1.6},
    {"color": "#009E73", "linestyle": (0, (2, 1.5)), "linewidth": 1.6},
    {"color": "#CC79A7", "linestyle": "-.", "linewidth": 1.4},
    {"color": "#56B4E9", "linestyle": (0, (1, 1)), "linewidth": 1.4},
)
_MEASURED_LINE: dict[str, Any] = {"color": "0.65", "linewidth": 4.0, "label": "measured"}
_TRUTH: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 1.6}


@dataclass(frozen=True)
class _Span:
    """A stretch of time, from ``begin`` up to, not including, ``end`` [ns since the epoch]."""

    begin: int
    end: int

    def holds(self, stamps: IntArray) -> NDArray[np.bool_]:
        return (stamps >= self.begin) & (stamps < self.end)

    @overload
    def seconds(self, stamps: int) -> float: ...
    @overload
    def seconds(self, stamps: IntArray) -> FloatArray: ...
    def seconds(self, stamps: IntArray | int) -> FloatArray | float:
        """Tell times in seconds after the beginning."""
        return (stamps - self.begin) / NANOSECONDS


@dataclass(frozen=True)
class _Dwell:
    """A stay at one site, with its true stiffness and damping (NaN where not known).

    The site is None in a recording that does not tell its sites.
    """

    site: int | None
    span: _Span
    truth: dict[str, float]


def draw_estimates(
    recording: Recording,
    estimates: Sequence[TissueEstimates],
    truth: FloatArray | None = None,
    dwell: int = 0,
) -> Figure:
    """Draw all estimators over one site's first second (left) and over the whole scan (right).

    Estimates are thin lines until they have converged, and left out between dwells and without
    contact; bands are two standard deviations to either side. The axes hold converged estimates; a
    start-up transient may run out of them. A recording that announces no dwell is drawn as one
    dwell from its first sample to its last.

    Parameters
    ----------
    recording : Recording
        The measured channels.
    estimates : sequence of TissueEstimates
        One for each estimator, made from this recording.
    truth : array, shape (number of dwells, 2), optional
        True stiffness [N/m] and damping [N s/m] at each dwell, where they are known.
    dwell : int
        Which of the recording's dwells is shown on the left, from 0.

    Raises
    ------
    ValueError
        If the recording is empty, or the truth has not one row for each dwell.
    IndexError
        If the recording has no such dwell.
    """
    dwells = _dwells(recording, truth)
    shown = dwells[dwell]
    detail_end = min(shown.span.end, shown.span.begin + round(DETAIL_DURATION * NANOSECONDS))
    detail = _Span(shown.span.begin, detail_end)
    scan = _Span(recording.blocks[0].stamp, recording.blocks[-1].end)
    estimates = [_lifted_between(dwells, each) for each in estimates]

    figure = ShownFigure(figsize=(12.0, 10.0), layout="constrained")
    panels = figure.subplots(4, 2, sharex="col", width_ratios=(2, 3))
    for column, span, visible in ((panels[:, 0], detail, [shown]), (panels[:, 1], scan, dwells)):
        selected = [each[span.holds(each.stamp)] for each in estimates]
        _draw_parameter(column[0], "stiffness", span, selected, visible)
        _draw_parameter(column[1], "damping", span, selected, visible)
        _draw_trace(column[2], span, selected)
        column[3].set_xlim(0.0, span.seconds(span.end))
    _draw_force(panels[3, 0], detail, estimates, recording)
    _draw_innovation(panels[3, 1], scan, estimates)
    _label(figure, panels)
    if shown.site is not None:
        _mark_dwells(panels[:, 1], scan, dwells)
        panels[0, 0].set_title(
            f"First {detail.seconds(detail.end):.2g} s at site {shown.site}; thin until converged"
        )
        panels[0, 1].set_title("Whole scan, contact shaded, by number of the site")
    return figure


def _dwells(recording: Recording, truth: FloatArray | None) -> list[_Dwell]:
    if not recording.blocks:
        raise ValueError("the recording holds no samples; there is nothing to draw")
    announced = recording.dwells() if recording.sites else ()
    stays: list[tuple[int | None, _Span]] = [
        (site.site, _Span(site.stamp, end)) for site, end in announced
    ]
    stays = stays or [(None, _Span(recording.blocks[0].stamp, recording.blocks[-1].end))]
    known = np.full((len(stays), 2), np.nan) if truth is None else np.asarray(truth)
    if known.shape != (len(stays), 2):
        raise ValueError(
            f"truth has shape {known.shape}; give stiffness and damping for each of the "
            f"{len(stays)} dwells"
        )
    return [
        _Dwell(site, span, {"stiffness": stiffness, "damping": damping})
        for (site, span), (stiffness, damping) in zip(stays, known, strict=True)
    ]


def _lifted_between(dwells: Sequence[_Dwell], estimates: TissueEstimates) -> TissueEstimates:
    """Deny contact between dwells, where a filter that forgets slowly may still believe in it."""
    dwelling = np.zeros(len(estimates), dtype=bool)
    for dwell in dwells:
        dwelling |= dwell.span.holds(estimates.stamp)
    return replace(estimates, status=np.where(dwelling, estimates.status, Status.NO_CONTACT))


def _in_contact(estimates: TissueEstimates, values: FloatArray) -> FloatArray:
    """Blank estimates without contact, so that their line is broken there."""
    return np.where(estimates.status == Status.NO_CONTACT, np.nan, values)


def _draw_parameter(
    axes: Axes,
    name: str,
    span: _Span,
    estimates: Sequence[TissueEstimates],
    dwells: Sequence[_Dwell],
) -> None:
    """Draw stiffness or damping with two standard deviations to either side, and the truth."""
    for each, style in zip(estimates, cycle(_FILTER_STYLES), strict=False):
        time = span.seconds(each.stamp)
        value = _in_contact(each, getattr(each, name))
        margin = 2.0 * np.sqrt(getattr(each, f"{name}_variance"))
        axes.fill_between(
            time, value - margin, value + margin, color=style["color"], alpha=0.2, linewidth=0.0
        )
        settled = np.where(each.status == Status.CONVERGING, np.nan, value)
        axes.plot(time, value, **{**style, "linewidth": STARTUP_WIDTH * style["linewidth"]})
        axes.plot(time, settled, label=each.estimator, **style)
    for dwell in dwells:
        if np.isnan(dwell.truth[name]):
            continue
        ends = [span.seconds(dwell.span.begin), span.seconds(dwell.span.end)]
        axes.plot(ends, [dwell.truth[name]] * 2, label="true", **_TRUTH)
    settled_at = (Status.CONVERGED, Status.DISTURBED)
    converged = [getattr(each, name)[np.isin(each.status, settled_at)] for each in estimates]
    known = np.concatenate([*converged, [dwell.truth[name] for dwell in dwells]])
    if np.isfinite(known).any():
        axes.set_ylim(*_limits(known, stray=0.1))
    else:
        started = [_in_contact(each, getattr(each, name)) for each in estimates]
        axes.set_ylim(*_limits(np.concatenate([*started, known]), stray=5.0))


def _limits(values: FloatArray, stray: float) -> tuple[float, float]:
    """Return axis limits that hold zero and all values but ``stray`` per cent at either end."""
    values = values[np.isfinite(values)]
    if values.size == 0:
        return 0.0, 1.0
    low, high = np.percentile(values, (stray, 100.0 - stray))
    low, high = min(0.0, low), max(0.0, high)
    margin = 0.15 * (high - low) or 1.0
    return low - margin, high + 1.5 * margin


def _draw_trace(axes: Axes, span: _Span, estimates: Sequence[TissueEstimates]) -> None:
    for each, style in zip(estimates, cycle(_FILTER_STYLES), strict=False):
        trace = _in_contact(each, each.covariance_trace)
        axes.plot(span.seconds(each.stamp), trace, label=each.estimator, **style)
    axes.set_yscale("log")


def _draw_force(
    axes: Axes, span: _Span, estimates: Sequence[TissueEstimates], recording: Recording
) -> None:
    stamps = recording.stamps
    inside = span.holds(stamps)
    axes.plot(span.seconds(stamps[inside]), recording.force[inside], **_MEASURED_LINE)
    for each, style in zip(estimates, cycle(_FILTER_STYLES), strict=False):
        rows = each[span.holds(each.stamp)]
        axes.plot(span.seconds(rows.stamp), rows.predicted_force, label=each.estimator, **style)
    axes.set_ylim(*_limits(recording.force[inside], stray=0.1))


def _draw_innovation(axes: Axes, span: _Span, estimates: Sequence[TissueEstimates]) -> None:
    """Draw the root mean square of measured minus predicted force over short intervals."""
    count = max(1, round(span.seconds(span.end) / INNOVATION_INTERVAL))
    edges = np.linspace(0.0, span.seconds(span.end), count + 1)
    for each, style in zip(estimates, cycle(_FILTER_STYLES), strict=False):
        valid = (each.status != Status.NO_CONTACT) & np.isfinite(each.innovation)
        time = span.seconds(each.stamp[valid])
        samples, _ = np.histogram(time, edges)
        squares, _ = np.histogram(time, edges, weights=each.innovation[valid] ** 2)
        # An interval that is mostly without contact says nothing.
        full = samples > samples.max() / 2
        mean_square = np.divide(squares, samples, out=np.full(count, np.nan), where=full)
        axes.stairs(
            MILLINEWTONS * np.sqrt(mean_square), edges, baseline=None, label=each.estimator, **style
        )
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(LogFormatter())
    axes.yaxis.set_minor_formatter(LogFormatter())


def _mark_dwells(column: Sequence[Axes], span: _Span, dwells: Sequence[_Dwell]) -> None:
    """Shade the dwells, and number their sites along the top."""
    ends = [(span.seconds(dwell.span.begin), span.seconds(dwell.span.end)) for dwell in dwells]
    for axes in column:
        for begin, end in ends:
            axes.axvspan(begin, end, color="0.94", zorder=0.0)
    every = -(-len(dwells) // LABELLED_SITES)
    numbers = column[0].secondary_xaxis("top")
    numbers.set_xticks(
        [(begin + end) / 2.0 for begin, end in ends[::every]],
        [str(dwell.site) for dwell in dwells[::every]],
        fontsize=8,
    )
    numbers.tick_params(length=0.0)


def _label(figure: Figure, panels: NDArray[Any]) -> None:
    names = ("stiffness k [N/m]", "damping β [N s/m]", "covariance trace, mixed units", "force [N]")
    for axes, name in zip(panels[:, 0], names, strict=True):
        axes.set_ylabel(name)
    panels[3, 1].set_ylabel("rms force error [mN]")
    panels[3, 0].set_xlabel("time [s]")
    panels[3, 1].set_xlabel("time [s]")
    panels[0, 0].set_title("First second; thin until converged")
    panels[0, 1].set_title("Whole recording")
    for axes in panels.flat:
        axes.grid(alpha=0.3)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    more, more_labels = panels[3, 0].get_legend_handles_labels()
    entries = dict(zip(labels + more_labels, handles + more, strict=True))
    figure.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=len(entries))
    figure.align_ylabels(panels[:, 0])
