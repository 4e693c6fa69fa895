"""Values over frequency for a page without a script: points with intervals, both axes logarithmic.

Contents: the points, and where they and the steps of the axes stand in the drawing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from matplotlib.ticker import LogLocator

#: Groups that are told apart, each by a colour and a shape of its own.
GROUPS = 4
#: An axis is this much longer than its values to either side, and has a decade's share at least.
ROOM, SHORTEST_AXIS = 0.05, 0.3
#: Height of the drawing [px]: an interval is a share of it.
HEIGHT = 220


@dataclass(frozen=True)
class FrequencyPoint:
    """A value at a frequency [Hz], both above 0, with its 95 % interval.

    Parameters
    ----------
    label, link : str
        The recording, and a page about it; empty for none.
    frequency, value, low, high : float
        In Hz, and in the plot's unit.
    group : int
        Number of its group, from 0.
    """

    label: str
    frequency: float
    value: float
    low: float
    high: float
    group: int = 0
    link: str = ""


@dataclass(frozen=True)
class FrequencyPlot:
    """One value over frequency.

    Parameters
    ----------
    title, unit, note : str
        Name and unit of the value in words; ``note`` in sentences.
    points : sequence of FrequencyPoint
        At least one.
    groups : sequence of str
        Names of the groups that are told apart; empty for none.
    """

    title: str
    unit: str
    note: str
    points: Sequence[FrequencyPoint]
    groups: Sequence[str] = ()

    @property
    def height(self) -> int:
        """Height of the drawing [px]."""
        return HEIGHT

    def across(self, frequency: float) -> str:
        """Return where a frequency stands, in per cent of the width."""
        return f"{100.0 * _share(frequency, *self._frequencies()):.2f}%"

    def down(self, value: float) -> str:
        """Return how far from the top a value stands [px]; at the bottom where it is 0 or less."""
        share = _share(value, *self._values()) if value > 0.0 else 0.0
        return f"{HEIGHT * (1.0 - min(max(share, 0.0), 1.0)):.1f}"

    def frequency_steps(self) -> Iterator[tuple[str, str]]:
        """Yield the places and texts of the steps of the axis of frequency."""
        return _steps(self._frequencies(), self.across)

    def value_steps(self) -> Iterator[tuple[str, str]]:
        """Yield the places and texts of the steps of the axis of values."""
        return _steps(self._values(), self.down)

    def _frequencies(self) -> tuple[float, float]:
        return _span([each.frequency for each in self.points])

    def _values(self) -> tuple[float, float]:
        """Return the ends of the axis; an interval's lower end may be below 0: half the value."""
        lower = [max(each.low, 0.5 * each.value) for each in self.points]
        return _span([*lower, *(each.high for each in self.points)])


def _span(values: Sequence[float]) -> tuple[float, float]:
    """Return the decimal logarithms of an axis' ends."""
    low, high = math.log10(min(values)), math.log10(max(values))
    room = max(ROOM * (high - low), 0.5 * (SHORTEST_AXIS - (high - low)))
    return low - room, high + room


def _share(value: float, low: float, high: float) -> float:
    return (math.log10(value) - low) / (high - low)


def _steps(span: tuple[float, float], place: Callable[[float], str]) -> Iterator[tuple[str, str]]:
    low, high = (10.0**each for each in span)
    wide = span[1] - span[0] > 2.0  # decades: then a step for each is enough
    for each in LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 5.0)).tick_values(low, high):
        if low <= each <= high:
            yield place(float(each)), f"{each:g}"
