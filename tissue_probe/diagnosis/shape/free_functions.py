"""Free functions of all that a missing force may depend on: columns linear in their weights.

Contents: for each variable, and for pairs that act together, the functions that stand for any.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from tissue_probe.diagnosis.shape.paths import Path
from tissue_probe.diagnosis.shape.splines import Spline, even_knots, knots_about_zero
from tissue_probe.quantities import FORCE
from tissue_probe.signals import FloatArray

#: Variables that a missing force may depend on, in the order in which it is told.
VARIABLES = ("indentation", "velocity", "past", "path", "force", "clock")
#: Knots of a function of one signal: kinks are seen to a tenth of the range. Of two signals each
#: has fewer, since their numbers multiply.
KNOTS, KNOTS_OF_TWO = 18, 8
#: How far the outermost knots lie beyond the signal, in shares of its range: there a spline is
#: straight, which a law at the end of the range is not.
KNOT_OVERHANG = 0.05
#: Speed below which knots are even, in shares of the largest: most laws of speed bend near 0.
EVEN_KNOTS_SHARE = 0.05
#: Speeds within which a force turns with the direction, in shares of the largest.
TURNS = (0.003, 0.01, 0.03, 0.1)
#: Rates of relaxation: so many a decade, alone and beside each function of the indentation.
RATES, RATES_OF_TWO = 5.0, 1.5
#: The slowest and fastest rate, over the record's duration and the sampling rate: a slower branch
#: is a spring in this record, a faster one a damper.
SLOWEST, FASTEST = 0.3, 0.3
#: Ways after which a spring slides, in shares of the travel.
WAYS = (0.01, 0.02, 0.04, 0.08, 0.16, 0.3, 0.5, 0.75)

Columns = Callable[[Path], FloatArray]


@dataclass(frozen=True, eq=False)
class Group:
    """Functions that are as likely as one another to be large.

    Attributes
    ----------
    name : str
        Their name.
    variables : frozenset of str
        All that they depend on: they are tried where all of these are.
    columns : callable
        From a path to their values, shape (n, m): forces of the tissue on the tip [N], or of the
        force channel.
    at_tip : bool
        Whether they push the tip, which answers; else they are in the channel only.
    """

    name: str
    variables: frozenset[str]
    columns: Columns
    at_tip: bool = True


@dataclass(frozen=True, eq=False)
class Functions:
    """Free functions for some measurements: where their knots lie, and at which rates they relax.

    Attributes
    ----------
    depth, few_depth, speed, few_speed, channel, clock, few_clock : Spline
        Of indentation [m], velocity [m/s], force [N], time [s]; the short ones for products.
    fastest : float
        Largest speed [m/s].
    rates, few_rates : array
        Of relaxation [1/s].
    ways : array
        After which a spring slides [m].
    drives : bool
        Whether the force is the input: then its channel acts on the tip.
    """

    depth: Spline
    few_depth: Spline
    speed: Spline
    few_speed: Spline
    channel: Spline
    clock: Spline
    few_clock: Spline
    fastest: float
    rates: FloatArray
    few_rates: FloatArray
    ways: FloatArray
    drives: bool

    @classmethod
    def of(cls, found: Sequence[Path]) -> Functions:
        """Return the free functions for the paths of all measurements."""
        x, v, force, time = (
            np.concatenate([getattr(path, name)[path.measurement.used] for path in found])
            for name in ("indentation", "velocity", "force", "time")
        )
        fastest = float(np.max(np.abs(v)))
        duration = float(np.ptp(time))
        period = min(path.measurement.sample_period for path in found)
        low, high = SLOWEST / duration, FASTEST / period
        return cls(
            _even(x, KNOTS),
            _even(x, KNOTS_OF_TWO),
            _about_zero(fastest, KNOTS),
            _about_zero(fastest, KNOTS_OF_TWO),
            _even(force, KNOTS),
            _even(time, KNOTS),
            _even(time, KNOTS_OF_TWO),
            fastest,
            _rates(low, high, RATES),
            _rates(low, high, RATES_OF_TWO),
            np.array(WAYS) * float(np.ptp(x)),
            found[0].measurement.output is not FORCE,
        )

    def groups(self) -> list[Group]:
        """Return all groups, those of one variable first."""
        x, v = frozenset(["indentation"]), frozenset(["velocity"])
        past, path = frozenset(["past"]), frozenset(["path"])
        force, clock = frozenset(["force"]), frozenset(["clock"])
        return [
            Group("straight", frozenset(), self.straight),
            Group("level", x, lambda p: np.ones((p.time.size, 1))),
            Group("depth", x, lambda p: self.depth.columns(p.indentation)),
            Group("speed", v, lambda p: self._from_zero(self.speed, p.velocity)),
            Group("turns", v, self.turns),
            Group("relaxation", past, self.relaxation),
            Group("slides", path, self.slides),
            Group("channel", force, self._of_force, at_tip=self.drives),
            Group("drift", clock, self._drift, at_tip=self.drives),
            Group("change", clock, self._change),
            Group("speed by depth", x | v, self.speed_by_depth),
            Group("relaxation of a function", x | past, self.relaxation_of_function),
            Group("largest", x | path, _largest),
        ]

    def straight(self, path: Path) -> FloatArray:
        """Return a spring and a damper along the path: a fit's are along that of the fit."""
        size = np.array([np.ptp(self.depth.knots), self.fastest])
        found: FloatArray = np.stack([path.indentation, path.velocity], axis=1) / size
        return found

    @staticmethod
    def _from_zero(spline: Spline, signal: FloatArray) -> FloatArray:
        return spline.columns(signal) - spline.columns(np.zeros(1))

    def turns(self, path: Path) -> FloatArray:
        """Return forces that turn with the direction, at once or in proportion to the speed."""
        widths = self.fastest * np.array(TURNS)
        turned = np.tanh(path.velocity[:, None] / widths)
        size = (np.abs(path.velocity) / self.fastest)[:, None]
        return np.concatenate([turned, size], axis=1)

    def relaxation(self, path: Path) -> FloatArray:
        """Return the compressions of springs in series with dampers, over the travel."""
        return np.stack([self._relaxed(path.indentation, path, r) for r in self.rates], axis=1)

    def depths(self, path: Path) -> FloatArray:
        """Return few functions of the indentation: straight, then bent ones."""
        x = self.few_depth.knots
        straight = (path.indentation / np.ptp(x))[:, None]
        return np.concatenate([straight, self.few_depth.columns(path.indentation)], axis=1)

    def speeds(self, path: Path) -> FloatArray:
        """Return few functions of the speed: straight, bent ones, one that turns, and its size."""
        v = path.velocity
        straight = (v / self.fastest)[:, None]
        turns = np.tanh(v / (self.fastest * TURNS[1]))[:, None]
        bent = self._from_zero(self.few_speed, v)
        return np.concatenate([straight, bent, turns, np.abs(straight)], axis=1)

    def speed_by_depth(self, path: Path) -> FloatArray:
        """Return products of both."""
        return _products(self.depths(path), self.speeds(path))

    def relaxation_of_function(self, path: Path) -> FloatArray:
        """Return relaxed functions of the indentation that are not straight."""
        bent = self.few_depth.columns(path.indentation)
        return np.concatenate([self._relaxed(bent, path, r) for r in self.few_rates], axis=1)

    def slides(self, path: Path) -> FloatArray:
        """Return elongations of springs that slide after a way, over that way."""
        return slid(path.indentation, self.ways) / self.ways

    def _relaxed(self, signal: FloatArray, path: Path, rate: float) -> FloatArray:
        """Return z of z' = signal' - rate z, the signal being straight between samples."""
        share = rate * path.measurement.sample_period
        kept, through = np.exp(-share), -np.expm1(-share) / share
        rises = np.diff(signal, axis=0, prepend=signal[:1])
        return np.asarray(lfilter([through], [1.0, -kept], rises, axis=0))

    def _of_force(self, path: Path) -> FloatArray:
        size = np.max(np.abs(self.channel.knots))
        straight = path.force[:, None] / size
        columns = np.concatenate([straight, self.channel.columns(path.force)], axis=1)
        return -columns if self.drives else columns

    def _drift(self, path: Path) -> FloatArray:
        straight = (path.time / np.ptp(self.clock.knots))[:, None]
        return np.concatenate([straight, self.clock.columns(path.time)], axis=1)

    def _change(self, path: Path) -> FloatArray:
        straight = (path.time / np.ptp(self.clock.knots))[:, None]
        times = np.concatenate([straight, self.few_clock.columns(path.time)], axis=1)
        depth = path.indentation / np.ptp(self.depth.knots)
        return times * depth[:, None]


