"""Adding effect after effect until the residual is noise.

Contents: the ladder from the base model to the one that is left, and its verdict.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from tissue_probe.diagnosis.evidence.adequacy import excess_of, leaves_only_noise, removes
from tissue_probe.diagnosis.evidence.conclusion import Ladder, Verdict, conclude_search
from tissue_probe.diagnosis.evidence.posterior import posterior
from tissue_probe.diagnosis.fitting.effort import Effort
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.improvement.moves import Moves, addable
from tissue_probe.diagnosis.improvement.queue import Queue, begin_queue, is_enough
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import Tell, fit_base, fit_candidates
from tissue_probe.diagnosis.ranking.harmonic import better_harmonic
from tissue_probe.diagnosis.ranking.rules import find_added_effect, rank_fits, significant
from tissue_probe.diagnosis.revisions.loop import Revisions
from tissue_probe.diagnosis.revisions.table import OF_BASE, OF_BEST, OF_LAST, OF_SINGLE
from tissue_probe.errors import MeasurementError
from tissue_probe.physics.composition import Composition

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

Progress = Callable[[str], None]
"""Called with the step under way."""

#: Effects in all.
MOST_EFFECTS = 3
#: One of several effects must alone remove this share of the excess over the noise: among the few
#: lines of a steady motion several that alone explain nothing can make up for any.
LEADING = 0.2


def climb(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    library: Mapping[str, Effect],
    begin_at: Mapping[str, float] | None = None,
    given: Collection[str] = (),
    progress: Progress = lambda doing: None,
    tell: Tell = lambda fit: None,
) -> Ladder:
    """Fit a model, and add the missing effects to it.

    Where the best model shows that samples are to be weighed otherwise, the search begins anew
    after all that it asks for.

    Parameters
    ----------
    composition : Composition
        The model to begin with.
    measurements : sequence of Measurement
        All of one specimen.
    instrument : Instrument
        Constants of the rig with their tolerances.
    library : mapping of str to Effect
        The effects that may be added.
    begin_at : mapping of str to float, optional
        Values at which the search for the model itself begins, see ``fit_base``.
    given : collection of str
        Names of revisions that are not made.
    progress : callable
        Called with the step under way; an exception that it raises ends the search.
    tell : callable
        Told the model with each effect alone, as ``fit_candidates`` does.
    """
    progress("the model that is asked about is fitted")
    base = fit_base(composition, measurements, instrument, begin_at)
    revisions, allowed = Revisions(instrument, given), addable(composition, library)
    while True:
        base = revisions.revise_until_settled(base, OF_BASE) or base
        known = revisions.instrument
        progress(f"each of {len(allowed)} effects is added to it")
        ranking = rank_fits(base, fit_candidates(base, allowed.values(), known, tell=tell))
        best = ranking[0] if ranking and significant(base, ranking[0], base) else base
        revised = revisions.revise_until_settled(best, OF_BEST if best is base else OF_SINGLE)
        if revised is None:
            ladder = _from_singles(base, best, ranking, known, library, progress)
            revised = revisions.revise_until_settled(ladder.final, OF_LAST)
        if revised is None:
            return replace(ladder, revisions=tuple(revisions.names))
        base = revisions.of_base(base, revised)


def _from_singles(
    base: Fit,
    best: Fit,
    ranking: list[Fit],
    instrument: Instrument,
    library: Mapping[str, Effect],
    progress: Progress,
) -> Ladder:
    """Return the ladder from a base over the best model of one effect, and the verdict."""
    # Nothing is added to a model that leaves noise: of how much there is, too little is known.
    if best is base or is_enough(base):
        return conclude_search(base, ranking, [])
    leading = [fit for fit in ranking if _leads(base, fit)]
    moves = Moves(base, instrument, library, [find_added_effect(fit).name for fit in leading])
    queue = begin_queue(base, moves, ranking, Effort(base.measurements))
    steps = _steps(queue, best, leading, progress)
    ranking = rank_fits(base, [queue.known[frozenset(fit.composition.names)] for fit in ranking])
    ladder = conclude_search(base, ranking, steps, list(queue.known.values()))
    if not leaves_only_noise(ladder.final):
        return replace(ladder, curtailed=queue.curtailed)
    harmonic = better_harmonic(base, ladder.final, instrument) if ladder.steps else None
    return ladder if harmonic is None else replace(ladder, harmonic=harmonic, verdict="unexplained")


def _steps(queue: Queue, single: Fit, leading: list[Fit], progress: Progress) -> list[Fit]:
    """Return the models that are accepted one after the other, each of one effect more.

    Where none leads, no two effects are accepted; and no third one is sought for a residual that is
    hardly more than noise.
    """
    steps, sources = [single], rank_fits(queue.base, leading)
    for count in range(2, MOST_EFFECTS + 1):
        if is_enough(steps[-1]) or (count > 2 and excess_of(steps[-1]) <= 1.0):
            break
        names = steps[-1].composition.names[len(queue.base.composition.names) :]
        progress(f"further effects are sought beside {', '.join(names)}")
        queue.seek(sources, count)
        best = queue.best(count)
        if best is None or not (
            significant(steps[-1], best, queue.base) and removes(steps[-1], best)
        ):
            break
        steps, sources = [*steps, best], [best]
    return steps


def climb_by(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    wanted: Sequence[Effect],
    begin_at: Mapping[str, float] | None = None,
    given: Collection[str] = (),
) -> Ladder:
    """Fit a model, and add the effects that are asked for, in turn; else as ``climb``.

    Raises
    ------
    MeasurementError
        If one of them cannot be fitted.
    """
    base = fit_base(composition, measurements, instrument, begin_at)
    revisions = Revisions(instrument, given)
    while True:
        steps = _asked_for(base, wanted, revisions.instrument)
        revised = revisions.revise_until_settled([base, *steps][-1], OF_LAST)
        if revised is None:
            break
        base = revisions.of_base(base, revised)
    verdict: Verdict = "missing" if significant(base, steps[-1], base) else "adequate"
    if not leaves_only_noise(steps[-1]):
        verdict = "unexplained"
    every, names = tuple(steps), tuple(revisions.names)
    known = posterior(base, every)
    return Ladder(base, every[:1], every, every, known, verdict, asked=True, revisions=names)


def _asked_for(base: Fit, wanted: Sequence[Effect], instrument: Instrument) -> list[Fit]:
    """Return the model with each effect more, in turn."""
    steps: list[Fit] = []
    for effect in wanted:
        found = fit_candidates([base, *steps][-1], [effect], instrument)
        if not found:
            raise MeasurementError(
                f"{effect.name} cannot be fitted to these measurements of a {base.composition.rig}"
            )
        steps += found
    return steps


def _leads(base: Fit, alone: Fit) -> bool:
    """Whether an effect alone removes a good part of the excess over the noise."""
    return base.ratio**2 - alone.ratio**2 > LEADING * (base.ratio**2 - 1.0)
