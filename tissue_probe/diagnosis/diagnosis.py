"""From measurements to a verdict: inspect, climb the ladder, prove on held-out data, advise.

What belongs here: the order of the steps. What does not: the steps.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from threadpoolctl import threadpool_limits

from tissue_probe.diagnosis import instrument_values
from tissue_probe.diagnosis.advice.driver_command import DriverCommand, driver_command
from tissue_probe.diagnosis.advice.separation import Suggestion, suggest
from tissue_probe.diagnosis.advice.visibility import unseen
from tissue_probe.diagnosis.cleaning import SPOILT, cleaned, from_touch
from tissue_probe.diagnosis.evidence.adequacy import explained, is_quiet
from tissue_probe.diagnosis.evidence.conclusion import Ladder, Verdict, concluded
from tissue_probe.diagnosis.fit_checks import check_fit, check_held_out
from tissue_probe.diagnosis.fitting.accuracy import widened
from tissue_probe.diagnosis.fitting.coloured import filtered, with_input_noise
from tissue_probe.diagnosis.fitting.corners import without_corners
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.outliers import without_outliers
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.undecided import without_undecided
from tissue_probe.diagnosis.improvement.ladder import ROUNDS, Progress, climb, climb_by
from tissue_probe.diagnosis.improvement.moves import addable
from tissue_probe.diagnosis.input_course import COURSE, told, told_anew
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.instrument_values import InstrumentValue
from tissue_probe.diagnosis.left_out import left_out
from tissue_probe.diagnosis.prepared import prepared
from tissue_probe.diagnosis.ranking.candidates import Tell, fit_base, fit_candidates
from tissue_probe.diagnosis.ranking.carried import carried, of_specimen
from tissue_probe.diagnosis.ranking.rules import added, ranked, significant
from tissue_probe.diagnosis.ranking.screen import Promise, screened
from tissue_probe.diagnosis.revisions.noise import quieter
from tissue_probe.diagnosis.sizing import library_of_size, of_size, sized, told_of_size
from tissue_probe.errors import MeasurementError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.response import Fineness
from tissue_probe.quantities import FORCE
from tissue_probe.signals import FloatArray, IntArray

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect
    from tissue_probe.physics.rigs import Rig

#: Where the search for a further effect came to its limit, and something is left unexplained.
CURTAILED = Finding(
    "curtailed",
    "Not every further effect was tried beside every other: the search came to its limit. If you "
    "suspect some, add them by name (`add` of improve).",
)
#: Where a model leaves less than the 1/f noise that is usual of the load cell.
QUIET = Finding(
    "quiet",
    "The 1/f noise that is usual of the paper's load cell is not in this recording: none is "
    "counted as noise.",
)
#: Where the residual on a second recording is rougher than the noise of the first.
NOISIER = (
    "The noise of the second recording is {:.2g} times that of the first: the sensor, its wiring "
    "or its range may be another."
)
#: Where a finer simulation would change the values, and no finer one is possible.
COARSE = (
    "The samples are too few to simulate the model as finely as its values are known: the "
    "intervals are wider by the error that this may leave. Sample more often."
)
#: Models that are less probable than this are not tried on a second recording: its error would have
#: to be smaller by what no noise hides.
POSSIBLE = 1e-4
#: How many of the ranking are tried on a second recording.
VALIDATED = 8
#: A model does not carry over that leaves this many times what it should on a second recording.
FAR = 1.5


@dataclass(frozen=True)
class Diagnosis:
    """What is missing in a model, and how sure that is.

    Attributes
    ----------
    verdict : str
        "adequate", "missing", "ambiguous" or "unexplained".
    ladder : Ladder
        The models that were tried, and those accepted.
    spoilt : tuple of str
        ``adc_saturation``, ``stuck_samples``: what is wrong with samples, which were left out.
    findings : tuple of Finding
        Of reading and of the inspection, on all measurements, also what validates; of the fit.
    indistinguishable : tuple of str
        Effects by which models differ that explain the measurement equally well
        (``ladder.rivals``); empty where one is alone.
    unseen : tuple of str
        Effects of typical strength that this measurement could not have shown, beside those added;
        none where something is left unexplained.
    suggestion : Suggestion or None
        What would separate the indistinguishable, or show the unseen.
    validated : mapping of tuple of str to float
        Error [unit of the output] on the validating recordings by the names of a model's effects.
    seconds : float
        Time that it took.
    validation_noise : float
        Noise on the validating recordings, rms: white, and that which errors of the position make;
        NaN without.
    command : DriverCommand or None
        What runs the suggested experiment.
    uncertainty : float
        Error that the last model's values, known as roughly as they are, leave on the validating
        recordings; 0 without.
    revisions : tuple of str
        Names of all revisions of the samples and of their weights, in their order: "colour" of a
        driving force's noise, "course" of the input between samples and "flicker" for 1/f noise
        that is not there, beside those of each ladder.
    instrument : tuple of InstrumentValue
        Values of the last model that belong to the instrument, not to the tissue.
    """

    verdict: Verdict
    ladder: Ladder
    spoilt: tuple[str, ...]
    findings: tuple[Finding, ...]
    indistinguishable: tuple[str, ...]
    unseen: tuple[str, ...]
    suggestion: Suggestion | None
    validated: Mapping[tuple[str, ...], float]
    seconds: float
    validation_noise: float = math.nan
    command: DriverCommand | None = None
    uncertainty: float = 0.0
    revisions: tuple[str, ...] = ()
    instrument: tuple[InstrumentValue, ...] = ()

    @property
    def carries_over(self) -> bool:
        """Whether the last model errs on the validating recordings no more than it should.

        That is about as on those fitted, and as its values' uncertainty leaves besides.
        """
        final = self.ladder.final
        expected = math.hypot(self.validation_noise, final.excess, self.uncertainty)
        return not self.heldout(final) > FAR * expected

    @property
    def fails_elsewhere(self) -> bool:
        """Whether the last model explains the measurements, and not the validating ones."""
        return self.verdict == "unexplained" and self.ladder.verdict in ("adequate", "missing")

    @property
    def reaches(self) -> bool:
        """Whether the recordings fitted tell the last model's values well enough for the others."""
        known = math.hypot(self.validation_noise, self.ladder.final.excess)
        return not self.uncertainty > FAR * known

    @property
    def effects(self) -> tuple[str, ...]:
        """What is missing, in the order in which it is added."""
        return (*self.spoilt, *self.ladder.effects)

    def heldout(self, fit: Fit) -> float:
        """Error of a model on what it was not fitted to: a second recording, or blocks."""
        return self.validated.get(fit.composition.names, fit.heldout_rmse)