def in_order(variables: frozenset[str]) -> tuple[str, ...]:
    """Return variables in the order in which they are told."""
    return tuple(name for name in VARIABLES if name in variables)


def slid(way: FloatArray, ways: FloatArray) -> FloatArray:
    """Return how long springs are that slide where they are longer than ``ways``: (n, m)."""
    found = np.empty((way.size, ways.size))
    length = np.zeros(ways.size)
    before = way[0]
    for index, at in enumerate(way):
        length = np.minimum(np.maximum(length + (at - before), -ways), ways)
        before, found[index] = at, length
    return found


def _even(signal: FloatArray, count: int) -> Spline:
    low, high = float(np.min(signal)), float(np.max(signal))
    beyond = KNOT_OVERHANG * (high - low)
    return Spline(even_knots(low - beyond, high + beyond, count))


def _about_zero(fastest: float, count: int) -> Spline:
    return Spline(
        knots_about_zero((1.0 + KNOT_OVERHANG) * fastest, EVEN_KNOTS_SHARE * fastest, count)
    )


def _rates(low: float, high: float, each_decade: float) -> FloatArray:
    count = max(2, round(each_decade * np.log10(high / low)))
    return np.geomspace(low, high, count)


def _products(one: FloatArray, other: FloatArray) -> FloatArray:
    return (one[:, :, None] * other[:, None, :]).reshape(len(one), -1)


def _largest(path: Path) -> FloatArray:
    """Return low powers of the indentation and of the largest so far, over the travel."""
    depth = (path.indentation - path.indentation.min()) / np.ptp(path.indentation)
    most = np.maximum.accumulate(depth)
    return np.stack([most, most**2, most * depth, most**2 * depth, most * depth**2], axis=1)
