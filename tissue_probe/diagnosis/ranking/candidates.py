"""Every effect of the library, added to a fitted model and fitted in its turn.

What belongs here: which starts are followed, and the search.
What does not: what is proposed to begin with (``starts``), comparing the candidates (``rules``).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from queue import SimpleQueue

import numpy as np

from tissue_probe.diagnosis.fitting.coloured import whitened
from tissue_probe.diagnosis.fitting.first_guess import first_guesses
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import HOPELESS, Bar, promise, search
from tissue_probe.diagnosis.ranking.rules import added, explained
from tissue_probe.diagnosis.ranking.starts import begin_states, extent, proposed, start_values
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS, Effect
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
#: Two shared cores: compiled code runs beside the interpreter's lock.
THREADS = 2


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
        for index, name in enumerate(problem.kernel.values):
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
    known = fit.named()
    values = np.array([known.get(e.name, e.default) for e in composition.values])
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
    forms = [
        form
        for effect in effects
        if effect.name not in base.composition.names
        for form in effect.every_form
        if admits(base.composition.rig, form)
    ]
    look = _Look.at(base, instrument)
    with ThreadPoolExecutor(THREADS) as pool:
        proposed = list(pool.map(lambda form: _Proposals(base, form, instrument, look), forms))
        proposed = sorted((each for each in proposed if each.best), key=lambda each: each.promise)
        asked = np.isfinite(needed)
        lowest = min([base.cost, needed, *(fit.cost for fit in known)])
        bar = Bar(lowest, noise=base.floor if asked else 0.0)
        enough = min(ENOUGH * base.floor, needed) if asked else 0.0
        fits = _by_turns(pool, [each.fits(bar, enough) for each in proposed])
        again = _given_up(proposed, fits, [*fits, *known])
        fits += _by_turns(pool, [each.fits(Bar(), enough) for each in again])
        behind = _behind(proposed, fits, bar)
        fits += _by_turns(pool, [each.fits_from(better, bar) for each, better in behind])
    told = sorted((fit for fit in fits if np.isfinite(fit.bic)), key=lambda fit: fit.bic)
    return list(_first_of_each(told).values())


def _first_of_each(fits: Iterable[Fit]) -> dict[str, Fit]:
    """Return, by its name, the first fit of each effect that was added."""
    first: dict[str, Fit] = {}
    for fit in fits:
        first.setdefault(added(fit).name, fit)
    return first


def _by_turns(pool: ThreadPoolExecutor, searches: Iterable[Iterator[Fit]]) -> list[Fit]:
    """Advance searches for effects by turns, each to its next fit, until all have ended.

    Before one begins again elsewhere the others have begun, too, and may be ahead of it by far.
    """
    found: list[Fit] = []
    ended: SimpleQueue[tuple[Iterator[Fit], Future[Fit | None]]] = SimpleQueue()

    def advance(each: Iterator[Fit]) -> None:
        future = pool.submit(next, each, None)
        future.add_done_callback(lambda done: ended.put((each, done)))

    running = 0
    for each in searches:
        advance(each)
        running += 1
    while running:
        each, future = ended.get()
        fit = future.result()
        if fit is None:
            running -= 1
        else:
            found.append(fit)
            advance(each)
    return found


def _given_up(
    proposed: Sequence[_Proposals], fits: Sequence[Fit], rivals: Sequence[Fit]
) -> list[_Proposals]:
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
    return [each for each in proposed if each.effect.name in wanted]


def _behind(
    proposed: Sequence[_Proposals], fits: Sequence[Fit], bar: Bar
) -> list[tuple[_Proposals, Fit]]:
    """Return forms of effects that did worse than another form, and what that one found.

    The way to where a tip sticks and slides may lead through friction that only creeps.
    """
    best, found = _first_of_each(sorted(fits, key=lambda fit: fit.cost)), []
    for each in proposed:
        better = best.get(each.effect.name)
        if better is None or _is_settled(better, bar):
            continue
        own = [fit.cost for fit in fits if fit.composition is each.problem.composition]
        if better.cost < BETTER * min(own, default=np.inf):
            found.append((each, better))
    return found


def _is_settled(fit: Fit, bar: Bar) -> bool:
    """Whether values near those of a fit need not be tried: it is far off, or explains all."""
    return fit.cost > ASTRAY * bar.cost or (explained(fit) and fit.ratio < CLOSE)


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


class _Proposals:
    """Where the search for one effect may begin, the most promising first."""

    def __init__(self, base: Fit, effect: Effect, instrument: Instrument, look: _Look) -> None:
        self.effect = effect
        composition = base.composition.plus(effect)
        self.problem = Problem(composition, base.measurements, instrument)
        # What corrects the position does so sample by sample, and the course between them changes.
        own = self.problem.kernel.moves_position or self.problem.kernel.rounded >= 0
        self.look = _Look(base.measurements, 1.0) if own else look
        self.looked_at = Problem(composition, self.look.measurements, instrument)
        proposals: list[_Proposal] = []
        pairs = list(proposed(base, effect, instrument))
        for known, proposal in pairs:
            values = start_values(self.problem, known, effect, proposal)
            if any(np.array_equal(values, other) for _, other, _ in proposals):
                continue
            starts = begin_states(self.problem, base, values)
            proposals.append((self._promise(values, starts), values, starts))
        proposals.sort(key=lambda proposal: proposal[0])
        proposals += self._as_known(proposals[:FOLLOWED])
        proposals.sort(key=lambda proposal: proposal[0])
        self.promise = proposals[0][0] if proposals else np.inf
        self.alone, self.known = base.cost, len(base.values)
        strength = [parameter.name for parameter in effect.parameters[:1]]
        self.direct = any(strength[0] in proposal for _, proposal in pairs if strength)
        self.best = [p for p in proposals[:FOLLOWED] if p[0] <= WORSE * self.promise]

    def _as_known(self, proposals: Sequence[_Proposal]) -> list[_Proposal]:
        """Return the same, but begun at rest or with the coil, whichever is known of the probe.

        A model that lacks an effect starts elsewhere to make up for it, and from there the way to
        the right start may be barred.
        """
        begun = []
        for _, values, _ in proposals:
            known = [begun.mean for begun in self.problem.begin(values)]
            begun.append((self._promise(values, known), values, known))
        return begun

    def _promise(self, values: FloatArray, starts: Sequence[FloatArray]) -> float:
        return self.look.scale * promise(self.looked_at, values, starts)

    def fits(self, bar: Bar, enough: float) -> Iterator[Fit]:
        """Search from the best proposals, and again near what was found, until a cost is enough."""
        near = self.direct or self.promise < (1.0 - LEAST_SHARE) * self.alone
        found: list[Fit] = []
        costs: dict[tuple[float, ...], float] = {}
        for _, values, starts in self.best if near else self.best[:1]:
            if found and self.promise >= FAR * bar.cost:
                break
            fit = search(self.problem, values, starts, bar)
            if fit is None:
                continue
            found.append(fit)
            yield fit
            if fit.cost < enough:
                return
            own = tuple(values[self.known :])
            if any(cost < SAME * fit.cost for begun, cost in costs.items() if begun != own):
                break
            costs[own] = fit.cost
        yield from self._settled(found, bar)

    def fits_from(self, other: Fit, bar: Bar) -> Iterator[Fit]:
        """Search from where another form of the effect ended, and near what is found from there."""
        values = start_values(self.problem, other.named(), None, {})
        fit = search(self.problem, values, begin_states(self.problem, other, values), bar)
        if fit is not None:
            yield fit
            yield from self._settled([fit], bar)

    def _settled(self, found: list[Fit], bar: Bar) -> Iterator[Fit]:
        """Search near the best of what was found while that does better, and then go on."""
        for _ in range(ROUNDS if self.effect.near and found else 0):
            best = min(found, key=lambda fit: fit.cost)
            if _is_settled(best, bar):
                break
            for fit in self._around(best, bar):
                found.append(fit)
                yield fit
            if min(fit.cost for fit in found) > BETTER * best.cost:
                break
        if found:
            yield self._onward(min(found, key=lambda fit: fit.cost), bar)

    def _onward(self, best: Fit, bar: Bar) -> Fit:
        """Go on where the best ran out of steps: a long valley is followed in small ones."""
        for _ in range(ONWARD):
            if best.converged or best.cost > HOPELESS * bar.cost:
                break
            fit = search(self.problem, best.values, best.starts, bar)
            if fit is None or fit.cost > best.cost:
                break
            best = fit
        return best

    def _around(self, best: Fit, bar: Bar) -> list[Fit]:
        """Search again from the two most promising of the values near those found."""
        reach = extent(best, best.named(), self.effect)
        known = [best.named() | dict(each) for each in self.effect.near(reach, best.named())]
        lower, upper = self.problem.lower, self.problem.upper
        near = [np.clip(list(each.values()), lower, upper) for each in known]
        gained = best.cost < (1.0 - LEAST_SHARE) * self.alone or not bar.noise
        most = np.inf if gained else SURELY * best.cost
        with ThreadPoolExecutor(THREADS) as pool:
            promises = list(pool.map(lambda values: self._promise(values, best.starts), near))
            order = np.argsort(promises, kind="stable")[:2]
            first = [near[index] for index in order if promises[index] < most]
            fits = pool.map(lambda values: search(self.problem, values, best.starts, bar), first)
            return [fit for fit in fits if fit is not None]