# The searches have threads of their own: those of linear algebra would wait for one another.
@threadpool_limits.wrap(limits=1)
def diagnose(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    library: Mapping[str, Effect],
    validation: Sequence[Measurement] = (),
    wanted: Sequence[str] = (),
    begin_at: Mapping[str, float] | None = None,
    progress: Progress = lambda doing: None,
    tell: Tell = lambda fit: None,
) -> Diagnosis:
    """Say what a model misses.

    Parameters
    ----------
    composition : Composition
        The model that is asked about.
    measurements : sequence of Measurement
        Of one specimen; fitted together.
    instrument : Instrument
        What is known of the rig.
    library : mapping of str to Effect
        What may be missing.
    validation : sequence of Measurement
        Other recordings of the same specimen, on which models are tried and not fitted.
    wanted : sequence of str
        Effects to be added in this order, whether they are missing or not.
    begin_at : mapping of str to float, optional
        Values of the model, found before, at which the search for it begins.
    progress : callable
        Told what is under way; an exception that it raises ends the diagnosis.
    tell : callable
        Told the model with each effect alone, as ``climb`` does.

    Raises
    ------
    MeasurementError
        If any samples are such that a fit would be worthless, or the rig has nothing that a
        wanted effect acts on; says why and what to do.
    """
    begun = time.perf_counter()
    composition, measurements, instrument = sized(composition, measurements, instrument)
    library = library_of_size(library, composition.scale, wanted)
    asked_for = [library[name] for name in wanted]
    if any(effect.zero for effect in asked_for):
        instrument = replace(instrument, any_zero=False)
    clean, instrument, findings = prepared(composition, measurements, instrument, begin_at)
    library = _admitted(composition, library, clean, instrument)
    _refuse(composition.rig, asked_for)
    spoilt = tuple(name for name in SPOILT if any(f.name == name for f in findings))
    read = _as_read([*measurements, *validation])
    findings = [*read, *told_of_size(composition.scale), *findings]
    validation = [of_size(each, composition.scale) for each in validation]
    validation, of_validation = cleaned(validation)
    validation, _, touched = from_touch(validation, instrument)
    findings += [*of_validation, *touched]

    def climbed(samples: Sequence[Measurement], rig: Instrument) -> Ladder:
        if wanted:
            return climb_by(composition, samples, rig, asked_for, begin_at)
        return climb(composition, samples, rig, library, begin_at, ROUNDS, progress, tell)

    taken = clean if wanted else _coloured(composition, clean, instrument, library, begin_at)
    ladder = climbed(taken, instrument)
    revisions = (*(() if taken is clean else ("colour",)), *ladder.revisions)
    known = any(each.between is not None for each in measurements)
    if anew := [] if known else told_anew(ladder.final, instrument):
        course, taken = anew[0].between, anew
        findings = [each for each in findings if each.name != COURSE] + told(course)
        clean = [replace(each, between=course) for each in clean]
        ladder = climbed(taken, instrument)
        revisions += ("course", *ladder.revisions)
    if instrument.flicker_noise and is_quiet(ladder.final) and not wanted:
        instrument = replace(instrument, flicker_noise=0.0)
        findings.append(QUIET)
        ladder = climbed(taken, instrument)
        revisions += ("flicker", *ladder.revisions)
    hidden: tuple[str, ...] = ()
    if ladder.verdict == "adequate":
        hidden = unseen(ladder.final, library, instrument, composition, ladder.ranking)
        # What may hide comes before what would have shown.
        order = sorted(ladder.ranking, key=lambda fit: added(fit).name not in hidden)
        ladder = replace(ladder, ranking=tuple(order))
    ladder, coarse = _as_sure(ladder, instrument)
    findings += coarse
    # As the drive is between samples of the first recording, it is between those of the second.
    fineness = _finest(ladder.final.measurements)
    validation = [replace(each, between=clean[0].between, fineness=fineness) for each in validation]
    if validation:
        progress("the models are tried on the second recording")
        validation = told_by(ladder.final, validation, instrument)
    models = [ladder.base, *ladder.steps, *ladder.ranking[:VALIDATED], *_possible(ladder)]
    moved = {
        fit.composition.names: carried(fit.composition, fit.named(), validation, instrument)
        for fit in models
        if validation
    }
    validated = {names: fit.rmse if fit else math.inf for names, fit in moved.items()}
    # A model that diverges on the second recording is none of those that it may make probable.
    second = {
        frozenset(fit.composition.names): _likelihood(fit, other, instrument)
        for fit in models
        if (other := moved.get(fit.composition.names)) is not None
    }
    if second and not wanted and ladder.harmonic is None:
        again = concluded(ladder.base, ladder.ranking, ladder.steps, ladder.tried, second)
        ladder = replace(again, curtailed=ladder.curtailed, revisions=ladder.revisions)
    indistinguishable = ladder.tied if ladder.alternatives else ()
    if ladder.verdict in ("missing", "ambiguous"):
        hidden = unseen(ladder.final, library, instrument, composition)
    progress("the next experiment is chosen")
    rivals = ladder.rivals if indistinguishable else [ladder.final]
    asked = hidden if ladder.verdict == "adequate" else ()
    suggestion = suggest(rivals, instrument, library, asked)
    findings += left_out(clean, ladder.final, instrument)
    doubts = list(check_fit(ladder.base, ladder.final))
    findings += doubts if doubts or validation else check_held_out(ladder.final)
    findings += [CURTAILED] if ladder.curtailed else []
    findings += _noisier(ladder.final, validation)
    own = instrument_values.instrument_values(ladder.final, instrument)
    findings += instrument_values.findings(own)
    verdict: Verdict = "missing" if spoilt and ladder.verdict == "adequate" else ladder.verdict
    found = Diagnosis(
        verdict, ladder, spoilt, tuple(findings), indistinguishable, hidden, suggestion,
        validated, time.perf_counter() - begun, _noise(validation),
        _command(suggestion, clean),
        _uncertainty(ladder.final, moved.get(ladder.final.composition.names), instrument),
        revisions, own,
    )  # fmt: skip
    # A model that explains one recording of a specimen, and not another, does not explain it.
    fails = verdict in ("adequate", "missing") and not found.carries_over
    return replace(found, verdict="unexplained") if fails else found


