"""Every effect of the library, added to a fitted model and fitted in its turn.

What belongs here: which starts are followed, and the search.
What does not: what is proposed to begin with (``starts``), comparing the candidates (``rules``).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tissue_probe.diagnosis.fitting.coloured import whitened
from tissue_probe.diagnosis.fitting.first_guess import first_guesses
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import HOPELESS, Bar, promise, search
from tissue_probe.diagnosis.ranking import rules
from tissue_probe.diagnosis.ranking.rules import added, explained
from tissue_probe.diagnosis.ranking.starts import (
    Values,
    begin_states,
    extent,
    instants,
    pressed_in,
    proposed,
    start_values,
    with_instant,
)
from tissue_probe.diagnosis.sharing import in_turns, mapped
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS, Effect
from tissue_probe.physics.effects.effect import TISSUE_FORCE
from tissue_probe.physics.rigs import admits
from tissue_probe.physics.tissues import TISSUES
from tissue_probe.signals import FloatArray

#: How many of the proposed starts are followed to the end, and up to how much worse a promise.
FOLLOWED, WORSE = 3, 2.0
#: Where even the promise is this many times the best cost, one start is enough.
FAR = 3.0
#: And so it is where an effect of first order promises less than this share.
LEAST_SHARE = 0.004
#: Up to how many times the best cost the values near those found are tried.
ASTRAY = 6.0
#: And below which residual over noise they are not, if all is explained: there is nothing to gain.
CLOSE = 1.01
#: Squared residual over noise at which a further effect needs no other start.
ENOUGH = 1.04
#: Two searches that end within this factor of each other's cost have found the same: no third.
SAME = 1.0005
#: How often the values near those found are tried, if each time lowers the cost to this share.
ROUNDS, BETTER = 3, 0.995
#: Where a further effect gained nothing, those near are searched that promise less than this share.
SURELY = 0.95
#: How often a search that did not settle is taken up again.
ONWARD = 3


def fit_base(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    begin_at: Mapping[str, float] | None = None,
) -> Fit:
    """Fit a model from its default values, and from what a first look at the samples tells.

    A tissue that relaxes is fitted from where relaxation beside a Kelvin-Voigt solid ends, too.

    Parameters
    ----------
    composition : Composition
        The model.
    measurements : sequence of Measurement
        All of one specimen.
    instrument : Instrument
        What is known of the rig.
    begin_at : mapping of str to float, optional
        Values found before, maybe on another specimen: the search begins there, and there with what
        a first look tells.

    Raises
    ------
    ValueError
        If no start leads to a fit.
    """
    problem = Problem(composition, measurements, instrument)
    guesses = first_guesses(measurements)
    if begin_at:
        guesses = [dict(begin_at), *({**begin_at, **guess} for guess in guesses)]
    else:
        guesses += _relaxed(composition, measurements, instrument)
    fits = []
    for guess in guesses:
        values = problem.nominal.copy()
        for index, name in enumerate(problem.runs.names):
            if name in guess and problem.free[index]:
                values[index] = guess[name]
        values = np.clip(values, problem.lower, problem.upper)
        starts = [begun.mean for begun in problem.begin(values)]
        fits.append(search(problem, values, starts))
    found = [fit for fit in fits if fit is not None]
    if not found:
        period = measurements[0].sample_period
        raise ValueError(
            "no fit: the model diverges from every start; check the force's polarity, and the "
            f"units, also of the time (a sample every {period:.3g} s: t_ms names milliseconds)"
        )
    return whitened(min(found, key=lambda fit: fit.cost), instrument)


def _relaxed(
    composition: Composition, measurements: Sequence[Measurement], instrument: Instrument
) -> list[dict[str, float]]:
    """Return what is found of a tissue's own effects when they are searched as candidates are."""
    own = [EFFECTS[name] for name in TISSUES[composition.tissue].effects]
    if not own:
        return []
    solid = fit_base(replace(composition, tissue="kelvin_voigt"), measurements, instrument)
    return [fit.named() for fit in fit_candidates(solid, own, instrument)]


