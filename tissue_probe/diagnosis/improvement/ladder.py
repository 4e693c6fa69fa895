"""Adding effect after effect until the residual is noise.

What belongs here: the ladder from the base model to the one that is left, and its verdict.
What does not: which models are tried on the way (``paths``), comparing models (``ranking``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from tissue_probe.diagnosis.evidence.adequacy import beyond_doubt, doubtful, excess_of
from tissue_probe.diagnosis.evidence.conclusion import Ladder, Verdict, concluded
from tissue_probe.diagnosis.evidence.posterior import posterior
from tissue_probe.diagnosis.fitting.effort import Effort
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.outliers import without_outliers
from tissue_probe.diagnosis.improvement.exchange import anew, exchanged
from tissue_probe.diagnosis.improvement.further import SHARE, Further, addable
from tissue_probe.diagnosis.improvement.paths import begun, beside_each, longest
from tissue_probe.diagnosis.ranking.candidates import Tell, fit_base, fit_candidates, refit
from tissue_probe.diagnosis.ranking.harmonic import better_harmonic
from tissue_probe.diagnosis.ranking.rules import (
    added,
    explained,
    ranked,
    significant,
)
from tissue_probe.errors import MeasurementError
from tissue_probe.physics.composition import Composition

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

Progress = Callable[[str], None]
"""Told what is under way."""

#: Effects in all.
MOST = 3
#: One of two effects must alone remove this share of what exceeds the noise, and the first for a
#: third to be sought: among the few lines of a steady motion several that alone explain nothing can
#: make up for any.
LEADING = 0.2
#: None is tried on an effect that alone leaves this many times the best's cost.
BEHIND = 25.0
#: How often outliers are left out: those of the first effect, and of what came of it.
ROUNDS = 3


def climb(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    library: Mapping[str, Effect],
    begin_at: Mapping[str, float] | None = None,
    rounds: int = ROUNDS,
    progress: Progress = lambda doing: None,
    tell: Tell = lambda fit: None,
) -> Ladder:
    """Fit a model, and add to it what is missing.

    Where outliers are left, all is done once more without them.

    Parameters
    ----------
    composition : Composition
        The model to begin with.
    measurements : sequence of Measurement
        All of one specimen.
    instrument : Instrument
        What is known of the rig.
    library : mapping of str to Effect
        What may be added.
    begin_at : mapping of str to float, optional
        Values at which the search for the model itself begins, see ``fit_base``.
    rounds : int
        How often outliers are left out at the most.
    progress : callable
        Told what is under way; an exception that it raises ends the search.
    tell : callable
        Told the model with each effect alone, as ``fit_candidates`` does.
    """
    progress("the model that is asked about is fitted")
    base = fit_base(composition, measurements, instrument, begin_at)
    allowed = addable(composition, library).values()
    progress(f"each of {len(allowed)} effects is added to it")
    ranking = ranked(fit_candidates(base, allowed, instrument, tell=tell))
    best_so_far = ranking[0] if ranking and significant(base, ranking[0]) else base
    if kept := _rest(best_so_far, rounds):
        return climb(composition, kept, instrument, library, begin_at, rounds - 1, progress, tell)
    # Nothing is added to a model that leaves noise: of how much there is, too little is known.
    adequate = explained(base) and not doubtful(base)
    if adequate or not ranking or not significant(base, ranking[0]):
        return concluded(base, ranking, [])
    near = [fit for fit in ranking if fit.cost < BEHIND * ranking[0].cost]
    leading = [fit for fit in near if _leads(base, fit)]
    paths = begun([fit for fit in near if significant(base, fit)])
    effort, curtailed = Effort(measurements), False
    further = Further(base, instrument, library, [added(fit).name for fit in leading], effort)
    best = paths[0]
    # Where none leads, no two effects are accepted.
    while leading and (not explained(best[-1]) or doubtful(best[-1])) and _is_worth(base, best):
        progress(f"further effects are sought beside {', '.join(_names(best[-1], base))}")
        with effort.counted():
            longer = longest(further, paths, ranking, leading)
            curtailed |= further.is_spent()
            if not longer or not _removes(best[-1], longer[-1]):
                break
            longer = tuple(exchanged(longer, ranking, further))
            if not further.is_spent(longer[-1]):
                longer = beside_each(longer, ranking, leading, further)
        if not any(_leads(base, fit) for fit in _alone(longer[-1], ranking)):
            break
        best, paths = longer, [longer]
    if kept := _rest(best[-1], rounds):
        return climb(composition, kept, instrument, library, begin_at, rounds - 1, progress, tell)
    steps = _needed(best, further)
    if len(steps) < len(best):  # beside what is no more there another form may have been the better
        steps = exchanged(steps, ranking, further)
    if len(steps) == 1:
        ranking = _bettered(ranking, steps[0])
    ladder = concluded(base, ranking, steps, list(further.tried.values()))
    if not explained(ladder.final):
        return replace(ladder, curtailed=curtailed)
    harmonic = better_harmonic(base, ladder.final, instrument) if ladder.steps else None
    return ladder if harmonic is None else replace(ladder, harmonic=harmonic, verdict="unexplained")


def _names(fit: Fit, base: Fit) -> tuple[str, ...]:
    """Return the names of the effects that a model has beside the base."""
    return fit.composition.names[len(base.composition.names) :]


def _rest(fit: Fit, rounds: int) -> list[Measurement] | None:
    """Return what was fitted without its outliers, where anything else than noise is left."""
    return None if explained(fit) or rounds == 0 else without_outliers(fit)


def climb_by(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    wanted: Sequence[Effect],
    begin_at: Mapping[str, float] | None = None,
    rounds: int = ROUNDS,
) -> Ladder:
    """Fit a model, and add the effects that are asked for, in turn; else as ``climb``.

    Raises
    ------
    MeasurementError
        If one of them cannot be fitted.
    """
    base = fit_base(composition, measurements, instrument, begin_at)
    steps: list[Fit] = []
    for effect in wanted:
        found = fit_candidates([base, *steps][-1], [effect], instrument)
        if not found:
            raise MeasurementError(
                f"{effect.name} cannot be fitted to these measurements of a {composition.rig}"
            )
        steps += found
    if kept := _rest([base, *steps][-1], rounds):
        return climb_by(composition, kept, instrument, wanted, begin_at, rounds - 1)
    verdict: Verdict = "missing" if significant(base, steps[-1]) else "adequate"
    if not explained(steps[-1]):
        verdict = "unexplained"
    every = tuple(steps)
    return Ladder(base, every[:1], every, every, posterior(base, every), verdict, asked=True)


def _bettered(ranking: Sequence[Fit], found: Fit) -> list[Fit]:
    """Put a fit in the place of a worse one with the same effect: a longer path led to it."""
    others = [fit for fit in ranking if added(fit).name != added(found).name]
    known = [fit for fit in ranking if added(fit).name == added(found).name]
    return ranked([min([found, *known], key=lambda fit: fit.cost), *others])


def _is_worth(base: Fit, path: Sequence[Fit]) -> bool:
    """Whether one more effect is sought: no third one for a rest that is no more than noise."""
    if len(path) == 1:
        return True
    return len(path) < MOST and excess_of(path[-1]) > 1.0 and _leads(base, path[0])


def _leads(base: Fit, alone: Fit) -> bool:
    """Whether an effect alone removes a good part of what exceeds the noise."""
    return base.ratio**2 - alone.ratio**2 > LEADING * (base.ratio**2 - 1.0)


def _alone(fit: Fit, ranking: Sequence[Fit]) -> list[Fit]:
    """Return what was found of each of a model's effects alone, and of what they contain."""
    contained = {name for effect in fit.composition.effects for name in effect.simpler}
    names = contained.union(fit.composition.names)
    return [alone for alone in ranking if added(alone).name in names]