def plainly(
    composition: Composition, measurements: Sequence[Measurement], instrument: Instrument
) -> Fit:
    """Fit a model as ``diagnose`` does, and add nothing.

    Raises
    ------
    MeasurementError
        If any samples are such that a fit would be worthless, or no start leads to a fit.
    """
    composition, measurements, instrument = sized(composition, measurements, instrument)
    clean, instrument, _ = prepared(composition, measurements, instrument)
    return climb(composition, clean, instrument, {}).base


# The searches have threads of their own: those of linear algebra would wait for one another.
@threadpool_limits.wrap(limits=1)
def promises(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    library: Mapping[str, Effect],
    begin_at: Mapping[str, float] | None = None,
) -> tuple[Fit, list[Promise], list[Finding]]:
    """Rank effects by a score test, without fitting any: in the time of one fit.

    Returns
    -------
    base : Fit
        The model that is asked about.
    ranking : list of Promise
        What each effect could explain of its residual, to first order, that the model's own values
        cannot; the most first.
    findings : list of Finding
        Of reading and of the inspection.
    """
    composition, measurements, instrument = sized(composition, measurements, instrument)
    library = library_of_size(library, composition.scale)
    clean, instrument, findings = prepared(composition, measurements, instrument, begin_at)
    base = fit_base(composition, clean, instrument, begin_at)
    admitted = _admitted(composition, library, clean, instrument)
    allowed = addable(composition, admitted).values()
    (ranking,) = screened([(base, allowed)], composition, instrument)
    return base, ranking, [*_as_read(measurements), *told_of_size(composition.scale), *findings]