def refit(
    fit: Fit,
    composition: Composition,
    instrument: Instrument,
    measurements: Sequence[Measurement] | None = None,
    held: Mapping[str, float] | None = None,
) -> Fit | None:
    """Fit again from the values of a fit, as far as they are the composition's own.

    Parameters
    ----------
    fit : Fit
        Where to begin.
    composition : Composition
        What to fit.
    instrument : Instrument
        What is known of the rig.
    measurements : sequence of Measurement, optional
        What to fit to; those of ``fit`` by default.
    held : mapping of str to float, optional
        Values that are not fitted.
    """
    problem = Problem(composition, measurements or fit.measurements, instrument, held)
    values = start_values(problem, fit.named(), None, {})
    if measurements is None:
        return search(problem, values, begin_states(problem, fit, values))
    return search(problem, values, [begun.mean for begun in problem.begin(values)])


def fit_candidates(
    base: Fit,
    effects: Iterable[Effect],
    instrument: Instrument,
    needed: float = np.inf,
    known: Sequence[Fit] = (),
) -> list[Fit]:
    """Fit the model with each effect added, in the form of it that fits best.

    Parameters
    ----------
    base : Fit
        The model as it is.
    effects : iterable of Effect
        What may be added; what cannot be fitted, or acts on what the rig has not, is left out.
    instrument : Instrument
        What is known of the rig.
    needed : float
        The cost that is asked for; searches that will not come near are given up, and those that
        reach it and leave hardly more than noise need no other start.
    known : sequence of Fit
        What other effects led to: the searches are given up that will not come near these either.
    """
    all_forms = forms(base.composition, effects)
    look, values = _Look.at(base, instrument), [base.named()]
    if any(form.contact != TISSUE_FORCE for form in all_forms):
        values += pressed_in(base, instrument)
    candidates = [_Candidate(base, form, instrument, look, values) for form in all_forms]
    for candidate, begun in zip(candidates, mapped(_Candidate.begin, candidates), strict=True):
        candidate.begun = begun
    candidates = [candidate for candidate in candidates if candidate.begun.best]
    candidates.sort(key=lambda candidate: candidate.begun.promise)
    asked = np.isfinite(needed)
    lowest = min([base.cost, needed, *(fit.cost for fit in known)])
    counts = (1.0 - rules.LEAST_SHARE) ** 2 * base.cost if explained(base) else np.inf
    bar = Bar(lowest, noise=base.floor if asked else 0.0, most=counts)
    enough = min(ENOUGH * base.floor, needed) if asked else 0.0
    fits = _searched([(each, each.fits(bar, enough)) for each in candidates], bar, enough)
    again, alone = _given_up(candidates, fits, [*fits, *known]), Bar()
    fits += _searched([(each, each.fits(alone, enough)) for each in again], alone, enough)
    behind = _behind(candidates, fits, bar.cost)
    fits += _searched([(each, each.fits_from(other, bar)) for each, other in behind], bar, enough)
    told = sorted((fit for fit in fits if np.isfinite(fit.bic)), key=lambda fit: fit.bic)
    return list(_first_of_each(told).values())


def forms(composition: Composition, effects: Iterable[Effect]) -> list[Effect]:
    """Return each form in which effects may be added to a model."""
    return [
        form
        for effect in effects
        if effect.name not in composition.names
        for form in effect.every_form
        if admits(composition.rig, form)
    ]


def shared(fit: Fit, models: Iterable[Composition]) -> list[object]:
    """Return what fits of models to the same measurements hold, and both processes have.

    The models' code is loaded: what a copy of the process loads is lost with it.
    """
    return [*fit.measurements, *(part for model in models for part in (model, model.kernel))]


_Search = tuple["_Candidate", Iterator[Fit]]


def _searched(searches: Sequence[_Search], bar: Bar, enough: float) -> list[Fit]:
    """Return what searches find, and what is found near the best of each that is not enough.

    How far off it is can be told when all have ended: which of them is ahead is chance.
    """
    found = _all(searches)
    lowest = bar.cost
    near = [
        (candidate, candidate.settled(fits, bar, lowest))
        for (candidate, _), fits in zip(searches, found, strict=True)
        if fits and fits[-1].cost >= enough and candidate.may_gain(_best(fits), bar.most, lowest)
    ]
    return [fit for fits in [*found, *_all(near)] for fit in fits]


