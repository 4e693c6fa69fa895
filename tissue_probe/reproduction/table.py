"""The figures there are. A new one is a function beside these and a line here."""

from __future__ import annotations

from collections.abc import Callable

from tissue_probe.reproduction.baseline import fig7, fig8
from tissue_probe.reproduction.finding import Reproduction
from tissue_probe.reproduction.frequency import fig9, fig15, fig16
from tissue_probe.reproduction.lift_figure import fig11
from tissue_probe.reproduction.liver import fig14
from tissue_probe.reproduction.materials import fig10
from tissue_probe.reproduction.ring_down import fig6
from tissue_probe.reproduction.scan import fig12
from tissue_probe.reproduction.steps import fig3, fig4

FIGURES: dict[str, Callable[[], Reproduction]] = {
    "fig3": fig3,
    "fig4": fig4,
    "fig6": fig6,
    "fig7": fig7,
    "fig8": fig8,
    "fig9": fig9,
    "fig10": fig10,
    "fig11": fig11,
    "fig12": fig12,
    "fig14": fig14,
    "fig15": fig15,
    "fig16": fig16,
}
