"""A diagnosis on one page: the base model, where it fails, its effects, the residual.

Contents: how the three panels stand together, and the ranking's bars.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import Patch
from matplotlib.ticker import LogFormatter

from tissue_probe.figures.compare import (
    WHITENED,
    Comparison,
    add_legend,
    describe_axis,
    draw_profile,
    draw_stretch,
    scale_profiles,
    zoom,
)
from tissue_probe.figures.ladder import HEAD, Rungs, draw_rungs, multiple, wrap_name
from tissue_probe.figures.shown_figure import ShownFigure
from tissue_probe.signals import FloatArray

BARS_SHOWN = 8  # effects of the ranking
STORY_WIDTH = 10.0  # inches
MODELS_BESIDE = 5  # models of a ladder, more of which have no room beside the ranking
LINE_LENGTH = 86  # characters of the title
NAME_WIDTH = 26  # characters of an effect's name, beside its bar
LOGARITHMIC_FROM = 10.0  # quotient of errors from which on their axis is logarithmic

# Okabe and Ito's colours, told apart by every eye; hatches tell them apart in grey.
_BLUE, _VERMILION = "#0072B2", "#D55E00"
_CHOSEN: dict[str, Any] = {"facecolor": _BLUE}
_TRIED: dict[str, Any] = {"facecolor": "0.78"}
_TIED: dict[str, Any] = {"hatch": "///", "edgecolor": "white", "linewidth": 0.0}
_BASE: dict[str, Any] = {"color": _VERMILION, "linestyle": "--", "linewidth": 1.6}
_NOISE: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 1.6}
#: Behind a number, so that no line is seen through it.
_BLANK: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "boxstyle": "square,pad=0.1"}
_HEADING: dict[str, Any] = {"loc": "left", "fontsize": 11, "fontweight": "bold"}


@dataclass(frozen=True)
class TriedEffect:
    """An effect that was tried alone.

    Parameters
    ----------
    name : str
        Its name.
    heldout : float
        Root mean square error on held-out data of the base model with it [unit of the output];
        infinite where it diverges there, NaN where it was not tried.
    added : bool
        Whether it is in the last model.
    tied : bool
        Whether it cannot be told from another one.
    """

    name: str
    heldout: float
    added: bool = False
    tied: bool = False


def draw_story(
    title: str, base: Comparison, ranking: Sequence[TriedEffect], rungs: Rungs, name: str = ""
) -> Figure:
    """Draw the base model and where it fails, above the gain of each effect and the ladder.

    Parameters
    ----------
    title : str
        The verdict in words.
    base : Comparison
        The base model on the fitted samples.
    ranking : sequence of Candidate
        The effects, the best first, of which the first eight are shown; if empty, the ladder takes
        their place.
    rungs : Rungs
        The ladder; its first model is the base.
    name : str
        Which of several records is shown of the base.
    """
    beside = bool(ranking) and len(rungs.models) <= MODELS_BESIDE
    rows = 2 if beside or not ranking else 3
    layout = ConstrainedLayoutEngine(hspace=0.06, wspace=0.04, h_pad=0.06, w_pad=0.06)
    figure = ShownFigure(figsize=(STORY_WIDTH, 4.2 * rows), layout=layout)
    grid = figure.add_gridspec(rows, 2, height_ratios=(1.2, *(rows - 1) * (1.0,)))
    _draw_base(figure, grid[0, :], base, rungs.models[0], name)
    if ranking:
        _draw_ranking(figure.add_subplot(grid[1, 0 if beside else slice(None)]), ranking, rungs)
    ladder = figure.add_subplot(grid[-1, 1 if beside else slice(None)])
    draw_rungs(ladder, rungs, (0.4 if beside else 0.9) * STORY_WIDTH)
    added = "Effects added, and the error left" if len(rungs.models) > 1 else "Nothing is added"
    ladder.set_title(f"{3 if ranking else 2}  {added}", pad=HEAD, **_HEADING)
    figure.suptitle(
        textwrap.fill(title, LINE_LENGTH), x=0.01, ha="left", fontsize=13, fontweight="bold"
    )
    return figure


def _draw_base(figure: Figure, place: SubplotSpec, base: Comparison, model: str, name: str) -> None:
    parts = place.subgridspec(1, 2, width_ratios=(2, 1))
    stretch = parts[0].subgridspec(2, 1, height_ratios=(3, 2))
    panels = stretch.subplots(sharex=True, squeeze=False)[:, 0].tolist()
    draw_stretch(panels, base, zoom(base))
    for axes, room in zip(panels, (0.3, 0.45), strict=True):
        add_legend(axes, room)
    if name:
        panels[1].set_xlabel(f"time [s], {name}")
    panels[0].set_title(f"1  The base model: {model}", **_HEADING)
    here = base.localisation.here
    profile = here or base.localisation.profiles[0]
    axes = figure.add_subplot(parts[1])
    draw_profile(axes, profile, base.noise)
    scale_profiles(axes, [profile], base.noise)
    axes.set(xlabel=describe_axis(profile), ylabel=WHITENED)
    axes.set_title("Where its error lies" if here else "Nothing stands out", **_HEADING)


def _draw_ranking(axes: Axes, ranking: Sequence[TriedEffect], rungs: Rungs) -> None:
    """Draw a bar for each effect, the best on top, beside the base model's error."""
    shown = ranking[:BARS_SHOWN]
    ratios = np.array([each.heldout for each in shown]) / rungs.noise
    base = rungs.heldout[0] / rungs.noise
    _scale_errors(axes, np.r_[ratios, base])
    for row, (each, ratio) in enumerate(zip(shown, ratios, strict=True)):
        _draw_bar(axes, row, each, ratio)
    if np.isfinite(base):
        axes.axvline(base, label="base model", **_BASE)
    axes.axvline(1.0, label="noise", **_NOISE)
    axes.set_yticks(range(len(shown)), [wrap_name(each.name, NAME_WIDTH) for each in shown])
    for label, each in zip(axes.get_yticklabels(), shown, strict=True):
        label.set_fontweight(_weight(each))
    axes.set_ylim(len(shown) - 0.5, -0.5)
    axes.set_xlabel("held-out error / noise")
    axes.set_title("2  Error left by each effect alone", **_HEADING)
    axes.grid(axis="x", which="both", alpha=0.25)
    axes.set_axisbelow(True)
    _add_key(axes, shown)


