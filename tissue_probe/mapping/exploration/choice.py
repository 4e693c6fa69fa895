"""The choice of the next sites: those that tell most about inclusions per second.

Contents: the gain of a site, and the choice of several at once.

The question is of each place whether it is inside an inclusion: h = 1, or 0. Over the states, the
sum over all places of the variance of h is the area that is in doubt. A site y at p, whose log k
is m_s(p) in state s with the variance of background and noise on it, removes at least the part of
that doubt that a linear estimate of h by y removes,

    gain(p) = cell * sum_q Cov(h_q, m_p)^2 / (Var m_p + noise_p),

which is the active learning of Cohn (Neural Networks 9 (1996) 1071) with membership for its target.
It counts inclusions that may hide where nothing was felt, and the edges of those that were found,
in one currency. A place that was felt before tells again where states differ in what they expect
of it: where they cannot tell drift from an inclusion, for one.

That refines edges first: so every other site is chosen where it most probably feels an inclusion
that none has felt (``unseen``). And an inclusion that hangs on one site is palpated again beside it
before anything else: it may be a slip.

Of places that tell as much as any, the one is taken that tells most per second, way included.
Of several sites each is chosen after the states' deviations were reduced by those before it, whose
values are not known yet but whose covariances are (square-root filter, Whitaker and Hamill,
Monthly Weather Review 130 (2002) 1913): so they are not one place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.exploration.places import spread
from tissue_probe.mapping.exploration.unseen_inclusions import Unseen
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.boundary import inside_each
from tissue_probe.mapping.posterior.domain import TIP
from tissue_probe.mapping.posterior.doubt import ASIDE
from tissue_probe.mapping.posterior.felt_surface import sums_at
from tissue_probe.mapping.posterior.outliers import ErrorKinds
from tissue_probe.mapping.posterior.posterior_sample import Sampled
from tissue_probe.signals import FloatArray, IntArray

_MM = 1e3
#: Enough for a covariance that is right to a tenth of the two deviations.
_CHOICE_STATES = 100
#: Gains that differ by less are not told apart by so many states: of those the nearest is taken.
#: Were the gain per second to decide among all, the probe would refine the edge of the first nodule
#: as long as that is near, and reach the others last; the way to them has to be gone once anyway.
_TOLD_APART = 0.2
#: Of candidates, and of places in question: in 40 x 40 mm a tip's radius, 3 mm, is two apart.
_CANDIDATES, _PLACES = 800, 400
MOST_AT_ONCE = 100
#: Where no site finds an unseen inclusion with this probability, none is chosen for that.
_LEAST_FOUND = 0.005
_WHY = {
    "again": "palpated again, beside a site that may have slipped",
    "edge": "where most of the area in doubt is settled",
    "find": "where an inclusion that no site has felt is most probable",
}
#: What sites are chosen for.
Purpose = Literal["edge", "find", "both"]
PURPOSES: tuple[Purpose, ...] = get_args(Purpose)


@dataclass(frozen=True)
class Travel:
    """How long a site takes.

    Attributes
    ----------
    speed : float
        Of the probe between sites [m/s].
    at_site : float
        Time that every site takes, however near: up, down, settling, dwell [s].
    """

    speed: float = 0.04
    at_site: float = 0.5

    def __post_init__(self) -> None:
        if not (0.0 < self.speed < math.inf and 0.0 < self.at_site < math.inf):
            raise ParameterError(
                f"a speed of {self.speed} m/s and {self.at_site} s at a site: both must be "
                "positive and finite"
            )


#: That of the scan node, as its settings are without being told.
USUAL_TRAVEL = Travel()


@dataclass(frozen=True)
class NextSite:
    """A site to probe.

    Attributes
    ----------
    x, y : float
        Its place [m].
    gain : float
        By how much it is expected to reduce the area in doubt, after those before it [m^2].
    purpose : str
        What it is chosen for: ``again`` beside a site that may have slipped, ``edge`` by its gain,
        ``find`` for an inclusion that no site has felt.
    """

    x: float
    y: float
    gain: float
    purpose: str

    @property
    def why(self) -> str:
        """What it is chosen for, in words."""
        return _WHY[self.purpose]


def next_sites(
    sampled: Sampled,
    count: int,
    within: Polygon,
    *,
    no_go: Sequence[Polygon] = (),
    start: tuple[float, float] | None = None,
    pending: Sequence[tuple[float, float]] = (),
    unreachable: Sequence[tuple[float, float]] = (),
    travel: Travel = USUAL_TRAVEL,
    purpose: Purpose = "both",
) -> list[NextSite]:
    """Return the next sites, in their order.

    Parameters
    ----------
    sampled : Sampled
        The posterior of the sites so far, drawn with the same ``within``.
    count : int
        How many sites, at least 1.
    within : Polygon
        The area in question; no site is outside it.
    no_go : sequence of Polygon
        Where no site may be; inclusions may.
    start : (float, float), optional
        Where the probe is [m]; by default the way to the first site counts nothing.
    pending : sequence of (float, float)
        Sites that are decided and not felt yet [m].
    unreachable : sequence of (float, float)
        Places that the robot did not reach [m]: what is nearer to them than a tip is not tried.
    travel : Travel
        How long a site takes.
    purpose : str
        What sites are chosen for: ``edge``, ``find``, or ``both`` in turn.

    Raises
    ------
    ParameterError
        If ``count`` is out of its range, ``purpose`` is none of these, or no place is left.
    """
    if purpose not in PURPOSES:
        raise ParameterError(f"purpose is {purpose!r}; give one of {', '.join(PURPOSES)}")
    if not 1 <= count <= MOST_AT_ONCE:
        raise ParameterError(f"next is {count}; give a number of sites from 1 to {MOST_AT_ONCE}")
    x, y = _candidates(sampled, within, no_go, unreachable)
    given = _MM * np.array(pending, dtype=float).reshape(-1, 2)
    again = _choose_again(sampled, np.column_stack([x, y]), given)
    x, y = np.append(x, given[:, 0]), np.append(y, given[:, 1])
    candidates = x.size - len(given)
    question = _QuestionDeviations.of(sampled, within, x, y)
    begun = sampled.felt.x.size + len(given)
    turns = [
        purpose == "find" or (purpose == "both" and n % 2) for n in range(begun, begun + count)
    ]
    turns[: len(again)] = [False] * len(turns[: len(again)])
    unseen = Unseen(sampled, x, y, question.noise) if any(turns) else None
    asked: list[_QuestionDeviations | Unseen] = [question, unseen] if unseen else [question]
    for i in range(candidates, x.size):
        for one in asked:
            one.answer(i)
    here = None if start is None else _MM * np.array(start, dtype=float)
    if len(given):
        here = given[-1]
    chosen: list[NextSite] = []
    for to_find in turns:
        gains = question.gains()[:candidates]
        worth, what = gains, "edge"
        if again:
            worth, what = (np.arange(candidates) == again.pop(0)).astype(float), "again"
        elif unseen and to_find:
            finds = unseen.probabilities()[:candidates]
            if finds.max() >= _LEAST_FOUND:
                worth, what = finds, "find"
        best = _soonest(worth, x[:candidates], y[:candidates], here, travel)
        place = float(x[best]) / _MM, float(y[best]) / _MM
        chosen.append(NextSite(*place, float(gains[best]) / _MM**2, what))
        here = np.array([x[best], y[best]])
        for one in asked:
            one.answer(best)
    return chosen


def _soonest(
    worth: FloatArray, x: FloatArray, y: FloatArray, here: FloatArray | None, travel: Travel
) -> int:
    """Return which place [mm], of those that are worth as much as any, is worth most per second."""
    seconds = np.full(x.size, travel.at_site)
    if here is not None:
        seconds += np.hypot(x - here[0], y - here[1]) / (_MM * travel.speed)
    as_good = worth >= (1.0 - _TOLD_APART) * worth.max()
    return int(np.where(as_good, worth / seconds, -1.0).argmax())


def _choose_again(sampled: Sampled, places: FloatArray, given: FloatArray) -> list[int]:
    """Return the candidates that are nearest to where doubted sites are to be palpated again.

    A doubt that a decided site answers is left out.
    """
    found, reach = [], ASIDE * sampled.domain.spacing
    for doubt in sampled.doubts:
        there = np.array([doubt.x, doubt.y])
        away = np.hypot(*(places - there).T)
        decided = len(given) and np.hypot(*(given - there).T).min() < 2.0 * reach
        if not decided and away.min() < 2.0 * reach:
            found.append(int(away.argmin()))
    return found


class _QuestionDeviations:
    """The deviations of the states in what is in question, and in what sites would feel.

    ``inside`` has shape (states, places), ``felt`` (states, sites); both less their means.
    ``noise`` is the variance of background and noise at each site in a state, on average.
    """

    def __init__(self, inside: FloatArray, felt: FloatArray, noise: FloatArray, cell: float):
        self._inside, self._felt, self.noise, self._cell = inside, felt, noise, cell

    @staticmethod
    def of(sampled: Sampled, within: Polygon, x: FloatArray, y: FloatArray) -> _QuestionDeviations:
        rows, count, level, kinds = sampled.states.some(_CHOICE_STATES)
        px, py, step = spread(within, _PLACES)
        inside = inside_each(rows, count, _MM * px, _MM * py)
        felt, noise = _expect_background(sampled, rows, count, level, kinds, x, y)
        return _QuestionDeviations(
            (inside - inside.mean(axis=0)).astype(np.float32),
            (felt - felt.mean(axis=0)).astype(np.float32),
            noise.astype(np.float32),
            (_MM * step) ** 2,
        )

    def gains(self) -> FloatArray:
        """Return the gain of each site [mm^2]."""
        states = len(self._felt)
        own = (self._felt**2).mean(axis=0) + self.noise
        shared = (self._inside.T @ self._felt) / states
        found: FloatArray = self._cell * (shared**2).sum(axis=0) / own
        return found

    def answer(self, site: int) -> None:
        """Reduce the deviations as the value of a site will."""
        column = self._felt[:, site].copy()
        spread = float(column @ column) / column.size
        total = spread + float(self.noise[site])
        if not total > 0.0:
            return
        gain = 1.0 / (1.0 + math.sqrt(float(self.noise[site]) / total)) / total / column.size
        for deviations in (self._inside, self._felt):
            deviations -= np.outer(column, gain * (column @ deviations))


def _expect_background(
    sampled: Sampled,
    rows: FloatArray,
    count: IntArray,
    level: IntArray,
    kinds: ErrorKinds,
    x: FloatArray,
    y: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the mean of log k at sites [mm] in each state, and its mean variance in a state."""
    background, log_k = sampled.background, sampled.felt.log_k
    residuals = log_k - np.log(sums_at(rows, count, background.x, background.y))
    middle, variance = background.predict_background(level, kinds, residuals, x, y)
    # A further site is as exact as those before.
    stated = float(np.median(sampled.felt.noise)) ** 2
    levels = background.levels
    alone = [(1.0 - levels.kind(int(one))[0]) * levels.size(int(one)) ** 2 for one in level]
    noise = variance.mean(axis=0) + float(np.mean(alone)) + stated
    return np.log(sums_at(rows, count, x, y)) + middle, noise


def _candidates(
    sampled: Sampled,
    within: Polygon,
    no_go: Sequence[Polygon],
    unreachable: Sequence[tuple[float, float]],
) -> tuple[FloatArray, FloatArray]:
    """Return places where a site may be [mm], those felt before among them."""
    x, y = (_MM * each for each in spread(within, _CANDIDATES)[:2])
    felt = sampled.felt
    again = within.contains(felt.x / _MM, felt.y / _MM)
    x, y = np.append(x, felt.x[again]), np.append(y, felt.y[again])
    allowed = sampled.domain.speaks_of(x, y)
    for zone in no_go:
        allowed &= ~zone.contains(x / _MM, y / _MM)
    for place in unreachable:
        allowed &= np.hypot(x - _MM * place[0], y - _MM * place[1]) >= TIP
    if not allowed.any():
        raise ParameterError("no place is left for a site: all is outside, or no-go")
    return x[allowed], y[allowed]
