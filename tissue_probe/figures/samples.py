"""Position and force over time, as they were read."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from tissue_probe.figures.shown_figure import ShownFigure
from tissue_probe.signals import FloatArray

#: More points than that no picture shows.
POINTS_DRAWN = 20_000


def draw_samples(
    recordings: Sequence[tuple[FloatArray, FloatArray, FloatArray]], names: Sequence[str]
) -> Figure:
    """Draw recordings one over the other.

    Parameters
    ----------
    recordings : sequence of tuple of array
        Time [s], position [m] and force [N] of each.
    names : sequence of str
        One each.
    """
    figure = ShownFigure(figsize=(9.0, 5.0), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    for (time, position, force), name in zip(recordings, names, strict=True):
        every = slice(None, None, max(1, time.size // POINTS_DRAWN))
        upper.plot(time[every], 1e3 * position[every], linewidth=0.9, label=name)
        lower.plot(time[every], force[every], linewidth=0.9)
    upper.set_ylabel("position [mm]")
    lower.set(ylabel="force [N]", xlabel="time [s]")
    if len(names) > 1:
        upper.legend(loc="upper right", fontsize="small")
    for axes in (upper, lower):
        axes.grid(alpha=0.3)
    return figure