def _scale_errors(axes: Axes, ratios: FloatArray) -> None:
    """Leave room for the numbers; take a logarithmic axis where the errors span much."""
    known = np.r_[ratios[np.isfinite(ratios) & (ratios > 0.0)], 1.0]
    least, most = known.min(), known.max()
    if most < LOGARITHMIC_FROM * least:
        axes.set_xlim(0.0, 1.3 * most)
        return
    axes.set_xscale("log")
    axes.set_xlim(0.7 * least, most * (most / least) ** 0.25)
    for place in (axes.xaxis.set_major_formatter, axes.xaxis.set_minor_formatter):
        place(LogFormatter(minor_thresholds=(2.0, 0.7)))


def _draw_bar(axes: Axes, row: int, each: TriedEffect, ratio: float) -> None:
    """Draw the error that an effect leaves, or say why there is no number."""
    begin, told = axes.get_xlim()[0], multiple(ratio)
    if not np.isfinite(ratio):
        ratio, told = begin, "not known" if np.isnan(ratio) else "diverges"
    style = (_CHOSEN if each.added else _TRIED) | (_TIED if each.tied else {})
    axes.barh(row, ratio - begin, left=begin, height=0.72, **style)
    axes.annotate(
        told,
        (ratio, row),
        xytext=(5, 0),
        textcoords="offset points",
        va="center",
        fontsize=9,
        fontweight=_weight(each),
        bbox=_BLANK,
    )


def _weight(candidate: TriedEffect) -> str:
    return "bold" if candidate.added else "normal"


def _add_key(axes: Axes, shown: Sequence[TriedEffect]) -> None:
    kinds = [
        (any(each.added for each in shown), Patch(label="chosen", **_CHOSEN)),
        (any(each.tied for each in shown), Patch(label="cannot be told apart", **_TRIED | _TIED)),
    ]
    axes.legend(
        handles=[*(patch for drawn, patch in kinds if drawn), *axes.lines],
        loc="upper center",
        bbox_to_anchor=(0.4, -0.15),
        ncols=2,
        fontsize=9,
        frameon=False,
    )