def _admitted(
    composition: Composition,
    library: Mapping[str, Effect],
    measurements: Sequence[Measurement],
    instrument: Instrument,
) -> dict[str, Effect]:
    """Return the effects that act on something that the rig has, and that can be told.

    Parts of a run tell by how much they differ; a place of touch that is free is a constant of the
    force as well.
    """
    runs = [each.run for each in measurements if each.run]
    parts = len(runs) > len(set(runs))
    return {
        name: each
        for name, each in library.items()
        if composition.rig.admits(each)
        and (parts or not each.of_part)
        and not (instrument.free_touch and [p.name for p in each.parameters] == [each.zero])
    }


def _possible(ladder: Ladder) -> list[Fit]:
    """Return the models that a second recording might make the most probable."""
    pairs = zip(ladder.posterior.models, ladder.posterior.probabilities, strict=True)
    return [fit for fit, probability in pairs if probability > POSSIBLE]


def _likelihood(fit: Fit, moved: Fit, instrument: Instrument) -> float:
    """Return the logarithm of the likelihood of other recordings; the noise's level is unknown.

    Over all values that the first recording leaves possible, to first order in their errors
    (D. MacKay, Neural Computation 4 (1992), 415, section 3). What belongs to a run is fitted anew,
    and paid for as in the first recording: it makes a model that has more of it no more probable.

    Parameters
    ----------
    fit : Fit
        The model as the first recording told it.
    moved : Fit
        The same on the other recordings.
    instrument : Instrument
        What is known of the rig.
    """
    problem, by_value, held = _by_value(fit, moved, instrument)
    weighed = [problem.weighed(index, each) for index, each in enumerate(by_value)]
    left = [problem.weighed(index, each) for index, each in enumerate(moved.residuals)]
    sizes, directions = np.linalg.eigh(fit.covariance[np.ix_(held, held)])
    root = directions * np.sqrt(np.maximum(sizes, 0.0))
    steps = np.concatenate(weighed) @ root
    steps = np.where(np.isfinite(steps), steps, 0.0)  # near a model that diverges none is known
    known = np.eye(root.shape[1]) + steps.T @ steps
    towards = steps.T @ np.concatenate(left)
    cost = moved.cost - float(towards @ np.linalg.solve(known, towards))
    said = moved.samples * math.log(max(cost, float(np.finfo(float).tiny)))
    learnt = moved.unknowns * math.log(moved.samples) + float(np.linalg.slogdet(known)[1])
    return -0.5 * (said + learnt)


