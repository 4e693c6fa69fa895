"""A study as one HTML page that needs nothing else, as the report of an improvement does.

Contents: the parts of the page, its forest plots, and filling its template.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from matplotlib.ticker import MaxNLocator

from tissue_probe.report.frequency_plot import FrequencyPlot
from tissue_probe.report.numbers import interval
from tissue_probe.report.page import templates

#: Steps of an axis at most: more would run into each other on a telephone.
AXIS_STEPS = 4


@dataclass(frozen=True)
class Line:
    """A line of a forest plot: a value with its 95 % interval.

    Parameters
    ----------
    label : str
        The recording, or the group of a mean.
    value, low, high : float
        In the forest's unit.
    mean : bool
        Whether it is a mean, which is drawn as a diamond.
    beside : float
        A second value, drawn hollow; NaN for none.
    link : str
        A page about it; empty for none.
    """

    label: str
    value: float
    low: float
    high: float
    mean: bool = False
    beside: float = math.nan
    link: str = ""


@dataclass(frozen=True)
class Forest:
    """A forest plot: its lines on one axis.

    Parameters
    ----------
    title, unit, note : str
        Name and unit of the value in words; ``note`` in sentences.
    lines : sequence of Line
        From top to bottom; at least one, whose value is finite.
    """

    title: str
    unit: str
    note: str
    lines: Sequence[Line]

    def span(self) -> tuple[float, float]:
        """Return the ends of the axis: of all that is drawn, and a little room."""
        every = [
            each
            for line in self.lines
            for each in (line.value, line.low, line.high, line.beside)
            if math.isfinite(each)
        ]
        low, high = min(every), max(every)
        room = 0.03 * (high - low) or 0.05 * abs(high) or 1.0
        return low - room, high + room

    def place(self, value: float) -> str:
        """Return where a value stands, in per cent of the width."""
        low, high = self.span()
        return f"{100.0 * (value - low) / (high - low):.2f}%"

    def steps(self) -> Iterator[tuple[str, str]]:
        """Yield the places and texts of the axis' steps."""
        low, high = self.span()
        for each in MaxNLocator(AXIS_STEPS).tick_values(low, high):
            if low <= each <= high:
                yield self.place(each), f"{each:g}".replace("-", "−")


@dataclass(frozen=True)
class Level:
    """One value of a factor: how many recordings have it, how many are done, and their mean."""

    name: str
    recordings: int
    done: int
    mean: str = ""


@dataclass(frozen=True)
class Factor:
    """A factor: its levels, and contrasts of these (or why there are none), in words."""

    name: str
    levels: Sequence[Level]
    contrasts: Sequence[tuple[str, str]] = ()
    note: str = ""


@dataclass(frozen=True)
class StudyFacts:
    """A recording in a list: its name, a page about it (or none), and the cells of its row."""

    name: str
    link: str
    cells: Sequence[str]


@dataclass(frozen=True)
class StudyPage:
    """All that the page says.

    Parameters
    ----------
    title : str
        Heading of the page.
    work : mapping of str to str
        The work done: names and values.
    notes : sequence of str
        Damaged batches, changed files and repeated ones, in sentences.
    excluded : sequence of Told
        Recordings that no statistics take, each with the reason.
    forests : sequence of Forest
        Values.
    over_frequency : sequence of FrequencyPlot
        Storage and loss over the frequency that drives.
    spread : sequence of (str, str)
        How the first value spreads: names and values with intervals.
    spread_note : str
        Which value spreads over which factor, or why the spread cannot be told.
    factors : sequence of Factor
        Specimens, days, operators.
    verdicts : mapping of str to int
        How many recordings have which.
    effects : sequence of (str, float, float, float)
        Share of recordings that miss each effect, with its interval.
    columns : sequence of str
        Names of the cells of ``recordings``.
    recordings : sequence of Told
        All, or the first of many.
    left : str
        Where the others are; empty where all are there.
    command : str
        The command that makes a recording's own report; empty where each has one.
    files : sequence of str
        Tables beside the page.
    created : str
        Date and version.
    """

    title: str
    work: Mapping[str, str]
    notes: Sequence[str] = ()
    excluded: Sequence[StudyFacts] = ()
    forests: Sequence[Forest] = ()
    over_frequency: Sequence[FrequencyPlot] = ()
    spread: Sequence[tuple[str, str]] = ()
    spread_note: str = ""
    factors: Sequence[Factor] = ()
    verdicts: Mapping[str, int] = field(default_factory=dict)
    effects: Sequence[tuple[str, float, float, float]] = ()
    columns: Sequence[str] = ()
    recordings: Sequence[StudyFacts] = ()
    left: str = ""
    command: str = ""
    files: Sequence[str] = ()
    created: str = ""


def render_study(page: StudyPage) -> str:
    """Return the page as HTML; its plots are drawings (SVG) within, and it loads nothing."""
    environment = templates()
    environment.filters["per_cent"] = lambda share: f"{100.0 * share:.0f} %"
    environment.globals["told"] = _tabulate_line
    return environment.get_template("study.html.jinja").render(page=page)


def _tabulate_line(line: Line) -> str:
    value, between = interval(line.value, line.low, line.high)
    return f"{value} [{between}]" if between else value
