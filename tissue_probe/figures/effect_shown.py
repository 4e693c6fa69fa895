"""One effect as a picture: the force with it and without, and the plain model's residual."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from tissue_probe.figures.shown_figure import ShownFigure
from tissue_probe.signals import FloatArray

# Okabe and Ito's colours, told apart by every eye.
_WITHOUT: dict[str, Any] = {"color": "0.6", "linewidth": 3.0, "label": "without"}
_WITH: dict[str, Any] = {"color": "#0072B2", "linewidth": 1.1, "label": "with"}
_LEFT: dict[str, Any] = {"color": "#D55E00", "linewidth": 0.9}
#: Fixed: to fit them to the labels takes three times as long as to draw.
_MARGINS = {"left": 0.1, "right": 0.98, "bottom": 0.09, "top": 0.98, "hspace": 0.06, "wspace": 0.05}


@dataclass(frozen=True)
class ShownEffect:
    """The force under one motion.

    Attributes
    ----------
    position : array, shape (n,)
        [m]
    speed : array, shape (n,)
        [m/s]
    without, added : array, shape (n,)
        Force of the plain model, and of the same with the effect [N].
    left : array, shape (n,)
        Residual of the plain model with the values that come nearest to the effect [N].
    """

    position: FloatArray
    speed: FloatArray
    without: FloatArray
    added: FloatArray
    left: FloatArray


def draw_effect(shown: ShownEffect) -> Figure:
    """Draw force and residual over position and over speed."""
    figure = ShownFigure(figsize=(9.0, 6.0))
    axes = figure.subplots(2, 2, sharex="col", sharey="row", gridspec_kw=_MARGINS)
    for column, across in enumerate((1e3 * shown.position, 1e3 * shown.speed)):
        axes[0, column].plot(across, shown.without, **_WITHOUT)
        axes[0, column].plot(across, shown.added, **_WITH)
        axes[1, column].plot(across, 1e3 * shown.left, **_LEFT)
    axes[0, 0].set_ylabel("force [N]")
    axes[0, 0].legend(loc="upper left", fontsize="small")
    axes[1, 0].set(xlabel="position [mm]", ylabel="residual of the\nplain model [mN]")
    axes[1, 1].set_xlabel("speed [mm/s]")
    for each in axes.flat:
        each.grid(alpha=0.3)
    return figure
