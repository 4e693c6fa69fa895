"""Measured against predicted as a picture: how far off, and where.

Contents: how a comparison looks on one page.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import LogFormatter, NullFormatter
from numpy.typing import NDArray

from tissue_probe.diagnosis.residuals.localise import Localisation, Profile
from tissue_probe.figures.shown_figure import ShownFigure
from tissue_probe.quantities import FORCE, Quantity
from tissue_probe.signals import FloatArray

ZOOMED_CROSSINGS = 7  # of the signal through its mean: three cycles and a half
ROOM_FOR_LEGEND = 0.25  # of the axis
SAMPLES_IN_BIN = 8  # samples in a bin, from which on its error is shown
#: The axis of profiles: the whitened residual, which is not the error beside it.
WHITENED = "rms error / noise,\nknown 1/f noise taken out"
RASTERISED = 5000  # samples from which on a line in an SVG is stored as an image

# Okabe and Ito's colours, told apart by every eye.
_BLUE, _VERMILION, _ORANGE = "#0072B2", "#D55E00", "#E69F00"
_MEASURED_STYLE: dict[str, Any] = {"color": "0.6", "linewidth": 3.0, "label": "measured"}
_PREDICTED: dict[str, Any] = {"color": _BLUE, "linewidth": 1.3, "label": "predicted"}
_RESIDUAL: dict[str, Any] = {"color": _VERMILION, "linewidth": 0.8, "label": "measured − predicted"}
_NOISE_BAND: dict[str, Any] = {"color": "0.25", "alpha": 0.35, "linewidth": 0.0, "zorder": 3.0}
_HERE: dict[str, Any] = {"facecolor": _ORANGE, "alpha": 0.3, "linewidth": 0.0, "zorder": 0.0}
_PHASES = {-180.0: "out", -90.0: "going in", 0.0: "deepest", 90.0: "coming out", 180.0: "out"}


@dataclass(frozen=True)
class Comparison:
    """A channel as measured and as a model predicts it.

    Parameters
    ----------
    time : array, shape (N,)
        Times of the samples [s].
    measured, predicted : array, shape (N,)
        The output [its SI unit].
    localisation : Localisation
        Where the residual lies.
    noise : float
        Standard deviation of the output's white noise.
    output : Quantity
        The channel.
    """

    time: FloatArray
    measured: FloatArray
    predicted: FloatArray
    localisation: Localisation
    noise: float
    output: Quantity = FORCE

    @property
    def residual(self) -> FloatArray:
        """Measured minus predicted, shape (N,)."""
        return self.measured - self.predicted


def draw_comparison(
    time: FloatArray,
    measured: FloatArray,
    predicted: FloatArray,
    localisation: Localisation,
    noise: float,
    output: Quantity = FORCE,
    used: NDArray[np.bool_] | None = None,
    name: str = "",
) -> Figure:
    """Draw signal and error over time, whole and magnified, and the error over six quantities.

    Below, each panel shows the rms error as a multiple of the noise; a right model leaves 1.
    Regions that stand out are marked "here".

    Parameters
    ----------
    time : array, shape (N,)
        Times of the samples [s].
    measured, predicted : array, shape (N,)
        The samples, and a model's prediction.
    localisation : Localisation
        Where the residual lies, with the six profiles of `localise`.
    noise : float
        Standard deviation of the output's white noise.
    output : Quantity
        The channel.
    used : array of bool, shape (N,), optional
        Which samples the error in the title is of; all by default.
    name : str
        Which of several records this is.
    """
    figure = ShownFigure(figsize=(12.0, 12.0), layout="constrained")
    rows = figure.add_gridspec(4, 1, height_ratios=(1.0, 0.8, 1.1, 1.1), hspace=0.06)
    shown = Comparison(time, measured, predicted, localisation, noise, output)
    _draw_signals(figure, rows[:2], shown)
    panels = rows[2:].subgridspec(2, 3).subplots(sharey=True, squeeze=False)
    for axes, profile in zip(panels.flat, localisation.profiles, strict=True):
        draw_profile(axes, profile, noise)
        bold = "bold" if profile is localisation.here else None
        axes.set_title(describe_axis(profile), fontsize=11, fontweight=bold)
    for axes in panels[:, 0]:
        axes.set_ylabel(WHITENED)
    scale_profiles(panels[0, 0], localisation.profiles, noise)
    taken = slice(None) if used is None else used
    title = _title(measured[taken], predicted[taken], localisation, noise, output)
    figure.suptitle(f"{name}\n{title}" if name else title, fontsize=13)
    return figure


def _title(
    measured: FloatArray,
    predicted: FloatArray,
    localisation: Localisation,
    noise: float,
    output: Quantity,
) -> str:
    error = np.sqrt(np.mean((measured - predicted) ** 2))
    size = output.size(measured) or 1.0
    first = (
        f"Error {output.tell(error)} rms: {100.0 * error / size:.3g} % of the {output.name}, "
        f"{error / noise:.3g} times the noise of {output.tell(noise)}"
    )
    here = localisation.here
    return f"{first}\nWhere most: {here.describe()}" if here else f"{first}\nNo region stands out"


def _draw_signals(figure: Figure, place: SubplotSpec, shown: Comparison) -> None:
    parts = place.subgridspec(2, 2, width_ratios=(2, 1))
    panels = parts.subplots(sharex="col", sharey="row", squeeze=False)
    magnified = zoom(shown)
    draw_stretch(panels[:, 0].tolist(), shown, slice(None))
    draw_stretch(panels[:, 1].tolist(), shown, magnified)
    for axes in panels[:, 0]:
        begin, end = shown.time[magnified][[0, -1]]
        axes.axvspan(begin, end, color="0.9", zorder=0.0)
        add_legend(axes)
    for axes in panels[:, 1]:
        axes.set_ylabel("")
    panels[0, 0].set_title("Whole record")
    panels[0, 1].set_title("Magnified: where the error stands out")


def draw_stretch(panels: Sequence[Axes], shown: Comparison, span: slice) -> None:
    """Draw a stretch of both signals, and below it their difference beside the noise.

    Parameters
    ----------
    panels : sequence of Axes
        The upper and the lower one.
    shown : Comparison
        The whole record.
    span : slice
        Which samples of it.
    """
    above, below = panels
    time, output = shown.time[span], shown.output
    style: dict[str, Any] = {"rasterized": time.size > RASTERISED}
    above.plot(time, output.per_drawn * shown.measured[span], **_MEASURED_STYLE, **style)
    above.plot(time, output.per_drawn * shown.predicted[span], **_PREDICTED, **style)
    below.plot(time, output.per_small * shown.residual[span], **_RESIDUAL, **style)
    twice = 2.0 * output.per_small * shown.noise
    below.axhspan(-twice, twice, label="± 2 sd of the noise", **_NOISE_BAND)
    above.set_ylabel(f"{output.name} [{output.drawn}]")
    below.set_ylabel(f"error [{output.small}]")
    for axes in panels:
        axes.set_xlim(time[0], time[-1])
        axes.grid(alpha=0.3)
    below.set_xlabel("time [s]")


def add_legend(axes: Axes, room: float = ROOM_FOR_LEGEND) -> None:
    """Add a legend, and room for it above the curves, as a share of the axis."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + room * (high - low))
    axes.legend(loc="upper right", ncols=2, fontsize=9)