def _all(searches: Sequence[_Search]) -> list[list[Fit]]:
    """Return what each search finds, made by turns: the others may soon be ahead of one by far."""
    known = [part for candidate, _ in searches for part in candidate.known]
    return in_turns([fits for _, fits in searches], known)


def _first_of_each(fits: Iterable[Fit]) -> dict[str, Fit]:
    """Return, by its name, the first fit of each effect that was added."""
    first: dict[str, Fit] = {}
    for fit in fits:
        first.setdefault(added(fit).name, fit)
    return first


def _given_up(
    candidates: Sequence[_Candidate], fits: Sequence[Fit], rivals: Sequence[Fit]
) -> list[_Candidate]:
    """Return simpler forms of the best effect whose searches were given up, or went astray.

    Were it not for the other, they might have come as far, and the simpler one is preferred.
    """
    if not fits:
        return []
    best = min(rivals, key=lambda fit: fit.cost)
    astray = ASTRAY * best.cost
    settled = {added(fit).name for fit in fits if fit.converged and fit.cost < astray}
    stopped = {added(fit).name for fit in fits} - settled
    wanted = stopped.intersection(added(best).simpler)
    return [each for each in candidates if each.effect.name in wanted]


def _behind(
    candidates: Sequence[_Candidate], fits: Sequence[Fit], lowest: float
) -> list[tuple[_Candidate, Fit]]:
    """Return forms of effects that did worse than another form, and what that one found.

    The way to where a tip sticks and slides may lead through friction that only creeps. And what
    contains a simpler effect can do no worse than that, nor that worse than what ended as it: it
    went astray.
    """
    best, found = list(_first_of_each(sorted(fits, key=lambda fit: fit.cost)).values()), []
    for candidate in candidates:
        same = [fit for fit in best if _is_also(candidate.effect, fit)]
        if not same or _is_settled(better := _best(same), lowest):
            continue
        own = [fit.cost for fit in fits if fit.composition is candidate.problem.composition]
        if better.cost < BETTER * min(own, default=np.inf):
            found.append((candidate, better))
    return found


def _is_also(effect: Effect, fit: Fit) -> bool:
    """Whether what was added is the effect, in some form, or contained in it, or ended as it."""
    own = added(fit)
    return own.name in (effect.name, *effect.simpler) or (
        effect.name in own.simpler and rules.in_limit(fit)
    )


def _best(fits: Iterable[Fit]) -> Fit:
    return min(fits, key=lambda fit: fit.cost)


def _runs_on(fit: Fit, most: float, lowest: float) -> bool:
    """Whether a search ran out of steps, though what it had come to may count."""
    return not fit.converged and fit.cost <= min(HOPELESS * lowest, most)


def _is_settled(fit: Fit, lowest: float) -> bool:
    """Whether values near those of a fit need not be tried: it is far off, or explains all.

    How much noise there is, is estimated: what leaves clearly more than the lowest does not.
    """
    close = fit.ratio < CLOSE and fit.cost < lowest + rules.TIE
    return fit.cost > ASTRAY * lowest or (explained(fit) and close)


@dataclass(frozen=True)
class _Look:
    """Fewer samples, from which a start's promise is told, and what a cost there is of the whole.

    Most of the time goes into promises, and they only put starts in order.
    """

    measurements: tuple[Measurement, ...]
    scale: float

    @classmethod
    def at(cls, base: Fit, instrument: Instrument) -> _Look:
        """Take no more samples than are needed of each measurement of a fit."""
        few = tuple(each.thinned() for each in base.measurements)
        problem = Problem(base.composition, few, instrument)
        alone = promise(problem, base.values, base.starts)
        if not 0.0 < alone < np.inf:
            return cls(base.measurements, 1.0)
        return cls(few, base.cost / alone)