def told_by(
    fit: Fit, measurements: Sequence[Measurement], instrument: Instrument
) -> Sequence[Measurement]:
    """Return other recordings of the specimen as the last model shows that they are to be weighed.

    As those that are fitted: with the noise that errors of the input make, and without the samples
    that no model follows there. All models are tried on the same samples. Where the last model
    diverges, it shows nothing.

    The instrument is the same: a driving force has the noise that it has in the first recordings,
    and the output no more than there, unless the residual has.
    """

    def moved(samples: Sequence[Measurement]) -> Fit | None:
        return carried(fit.composition, fit.named(), samples, instrument)

    of_force = float(np.fmax.reduce([each.input_noise for each in fit.measurements]))
    found = moved([replace(each, input_noise=of_force) for each in measurements])
    if found is None:
        return measurements
    quiet = [
        _as_quiet(each, residual, fit)
        for each, residual in zip(found.measurements, found.residuals, strict=True)
    ]
    found = replace(found, measurements=tuple(quiet))
    found = moved(with_input_noise(found, instrument)) or found
    undecided = partial(without_undecided, instrument=instrument)
    for without in (without_corners, undecided, without_outliers):
        kept = without(found)
        found = (moved(kept) if kept else found) or found
    return found.measurements


def _as_quiet(measurement: Measurement, residual: FloatArray, fit: Fit) -> Measurement:
    """Return another recording with no more noise than a fit leaves, unless its residual has more.

    A residual under a force that is noisy is rough for that.
    """
    if measurement.noise <= fit.noise:
        return measurement
    if any(each.whitening is not None for each in fit.measurements):
        return replace(measurement, noise=fit.noise)
    return measurement.with_noise_of(residual)


def _as_sure(ladder: Ladder, instrument: Instrument) -> tuple[Ladder, list[Finding]]:
    """Widen the intervals of models that no simulation of these samples follows finely enough."""
    findings = []
    for fit in dict.fromkeys((ladder.base, ladder.final)):
        wider = widened(fit, instrument)
        if wider is not fit:
            findings = [Finding("coarse", COARSE)]
            ladder = ladder.exchanged(fit, wider)
    return ladder, findings


def _finest(measurements: Sequence[Measurement]) -> Fineness:
    """Return the fineness that none of the measurements exceeds."""
    every = [each.fineness for each in measurements]
    return Fineness(max(each.degree for each in every), max(each.parts for each in every))


