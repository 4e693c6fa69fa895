"""One effect, in one form of it, that is sought beside a fitted model.

Contents: which starts are followed, and how far.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.diagnosis.evidence.posterior import RIVAL
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import HOPELESS, Bar, promise, search
from tissue_probe.diagnosis.fitting.start_in_motion import search_other_starts
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.rules import find_added_effect
from tissue_probe.diagnosis.ranking.starts import (
    Values,
    begin_states,
    extent,
    instants,
    propose_starts,
    start_values,
    touches,
    with_instant,
)
from tissue_probe.diagnosis.sharing import map_shared
from tissue_probe.physics.composition import Composition
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

#: How many of the proposed starts are followed to the end, and up to how much worse a promise.
FOLLOWED, WORSE = 3, 2.0
#: Where even the promise is this many times the best cost, one start is enough.
FAR_PROMISE = 3.0
#: And so it is where an effect of first order promises less than this share.
LEAST_SHARE = 0.004
#: Up to how many times the best cost the values near those found are tried.
ASTRAY = 6.0
#: And below which residual over noise they are not, if all is explained: there is nothing to gain.
CLOSE = 1.01
#: Two searches that end within this factor of each other's cost have found the same: no third.
SAME_COST = 1.0005
#: How often the values near those found are tried, if each time lowers the cost to this share.
ROUNDS, BETTER = 3, 0.995
#: Where a further effect gained nothing, those near are searched that promise less than this share.
SURELY = 0.95
#: How often a search that did not settle is taken up again.
ONWARD = 3


def list_shared_objects(fit: Fit, models: Iterable[Composition]) -> list[object]:
    """Return the objects in fits of models to the same measurements that both processes have.

    The models' code is loaded: code that a copy of the process loads is lost with it.
    """
    return [*fit.measurements, *(part for model in models for part in (model, model.kernel))]


def best_of(fits: Iterable[Fit]) -> Fit:
    """Return the fit with the lowest cost."""
    return min(fits, key=lambda fit: fit.cost)


def _runs_on(fit: Fit, most: float, lowest: float) -> bool:
    """Whether a search ran out of steps, though its last cost may count."""
    return not fit.converged and fit.cost <= min(HOPELESS * lowest, most)


def is_settled(fit: Fit, lowest: float) -> bool:
    """Whether values near those of a fit need not be tried: it is far off, or explains all.

    The size of the noise is estimated: a fit that leaves clearly more than the lowest needs a try.
    """
    close = fit.ratio < CLOSE and fit.cost < lowest + 2.0 * RIVAL
    return fit.cost > ASTRAY * lowest or (leaves_only_noise(fit) and close)


@dataclass(frozen=True)
class CoarseLook:
    """Fewer samples, to compute a start's promise, and the factor from their cost to that of all.

    Most of the time goes into promises, and they only put starts in order.
    """

    measurements: tuple[Measurement, ...]
    scale: float

    @classmethod
    def at(cls, base: Fit, instrument: Instrument) -> CoarseLook:
        """Take no more samples than are needed of each measurement of a fit."""
        few = tuple(each.approximate().thin_samples() for each in base.measurements)
        problem = Problem(base.composition, few, instrument)
        alone = promise(problem, base.values, base.starts)
        if not 0.0 < alone < np.inf:
            return cls(base.measurements, 1.0)
        return cls(few, base.cost / alone)


_Proposal = tuple[float, FloatArray, list[FloatArray]]


@dataclass(frozen=True)
class SearchStart:
    """Where a search may begin: the cost that one step promises, values, and states at the start.

    ``best`` are the most promising, in order; ``direct`` says that a strength was among the
    proposed values.
    """

    best: Sequence[_Proposal] = ()
    direct: bool = False

    @property
    def promise(self) -> float:
        """The least cost that any promises."""
        return self.best[0][0]


class SoughtEffect:
    """One effect, in one form of it, that is sought beside a fitted model."""

    def __init__(
        self,
        base: Fit,
        effect: Effect,
        instrument: Instrument,
        look: CoarseLook,
        values: Sequence[Values],
    ) -> None:
        self.base, self.effect, self.values = base, effect, values
        composition = base.composition.plus(effect)
        self.problem = Problem(composition, base.measurements, instrument)
        #: The objects that fits hold, and every process has.
        self.known = list_shared_objects(base, [composition])
        exactly = self.problem.kernel.corrects
        self.look = CoarseLook(base.measurements, 1.0) if exactly else look
        self.looked_at = Problem(composition, self.look.measurements, instrument)
        #: To be set before anything is searched; a copy of the process may have found it.
        self.begun = SearchStart()

    def begin(self) -> SearchStart:
        """Return where the search may begin."""
        begun: list[_Proposal] = []
        pairs = list(propose_starts(self.base, self.effect, self.values))
        for known, proposal in pairs:
            values = start_values(self.problem, known, self.effect, proposal)
            if any(np.array_equal(values, other) for _, other, _ in begun):
                continue
            starts = begin_states(self.problem, self.base, values)
            begun.append((self._promise(values, starts), values, starts))
        begun.sort(key=lambda each: each[0])
        begun += self._in_each_run(begun[:FOLLOWED])
        begun.sort(key=lambda each: each[0])
        begun += self._as_known(begun[:FOLLOWED])
        begun.sort(key=lambda each: each[0])
        strength = [parameter.name for parameter in self.effect.parameters[:1]]
        direct = any(strength[0] in proposal for _, proposal in pairs if strength)
        return SearchStart(
            [each for each in begun[:FOLLOWED] if each[0] <= WORSE * begun[0][0]], direct
        )

    def _in_each_run(self, proposals: Sequence[_Proposal]) -> list[_Proposal]:
        """Return the most promising values where each of several runs has its own instant.

        It is varied in one run after the other.
        """
        runs, begun = self.problem.runs, []
        reach = extent(self.base, self.base.named(), self.effect)
        several = runs.count > 1 and instants(self.effect)
        tried = list(self.effect.starts(reach)) if several else []
        for best in proposals if tried else ():
            for number in range(runs.count):
                named = dict(zip(runs.names, best[1], strict=True))
                for each in tried:
                    values = with_instant(self.problem, named, self.effect, number, each)
                    promised = self._promise(values, best[2])
                    best = min(best, (promised, values, best[2]), key=lambda each: each[0])
            begun.append(best)
        return begun

    def _as_known(self, proposals: Sequence[_Proposal]) -> list[_Proposal]:
        """Return the same, but begun at rest or with the coil, whichever is known of the probe.

        A model that lacks an effect starts elsewhere to make up for it, and from there the way to
        the right start may be barred. Where both promise the same, one step leads from both to one
        place.
        """
        begun = []
        for promised, values, _ in proposals:
            known = [begin.mean for begin in self.problem.begin(values)]
            other = self._promise(values, known)
            if not promised / SAME_COST < other < promised * SAME_COST:
                begun.append((other, values, known))
        return begun

    def _promise(self, values: FloatArray, starts: Sequence[FloatArray]) -> float:
        return self.look.scale * promise(self.looked_at, values, starts)

    def fits(self, bar: Bar, enough: float) -> Iterator[Fit]:
        """Search from the best proposals, until a cost is enough."""
        begun, least = self.begun, (1.0 - LEAST_SHARE) * self.base.cost
        near = begun.direct or begun.promise < least
        costs: dict[tuple[float, ...], float] = {}
        for _, values, starts in begun.best if near else begun.best[:1]:
            if costs and begun.promise >= FAR_PROMISE * bar.cost:
                break
            fit = search_other_starts(self.problem, search(self.problem, values, starts, bar), bar)
            if fit is None:
                continue
            yield fit
            if fit.cost < enough:
                return
            own = tuple(values[len(self.base.values) :])
            if any(cost < SAME_COST * fit.cost for other, cost in costs.items() if other != own):
                break
            costs[own] = fit.cost

    def fits_from(self, other: Fit, bar: Bar) -> Iterator[Fit]:
        """Search from where another form of the effect ended, or one that contains it.

        Strengths begin at those of the other form. Parameters that the other form has not begin
        where one step promises most.
        """
        known = other.named()
        own, its = (
            each.parameters[: each.strengths] for each in (self.effect, find_added_effect(other))
        )
        known |= {
            mine.name: known[theirs.name]
            for mine, theirs in zip(own, its, strict=False)
            if mine.name not in known and mine.unit == theirs.unit
        }
        reach = extent(other, known, self.effect)
        proposals = [
            {name: value for name, value in each.items() if name not in known}
            for each in self.effect.starts(reach)
        ]
        begun = [start_values(self.problem, known | each, None, {}) for each in proposals or [{}]]
        states = [begin_states(self.problem, other, values) for values in begun]
        promises = [self._promise(*each) for each in zip(begun, states, strict=True)]
        best = int(np.argmin(promises))
        fit = search(self.problem, begun[best], states[best], bar)
        if fit is not None:
            yield fit

    def may_gain(self, best: Fit, most: float, lowest: float) -> bool:
        """Whether there is more to be searched near the best that was found."""
        near = self._has_near and not is_settled(best, lowest)
        return near or _runs_on(best, most, lowest)

    def settle_search(self, found: Sequence[Fit], bar: Bar, lowest: float) -> Iterator[Fit]:
        """Search near the best fit found while that does better, and then go on.

        ``lowest`` is the lowest cost that any search had reached before.
        """
        found = list(found)
        rounds = ROUNDS * (self.problem.runs.count if instants(self.effect) else 1)
        for _ in range(rounds if self._has_near else 0):
            best = best_of(found)
            if is_settled(best, lowest):
                break
            for fit in self._around(best, bar):
                found.append(fit)
                yield fit
            if best_of(found).cost > BETTER * best.cost:
                break
        yield from self._onward(best_of(found), bar, lowest)

    @property
    def _has_near(self) -> bool:
        return bool(self.effect.near) or bool(self._touches(self.base))

    def _touches(self, fit: Fit) -> list[Values]:
        lets_go = any(each.changes_contact for each in self.problem.composition.all_effects)
        return touches(self.problem, fit) if lets_go else []

    def _onward(self, best: Fit, bar: Bar, lowest: float) -> Iterator[Fit]:
        """Go on where the best ran out of steps: a long valley is followed in small ones."""
        for _ in range(ONWARD):
            if not _runs_on(best, bar.most, lowest):
                break
            fit = search(self.problem, best.values, best.starts, bar)
            if fit is None or fit.cost > best.cost:
                break
            best = fit
            yield best

    def _around(self, best: Fit, bar: Bar) -> list[Fit]:
        """Search again from the two most promising of the values near those found."""
        runs, named = self.problem.runs, best.named()
        reach = extent(best, named, self.effect)
        known = [
            named | runs.name_among_all(number, other)
            for number in range(runs.count if instants(self.effect) else 1)
            for other in (
                self.effect.near(reach, runs.name_for_run(number, named))
                if self.effect.near
                else ()
            )
        ]
        known += [{**named, **other} for other in self._touches(best)]
        lower, upper = self.problem.lower, self.problem.upper
        near = [np.clip(list(named.values()), lower, upper) for named in known]
        gained = best.cost < (1.0 - LEAST_SHARE) * self.base.cost or not bar.noise
        most = np.inf if gained else SURELY * best.cost
        promises = map_shared(lambda values: self._promise(values, best.starts), near)
        order = np.argsort(promises, kind="stable")[:2]
        first = [near[index] for index in order if promises[index] < most]
        fits = map_shared(
            lambda values: search(self.problem, values, best.starts, bar), first, self.known
        )
        return [fit for fit in fits if fit is not None]