def _removes(fit: Fit, better: Fit) -> bool:
    """Whether a further effect removes most of what exceeds the noise, or leaves only noise.

    How much noise there is, is estimated: less may be left of what is no noise than it seems.
    """
    excess, left = fit.ratio**2 - 1.0, better.ratio**2 - 1.0
    enough = left < (1.0 - SHARE) * excess or (beyond_doubt(better) and not explained(fit))
    return significant(fit, better) and enough


def _needed(path: Sequence[Fit], further: Further) -> list[Fit]:
    """Drop what became superfluous: an effect that the last model does without.

    Without an earlier one the others may have been found badly; they are searched once more. And
    the last may only have led the others to where they explain as much without it.
    """
    steps = list(path)
    for fit in path[:-1]:
        without = _without(steps[-1], added(fit), further)
        if without is not None and fit is not path[0]:
            without = anew((path[0], without), further)[-1]
        if without is not None and not significant(without, steps[-1]):
            steps = [step for step in steps[:-1] if step is not fit]
            steps = [*steps, without]
    if len(steps) > 1:
        without = _without(steps[-1], added(steps[-1]), further)
        if without is not None and not significant(without, steps[-1]):
            steps = [*steps[:-2], without]
    return steps


def _without(fit: Fit, effect: Effect, further: Further) -> Fit | None:
    """Fit a model without one of its effects, from where it is."""
    return refit(fit, fit.composition.without(effect.name), further.instrument)
