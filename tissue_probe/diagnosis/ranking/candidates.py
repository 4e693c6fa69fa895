"""Every effect of the library, added to a fitted model and fitted in its turn.

Contents: the base, all candidates, and starts that one candidate gives another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.diagnosis.evidence.posterior import RIVAL
from tissue_probe.diagnosis.fitting.first_guess import first_guesses
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.input_noise import whiten_input_noise
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import Bar, search
from tissue_probe.diagnosis.fitting.start_in_motion import search_other_starts
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidate import (
    ASTRAY,
    BETTER,
    CoarseLook,
    SoughtEffect,
    best_of,
    is_settled,
)
from tissue_probe.diagnosis.ranking.rules import find_added_effect, in_limit
from tissue_probe.diagnosis.ranking.starts import (
    Values,
    begin_states,
    fit_in_contact,
    from_touch,
    of_first_parts,
    start_values,
)
from tissue_probe.diagnosis.ranking.waves import is_no_fold
from tissue_probe.diagnosis.sharing import in_turns, map_shared
from tissue_probe.errors import MeasurementError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.kinds import TISSUE_EFFECTS

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

#: Squared residual over noise at which a further effect needs no other start.
ENOUGH_RATIO = 1.04

Tell = Callable[[Fit], None]
"""Told a fit as soon as it is found."""


def fit_base(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    begin_at: Mapping[str, float] | None = None,
) -> Fit:
    """Fit a model from its default values, and from the estimates of a first look at the samples.

    A tissue that relaxes is fitted from where relaxation beside a Kelvin-Voigt solid ends, too.

    Parameters
    ----------
    composition : Composition
        The model.
    measurements : sequence of Measurement
        All of one specimen.
    instrument : Instrument
        Constants of the rig with their tolerances.
    begin_at : mapping of str to float, optional
        Values found before, maybe on another specimen: the search begins there, and there with the
        estimates of a first look.

    Raises
    ------
    MeasurementError
        If no start leads to a fit.
    """
    problem = Problem(composition, measurements, instrument)
    guesses = first_guesses(measurements)
    if begin_at:
        guesses = [dict(begin_at), *({**begin_at, **guess} for guess in guesses)]
    else:
        guesses += _search_relaxation(composition, measurements, instrument)
    fits = []
    for guess in guesses:
        values = problem.nominal.copy()
        for index, name in enumerate(problem.runs.names):
            if name in guess and problem.free[index]:
                values[index] = guess[name]
        values = np.clip(values, problem.lower, problem.upper)
        starts = [begun.mean for begun in problem.begin(values)]
        fits.append(search_other_starts(problem, search(problem, values, starts)))
    found = [fit for fit in fits if fit is not None]
    if not found:
        period = measurements[0].sample_period
        files = dict.fromkeys(each.source for each in measurements if each.source)
        where = f"{', '.join(files)}: " if files else ""
        raise MeasurementError(
            f"{where}no fit: the model diverges from every start; check the "
            "force's polarity, and the units, also of the time (a sample every "
            f"{period:.3g} s: t_ms names milliseconds)"
        )
    return whiten_input_noise(best_of(found), instrument)


def _search_relaxation(
    composition: Composition, measurements: Sequence[Measurement], instrument: Instrument
) -> list[dict[str, float]]:
    """Return the values of a tissue's own effects, searched as candidates are."""
    names = TISSUE_EFFECTS[composition.tissue]
    if not names:
        return []
    from tissue_probe.physics.effect_scale import resize_effect
    from tissue_probe.physics.effects import EFFECTS

    own = [resize_effect(EFFECTS[name], composition.scale) for name in names]
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
        The model to fit.
    instrument : Instrument
        Constants of the rig with their tolerances.
    measurements : sequence of Measurement, optional
        The observations to fit to; those of ``fit`` by default.
    held : mapping of str to float, optional
        Values that are not fitted.
    """
    problem = Problem(composition, measurements or fit.measurements, instrument, held)
    values = start_values(problem, fit.named(), None, {})
    if measurements is None:
        return search(problem, values, begin_states(problem, fit, values))
    starts = [begun.mean for begun in problem.begin(values)]
    return search_other_starts(problem, search(problem, values, starts))


def fit_candidates(
    base: Fit,
    effects: Iterable[Effect],
    instrument: Instrument,
    needed: float = np.inf,
    known: Sequence[Fit] = (),
    tell: Tell = lambda fit: None,
) -> list[Fit]:
    """Fit the model with each effect added, in the form of it that fits best.

    Parameters
    ----------
    base : Fit
        The model as it is.
    effects : iterable of Effect
        Effects that may be added; those that cannot be fitted, or act on a part that the rig has
        not, are left out.
    instrument : Instrument
        Constants of the rig with their tolerances.
    needed : float
        The cost that is asked for; searches that will not come near are given up, and those that
        reach it and leave hardly more than noise need no other start.
    known : sequence of Fit
        Fits of other effects: searches are given up that will not come near these either.
    tell : callable
        Told each fit when its search has ended, maybe in a copy of this process, where it must not
        change anything of this one.
    """
    candidates = _begin_candidates(base, forms(base.composition, effects), instrument)
    asked = np.isfinite(needed)
    lowest = min([base.cost, needed, *(fit.cost for fit in known)])
    counts = base.cost - 2.0 * RIVAL if leaves_only_noise(base) else np.inf
    bar = Bar(lowest, noise=base.floor if asked else 0.0, most=counts)
    enough = min(ENOUGH_RATIO * base.floor, needed) if asked else 0.0
    searches = [(each, _report_fits(each.fits(bar, enough), tell)) for each in candidates]
    fits = _run_searches(searches, bar, enough)
    again, alone = _given_up(candidates, fits, [*fits, *known]), Bar()
    fits += _run_searches([(each, each.fits(alone, enough)) for each in again], alone, enough)
    behind = _behind(candidates, fits, bar.cost)
    fits += _run_searches(
        [(each, each.fits_from(other, bar)) for each, other in behind], bar, enough
    )
    possible = (
        fit for fit in fits if np.isfinite(fit.bic) and is_no_fold(fit, find_added_effect(fit))
    )
    told = sorted(possible, key=lambda fit: fit.bic)
    return list(_first_of_each(told).values())


def _begin_candidates(
    base: Fit, forms: Sequence[Effect], instrument: Instrument
) -> list[SoughtEffect]:
    """Return the forms that have a start, those that promise most first."""
    look = CoarseLook.at(base, instrument)
    values: list[Values] = [base.named()]
    if any(form.changes_contact for form in forms):
        values += [*fit_in_contact(base, instrument), *from_touch(base, instrument)]
    if any(form.of_part for form in forms):
        values += of_first_parts(base, instrument)
    candidates = [SoughtEffect(base, form, instrument, look, values) for form in forms]
    for candidate, begun in zip(
        candidates, map_shared(SoughtEffect.begin, candidates), strict=True
    ):
        candidate.begun = begun
    found = [candidate for candidate in candidates if candidate.begun.best]
    return sorted(found, key=lambda candidate: candidate.begun.promise)


def forms(composition: Composition, effects: Iterable[Effect]) -> list[Effect]:
    """Return each form in which effects may be added to a model."""
    return [
        form
        for effect in effects
        if effect.name not in composition.names
        for form in effect.every_form
        if composition.rig.admits(form)
    ]


_Search = tuple[SoughtEffect, Iterator[Fit]]


def _report_fits(fits: Iterator[Fit], tell: Tell) -> Iterator[Fit]:
    """Yield fits, and tell of each."""
    for fit in fits:
        tell(fit)
        yield fit


def _run_searches(searches: Sequence[_Search], bar: Bar, enough: float) -> list[Fit]:
    """Return the fits of searches, and the fits near the best of each that is not enough.

    How far off it is can be told when all have ended: which of them is ahead is chance.
    """
    found = _all(searches)
    lowest = bar.cost
    near = [
        (candidate, candidate.settle_search(fits, bar, lowest))
        for (candidate, _), fits in zip(searches, found, strict=True)
        if fits and fits[-1].cost >= enough and candidate.may_gain(best_of(fits), bar.most, lowest)
    ]
    return [fit for fits in [*found, *_all(near)] for fit in fits]


def _all(searches: Sequence[_Search]) -> list[list[Fit]]:
    """Return the fits of each search, made by turns: the others may soon be ahead of one by far."""
    known = [part for candidate, _ in searches for part in candidate.known]
    return in_turns([fits for _, fits in searches], known)


def _first_of_each(fits: Iterable[Fit]) -> dict[str, Fit]:
    """Return, by its name, the first fit of each effect that was added."""
    first: dict[str, Fit] = {}
    for fit in fits:
        first.setdefault(find_added_effect(fit).name, fit)
    return first


def _given_up(
    candidates: Sequence[SoughtEffect], fits: Sequence[Fit], rivals: Sequence[Fit]
) -> list[SoughtEffect]:
    """Return simpler forms of the best effect whose searches were given up, or went astray.

    Were it not for the other, they might have come as far, and the simpler one is preferred.
    """
    if not fits:
        return []
    best = best_of(rivals)
    astray = ASTRAY * best.cost
    settled = {find_added_effect(fit).name for fit in fits if fit.converged and fit.cost < astray}
    stopped = {find_added_effect(fit).name for fit in fits} - settled
    wanted = stopped.intersection(find_added_effect(best).simpler)
    return [each for each in candidates if each.effect.name in wanted]


def _behind(
    candidates: Sequence[SoughtEffect], fits: Sequence[Fit], lowest: float
) -> list[tuple[SoughtEffect, Fit]]:
    """Return forms of effects that did worse than another form, and the fit of that other form.

    The way to where a tip sticks and slides may lead through friction that only creeps. An effect
    that contains a simpler one has a cost no higher than the simpler one. And a simpler effect has
    a cost no higher than an effect that ended as the simpler one. Where the costs say otherwise,
    the search went astray. A form that leaves noise only is enough, unless a parameter ended at its
    bound: there the form only approximates another one.
    """
    best, found = list(_first_of_each(sorted(fits, key=lambda fit: fit.cost)).values()), []
    for candidate in candidates:
        same = [fit for fit in best if _is_also(candidate.effect, fit)]
        if not same:
            continue
        better = best_of(same)
        if is_settled(better, lowest) and not _at_a_bound(better):
            continue
        own = [fit.cost for fit in fits if fit.composition is candidate.problem.composition]
        if better.cost < BETTER * min(own, default=np.inf):
            found.append((candidate, better))
    return found


def _at_a_bound(fit: Fit) -> bool:
    """Whether a parameter of the added effect ended at a bound."""
    return any(each.name in fit.exhausted for each in find_added_effect(fit).parameters)


def _is_also(effect: Effect, fit: Fit) -> bool:
    """Whether the added effect is this one, in some form, or contained in it, or ended as it."""
    own = find_added_effect(fit)
    return own.name in (effect.name, *effect.simpler) or (
        effect.name in own.simpler and in_limit(fit)
    )