def _noisier(final: Fit, validation: Sequence[Measurement]) -> list[Finding]:
    """Tell where another recording has more noise of its own than those that were fitted."""
    times = max((each.noise / final.noise for each in validation), default=0.0)
    return [Finding("noisier", NOISIER.format(times))] if times > FAR else []


def _uncertainty(fit: Fit, moved: Fit | None, instrument: Instrument) -> float:
    """Return the error that the covariance of a model's values predicts on other recordings.

    To first order in the values' errors, and rms over all samples; 0 where the model diverges.
    """
    if moved is None:
        return 0.0
    _, by_value, held = _by_value(fit, moved, instrument)
    pairs = zip(by_value, moved.measurements, strict=True)
    used = np.concatenate([each[measurement.used] for each, measurement in pairs])
    squares = float(np.sum(used @ fit.covariance[np.ix_(held, held)] * used))
    return math.sqrt(max(squares, 0.0) / len(used))


def _by_value(
    fit: Fit, moved: Fit, instrument: Instrument
) -> tuple[Problem, list[FloatArray], IntArray]:
    """Return what values of the specimen do to the output of each of other recordings.

    With the problem of these recordings, and the places of the values among all of the first.
    """
    held = np.flatnonzero(np.isin(fit.names, of_specimen(fit.composition)))
    problem = Problem(moved.composition, moved.measurements, instrument)
    simulated = problem.simulate(moved.values, moved.starts)
    return problem, [each[:, problem.states :][:, held] for _, each in simulated], held


def _noise(measurements: Sequence[Measurement]) -> float:
    """Return the noise over all measurements, with what errors of the position make; NaN if none.

    The excess of a fit has such errors, too, but those of its own measurements: a quicker motion
    has larger ones.
    """
    if not measurements:
        return math.nan
    counts = [int(np.sum(each.used)) for each in measurements]
    return math.sqrt(np.average([each.noise_power for each in measurements], weights=counts))


def _command(
    suggestion: Suggestion | None, measurements: Sequence[Measurement]
) -> DriverCommand | None:
    """Return what runs an experiment on the suite's own driver, which is of the usual size."""
    if suggestion is None or not measurements[0].scale.is_usual:
        return None
    return driver_command(suggestion, _coil_gain(measurements))


def _coil_gain(measurements: Sequence[Measurement]) -> float:
    """Return the first gain of the coil that is known [m/V]; NaN where none is."""
    gains = (measurement.coil_gain for measurement in measurements)
    return next(filter(math.isfinite, gains), math.nan)


def _refuse(rig: Rig, wanted: Sequence[Effect]) -> None:
    for effect in wanted:
        told = [rig.obstacle(form) for form in effect.every_form]
        if all(told):
            raise MeasurementError(
                f"{effect.name} cannot be fitted to these measurements of a {rig}: it {told[0]}"
            )


def _as_read(measurements: Sequence[Measurement]) -> list[Finding]:
    return [Finding("as_read", note) for each in measurements for note in each.notes]


def _coloured(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    library: Mapping[str, Effect],
    begin_at: Mapping[str, float] | None,
) -> Sequence[Measurement]:
    """Filter noise of a force that drives by the best model of one effect: it has the colour.

    By the plain model where that leaves noise only: friction that sticks keeps noise from the tip.
    """
    if composition.input is not FORCE:
        return measurements
    base = fit_base(composition, measurements, instrument, begin_at)
    if all(measurement.whitening is None for measurement in base.measurements):
        return measurements
    if explained(base):
        return base.measurements
    if is_quiet(base):
        return quieter(base, instrument, least=True) or base.measurements
    ranking = ranked(base, fit_candidates(base, library.values(), instrument))
    right = bool(ranking) and significant(base, ranking[0], base)
    return filtered(ranking[0], instrument) if right else base.measurements
