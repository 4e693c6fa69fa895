"""Adding effect after effect until the residual is noise.

What belongs here: the ladder from the base model to the one that is left, and its verdict.
What does not: which models are tried on the way (``queue``), comparing models (``ranking``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from tissue_probe.diagnosis.evidence.adequacy import excess_of, explained, is_quiet, removes
from tissue_probe.diagnosis.evidence.conclusion import Ladder, Verdict, concluded
from tissue_probe.diagnosis.evidence.posterior import posterior
from tissue_probe.diagnosis.fitting.corners import without_corners
from tissue_probe.diagnosis.fitting.effort import Effort
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.outliers import without_outliers
from tissue_probe.diagnosis.fitting.shaken import felt_anew
from tissue_probe.diagnosis.fitting.undecided import without_undecided
from tissue_probe.diagnosis.improvement.moves import Moves, addable
from tissue_probe.diagnosis.improvement.queue import Queue, is_enough, queued
from tissue_probe.diagnosis.ranking.candidates import Tell, fit_base, fit_candidates
from tissue_probe.diagnosis.ranking.harmonic import better_harmonic
from tissue_probe.diagnosis.ranking.rules import added, ranked, significant
from tissue_probe.diagnosis.revisions.fineness import finer
from tissue_probe.diagnosis.revisions.noise import louder, quieter
from tissue_probe.errors import MeasurementError
from tissue_probe.physics.composition import Composition

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

Progress = Callable[[str], None]
"""Told what is under way."""
Revised = tuple[str, list[Measurement]]
"""Name of a revision, and the measurements after it."""
Revise = Callable[[Fit, Instrument], list[Measurement] | None]
"""Returns the measurements of a fit, revised; None where there is nothing to revise."""

#: Effects in all.
MOST = 3
#: One of several effects must alone remove this share of what exceeds the noise: among the few
#: lines of a steady motion several that alone explain nothing can make up for any.
LEADING = 0.2
#: How often samples are weighed anew: without corners, without those that hang on the position's
#: noise, without outliers, with less noise or more, and with another motion in a noisy position:
#: each once, and the noise again after them. That they are simulated more finely does not count: it
#: ends by itself.
ROUNDS = 6
#: The revision by which measurements are simulated more finely.
FINENESS = "fineness"


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

    Where the best model shows that samples are to be weighed otherwise, all is done once more.

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
        How often samples are weighed anew at the most.
    progress : callable
        Told what is under way; an exception that it raises ends the search.
    tell : callable
        Told the model with each effect alone, as ``fit_candidates`` does.
    """

    def anew(revision: str, kept: Sequence[Measurement]) -> Ladder:
        left = rounds - (revision != FINENESS)
        ladder = climb(composition, kept, instrument, library, begin_at, left, progress, tell)
        return replace(ladder, revisions=(revision, *ladder.revisions))

    progress("the model that is asked about is fitted")
    base = fit_base(composition, measurements, instrument, begin_at)
    if kept := _first_weighed(base, instrument, rounds):
        return anew(*kept)
    allowed = addable(composition, library)
    progress(f"each of {len(allowed)} effects is added to it")
    ranking = ranked(base, fit_candidates(base, allowed.values(), instrument, tell=tell))
    best = ranking[0] if ranking and significant(base, ranking[0], base) else base
    if kept := _weighed_anew(best, instrument, rounds):
        return anew(*kept)
    # Nothing is added to a model that leaves noise: of how much there is, too little is known.
    if best is base or is_enough(base):
        return concluded(base, ranking, [])
    leading = [fit for fit in ranking if _leads(base, fit)]
    moves = Moves(base, instrument, library, [added(fit).name for fit in leading])
    queue = queued(base, moves, ranking, Effort(measurements))
    steps = _steps(queue, best, leading, progress)
    if kept := _weighed_anew(steps[-1], instrument, rounds):
        return anew(*kept)
    ranking = ranked(base, [queue.known[frozenset(fit.composition.names)] for fit in ranking])
    ladder = concluded(base, ranking, steps, list(queue.known.values()))
    if not explained(ladder.final):
        return replace(ladder, curtailed=queue.curtailed)
    harmonic = better_harmonic(base, ladder.final, instrument) if ladder.steps else None
    return ladder if harmonic is None else replace(ladder, harmonic=harmonic, verdict="unexplained")


def _steps(queue: Queue, single: Fit, leading: list[Fit], progress: Progress) -> list[Fit]:
    """Return the models that are accepted one after the other, each of one effect more.

    Where none leads, no two effects are accepted; and no third one is sought for a residual that is
    hardly more than noise.
    """
    steps, sources = [single], ranked(queue.base, leading)
    for count in range(2, MOST + 1):
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


def _first_weighed(base: Fit, instrument: Instrument, rounds: int) -> Revised | None:
    """Return the measurements as the model that is asked about shows that they are to be weighed.

    There is no more noise than it leaves, also where it lacks an effect; and corners of the motion
    tell wrong values of a model that explains them, too.
    """
    revisions: list[tuple[str, Revise]] = []
    if rounds and is_quiet(base) and not explained(base):
        revisions.append(("quieter", partial(quieter, least=True)))
    if rounds:
        revisions.append(("corners", _corners))
    return _first_of(base, instrument, [*revisions, (FINENESS, finer)])


def _weighed_anew(fit: Fit, instrument: Instrument, rounds: int) -> Revised | None:
    """Return the measurements of the best model as it shows that they are to be weighed.

    None where it leaves noise only and is simulated finely enough, where it shows nothing, or after
    so many rounds.
    """
    revisions: list[tuple[str, Revise]] = [(FINENESS, finer)]
    if rounds and not explained(fit):
        # The noise first: by it outliers are told, and where more is counted there are none.
        revisions += [
            ("quieter", quieter) if is_quiet(fit) else ("louder", louder),
            ("motion", felt_anew),
            ("undecided", without_undecided),
            ("outliers", _outliers),
        ]
    return _first_of(fit, instrument, revisions)


def _first_of(
    fit: Fit, instrument: Instrument, revisions: Sequence[tuple[str, Revise]]
) -> Revised | None:
    """Return the first revision for which the fit gives a reason."""
    told = ((name, revise(fit, instrument)) for name, revise in revisions)
    return next(((name, kept) for name, kept in told if kept), None)


def _corners(fit: Fit, _: Instrument) -> list[Measurement] | None:
    return without_corners(fit)


def _outliers(fit: Fit, _: Instrument) -> list[Measurement] | None:
    return without_outliers(fit)


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
    if kept := _weighed_anew([base, *steps][-1], instrument, rounds):
        revision, samples = kept
        left = rounds - (revision != FINENESS)
        ladder = climb_by(composition, samples, instrument, wanted, begin_at, left)
        return replace(ladder, revisions=(revision, *ladder.revisions))
    verdict: Verdict = "missing" if significant(base, steps[-1], base) else "adequate"
    if not explained(steps[-1]):
        verdict = "unexplained"
    every = tuple(steps)
    return Ladder(base, every[:1], every, every, posterior(base, every), verdict, asked=True)


def _leads(base: Fit, alone: Fit) -> bool:
    """Whether an effect alone removes a good part of what exceeds the noise."""
    return base.ratio**2 - alone.ratio**2 > LEADING * (base.ratio**2 - 1.0)