_Proposal = tuple[float, FloatArray, list[FloatArray]]


@dataclass(frozen=True)
class _Begin:
    """Where a search may begin: what one step promises, values, and states at the start.

    ``best`` are the most promising, in order; ``direct`` says that a strength was among what was
    proposed.
    """

    best: Sequence[_Proposal] = ()
    direct: bool = False

    @property
    def promise(self) -> float:
        """The least cost that any promises."""
        return self.best[0][0]


class _Candidate:
    """One effect, in one form of it, that is sought beside a fitted model."""

    def __init__(
        self,
        base: Fit,
        effect: Effect,
        instrument: Instrument,
        look: _Look,
        values: Sequence[Values],
    ) -> None:
        self.base, self.effect, self.values = base, effect, values
        composition = base.composition.plus(effect)
        self.problem = Problem(composition, base.measurements, instrument)
        #: What fits hold, and every process has.
        self.known = shared(base, [composition])
        exactly = self.problem.kernel.corrects
        self.look = _Look(base.measurements, 1.0) if exactly else look
        self.looked_at = Problem(composition, self.look.measurements, instrument)
        #: To be set before anything is searched; a copy of the process may have found it.
        self.begun = _Begin()

    def begin(self) -> _Begin:
        """Return where the search may begin."""
        begun: list[_Proposal] = []
        pairs = list(proposed(self.base, self.effect, self.values))
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
        return _Begin([each for each in begun[:FOLLOWED] if each[0] <= WORSE * begun[0][0]], direct)

    def _in_each_run(self, proposals: Sequence[_Proposal]) -> list[_Proposal]:
        """Return what promises most where each of several runs has its own instant.

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
            if not promised / SAME < other < promised * SAME:
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
            if costs and begun.promise >= FAR * bar.cost:
                break
            fit = search(self.problem, values, starts, bar)
            if fit is None:
                continue
            yield fit
            if fit.cost < enough:
                return
            own = tuple(values[len(self.base.values) :])
            if any(cost < SAME * fit.cost for other, cost in costs.items() if other != own):
                break
            costs[own] = fit.cost

    def fits_from(self, other: Fit, bar: Bar) -> Iterator[Fit]:
        """Search from where another form of the effect ended."""
        values = start_values(self.problem, other.named(), None, {})
        fit = search(self.problem, values, begin_states(self.problem, other, values), bar)
        if fit is not None:
            yield fit

    def may_gain(self, best: Fit, most: float, lowest: float) -> bool:
        """Whether there is more to be searched near the best that was found."""
        near = bool(self.effect.near) and not _is_settled(best, lowest)
        return near or _runs_on(best, most, lowest)

    def settled(self, found: Sequence[Fit], bar: Bar, lowest: float) -> Iterator[Fit]:
        """Search near the best of what was found while that does better, and then go on.

        ``lowest`` is the lowest cost that any search had reached before.
        """
        found = list(found)
        rounds = ROUNDS * (self.problem.runs.count if instants(self.effect) else 1)
        for _ in range(rounds if self.effect.near else 0):
            best = _best(found)
            if _is_settled(best, lowest):
                break
            for fit in self._around(best, bar):
                found.append(fit)
                yield fit
            if _best(found).cost > BETTER * best.cost:
                break
        yield from self._onward(_best(found), bar, lowest)

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
            named | runs.told_in(number, other)
            for number in range(runs.count if instants(self.effect) else 1)
            for other in self.effect.near(reach, runs.named_in(number, named))
        ]
        lower, upper = self.problem.lower, self.problem.upper
        near = [np.clip(list(named.values()), lower, upper) for named in known]
        gained = best.cost < (1.0 - LEAST_SHARE) * self.base.cost or not bar.noise
        most = np.inf if gained else SURELY * best.cost
        promises = mapped(lambda values: self._promise(values, best.starts), near)
        order = np.argsort(promises, kind="stable")[:2]
        first = [near[index] for index in order if promises[index] < most]
        fits = mapped(
            lambda values: search(self.problem, values, best.starts, bar), first, self.known
        )
        return [fit for fit in fits if fit is not None]