def zoom(shown: Comparison) -> slice:
    """Return a few cycles of the signal around the largest error, or an eighth of the record.

    Where a time stands out the error is sought there: elsewhere it may be slow noise that is known.
    """
    time, measured = shown.time, shown.measured
    width = max(2, measured.size // 50)
    energy = np.convolve(shown.residual**2, np.ones(width), mode="same")
    profiles = shown.localisation.profiles
    here = next((p.here for p in profiles if p.quantity == "time"), None)
    if here:
        energy = np.where((time >= here.begin) & (time <= here.end), energy, 0.0)
    centre = int(np.argmax(energy))
    smooth = np.convolve(measured - measured.mean(), np.ones(5) / 5.0, mode="same")
    crossings = np.flatnonzero(np.diff(np.signbit(smooth)))
    if crossings.size < 2 * ZOOMED_CROSSINGS:
        half = measured.size // 16
        begin = min(max(0, centre - half), measured.size - 2 * half)
        return slice(begin, begin + 2 * half)
    middle = int(np.searchsorted(crossings, centre))
    first = min(max(0, middle - ZOOMED_CROSSINGS // 2), crossings.size - ZOOMED_CROSSINGS)
    return slice(int(crossings[first]), int(crossings[first + ZOOMED_CROSSINGS - 1]) + 1)


def _ratio(profile: Profile, noise: float) -> FloatArray:
    """Return the rms error over the noise; NaN where too few samples would tell chance only."""
    return np.sqrt(np.where(profile.expected < SAMPLES_IN_BIN * noise**2, np.nan, profile.excess))


def draw_profile(axes: Axes, profile: Profile, noise: float) -> None:
    """Draw the rms error over one quantity as a multiple of the noise, its region marked.

    Parameters
    ----------
    axes : Axes
        Empty ones; their vertical scale is `scale_profiles`'s to set.
    profile : Profile
        The error over the quantity.
    noise : float
        Standard deviation of the output's white noise.
    """
    ratio = _ratio(profile, noise)
    axes.stairs(ratio, profile.edges, baseline=0.0, fill=True, color=_BLUE)
    axes.axhline(1.0, color="black", linestyle=":", linewidth=1.6)
    axes.set_xlim(profile.edges[0], profile.edges[-1])
    axes.grid(alpha=0.3)
    if profile.quantity == "frequency":
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(LogFormatter())
        axes.xaxis.set_minor_formatter(NullFormatter())
    if profile.quantity == "phase":
        ticks = [f"{phase:g}°\n{name}" for phase, name in _PHASES.items()]
        axes.set_xticks(list(_PHASES), ticks)
    if profile.labels:
        middles = 0.5 * (profile.edges[:-1] + profile.edges[1:])
        axes.set_xticks(middles, profile.labels)
    _mark(axes, profile)


def describe_axis(profile: Profile) -> str:
    """Return the quantity of a profile's axis, with its unit."""
    if profile.quantity == "phase":
        return "phase of the cycle"
    return f"{profile.quantity} [{profile.unit}]" if profile.unit else profile.quantity


def _mark(axes: Axes, profile: Profile) -> None:
    """Shade the region that stands out, and write "here" over it."""
    here = profile.here
    if here is None:
        return
    pieces = [(here.begin, here.end)]
    if here.begin > here.end:
        pieces = [(here.begin, profile.edges[-1]), (profile.edges[0], here.end)]
    for begin, end in pieces:
        axes.axvspan(begin, end, **_HERE)
    begin, end = max(pieces, key=lambda piece: piece[1] - piece[0])
    left, right = axes.transAxes.inverted().transform(
        axes.transData.transform([(begin, 1.0), (end, 1.0)])
    )[:, 0]
    box = {"facecolor": "white", "edgecolor": _ORANGE, "boxstyle": "round,pad=0.25"}
    axes.text(
        # Kept off the panel's edges, where a narrow region's words would run out.
        np.clip(0.5 * (left + right), 0.16, 0.84),
        0.97,
        f"here: {100.0 * min(here.share, 1.0):.0f} %",
        transform=axes.transAxes,
        ha="center",
        va="top",
        fontsize=10,
        fontweight="bold",
        bbox=box,
    )


def scale_profiles(axes: Axes, profiles: Sequence[Profile], noise: float) -> None:
    """Leave room for the marks; take a logarithmic axis where the error spans much.

    Parameters
    ----------
    axes : Axes
        Those of the profiles, or one of several that share the axis.
    profiles : sequence of Profile
        All that are drawn there.
    noise : float
        Standard deviation of the output's white noise.
    """
    ratios = np.concatenate([_ratio(profile, noise) for profile in profiles])
    ratios = ratios[np.isfinite(ratios) & (ratios > 0.0)]
    if ratios.size and ratios.max() > 10.0:
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(LogFormatter())
        axes.set_ylim(0.5, 4.0 * ratios.max())
    else:
        axes.set_ylim(0.0, 1.35 * max(ratios.max(initial=1.0), 1.5))
