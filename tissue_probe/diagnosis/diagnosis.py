"""From measurements to a verdict: inspect, climb the ladder, prove on held-out data, advise.

Contents: the order of the steps.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar, cast

from threadpoolctl import threadpool_limits

from tissue_probe.diagnosis import instrument_values
from tissue_probe.diagnosis.advice.driver_command import DriverCommand, driver_command
from tissue_probe.diagnosis.advice.separation import (
    ALL_EXPERIMENTS,
    RIVALS_COMPARED,
    PossibleExperiments,
    Suggestion,
    suggest,
)
from tissue_probe.diagnosis.advice.visibility import unseen
from tissue_probe.diagnosis.evidence.conclusion import Ladder, Verdict
from tissue_probe.diagnosis.evidence.posterior import list_favoured_effects
from tissue_probe.diagnosis.fit_checks import check_fit, check_held_out
from tissue_probe.diagnosis.fitting.accuracy import widen_covariance
from tissue_probe.diagnosis.fitting.event_intervals import ask_likelihood
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.improvement.ladder import Progress, climb, climb_by
from tissue_probe.diagnosis.improvement.moves import addable
from tissue_probe.diagnosis.input_course import COURSE, report_course
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.instrument_values import FoundInstrumentValue
from tissue_probe.diagnosis.left_out_samples import report_left_out
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.preparation import Prepared, prepare_question
from tissue_probe.diagnosis.ranking.candidates import Tell, fit_base
from tissue_probe.diagnosis.ranking.rules import find_added_effect
from tissue_probe.diagnosis.ranking.screen import Promise, screen_effects
from tissue_probe.diagnosis.revisions.table import NO_FLICKER, apply_to_instrument
from tissue_probe.diagnosis.second_recording import FAR_RATIO, SecondRecording
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.rigs import OWN

if TYPE_CHECKING:
    from tissue_probe.diagnosis.shape.shape_report import FoundShape
    from tissue_probe.physics.effects import Effect

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
#: Where a finer simulation would change the values, and no finer one is possible.
TOO_COARSE = (
    "The samples are too few to simulate the model as finely as its values are known: the "
    "intervals are wider by the error that this may leave. Sample more often."
)


@dataclass(frozen=True)
class Diagnosis:
    """The effects missing in a model, and how sure they are.

    Attributes
    ----------
    verdict : str
        "adequate", "missing", "ambiguous" or "unexplained".
    ladder : Ladder
        The models that were tried, and those accepted.
    spoilt : tuple of str
        ``adc_saturation``, ``stuck_samples``: the fault of samples that were left out.
    findings : tuple of Finding
        Of reading and of the inspection, on all measurements, also those that validate; of the fit.
    indistinguishable : tuple of str
        Effects by which models differ that explain the measurement equally well
        (``ladder.rivals``); empty where one is alone.
    unseen : tuple of str
        Effects of typical strength that this measurement could not have shown, beside those added;
        none where something is left unexplained.
    suggestion : Suggestion or None
        The experiment that would separate the indistinguishable effects, or show the unseen ones.
    validated : mapping of tuple of str to float
        Error [unit of the output] on the validating recordings by the names of a model's effects.
    seconds : float
        Time that it took.
    validation_noise : float
        Noise on the validating recordings, rms: white, and that which errors of the position make;
        NaN without.
    command : DriverCommand or None
        The command that runs the suggested experiment.
    uncertainty : float
        Error that the last model's values, known as roughly as they are, leave on the validating
        recordings; 0 without.
    instrument : tuple of InstrumentValue
        Values of the last model that belong to the instrument, not to the tissue.
    shape : FoundShape or None
        The shape of the missing force; None but where something is left unexplained.
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
    instrument: tuple[FoundInstrumentValue, ...] = ()
    shape: FoundShape | None = None

    @property
    def carries_over(self) -> bool:
        """Whether the last model errs on the validating recordings no more than it should.

        That is about as on those fitted, and as its values' uncertainty leaves besides.
        """
        final = self.ladder.final
        expected = math.hypot(self.validation_noise, final.excess, self.uncertainty)
        return not self.heldout(final) > FAR_RATIO * expected

    @property
    def fails_elsewhere(self) -> bool:
        """Whether the last model explains the measurements, and not the validating ones."""
        return self.verdict == "unexplained" and self.ladder.verdict in ("adequate", "missing")

    @property
    def reaches(self) -> bool:
        """Whether the recordings fitted tell the last model's values well enough for the others."""
        known = math.hypot(self.validation_noise, self.ladder.final.excess)
        return not self.uncertainty > FAR_RATIO * known

    @property
    def revisions(self) -> tuple[str, ...]:
        """Names of the revisions of the samples and of their weights, in their order."""
        return self.ladder.revisions

    @property
    def effects(self) -> tuple[str, ...]:
        """The missing effects, in the order in which they are added."""
        return (*self.spoilt, *self.ladder.effects)

    def heldout(self, fit: Fit) -> float:
        """Error of a model on samples it was not fitted to: a second recording, or blocks."""
        return self.validated.get(fit.composition.names, fit.heldout_rmse)


_FunctionT = TypeVar("_FunctionT", bound=Callable[..., object])


def _limit_threads(function: _FunctionT) -> _FunctionT:
    """Leave linear algebra one thread: searches have threads of their own, which would wait."""
    # The library has no types.
    return cast(_FunctionT, threadpool_limits.wrap(limits=1)(function))


@_limit_threads
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
    possible: PossibleExperiments = ALL_EXPERIMENTS,
) -> Diagnosis:
    """Name the effects that a model misses.

    Parameters
    ----------
    composition : Composition
        The model that is asked about.
    measurements : sequence of Measurement
        Of one specimen; fitted together.
    instrument : Instrument
        Constants of the rig with their tolerances.
    library : mapping of str to Effect
        The effects that may be missing.
    validation : sequence of Measurement
        Other recordings of the same specimen, on which models are tried and not fitted.
    wanted : sequence of str
        Effects to be added in this order, whether they are missing or not.
    begin_at : mapping of str to float, optional
        Values of the model, found before, at which the search for it begins.
    progress : callable
        Called with the step under way; an exception that it raises ends the diagnosis.
    tell : callable
        Told the model with each effect alone, as ``climb`` does.
    possible : PossibleExperiments
        Of which one is suggested.

    Raises
    ------
    MeasurementError
        If any samples are such that a fit would be worthless, or the rig has nothing that a
        wanted effect acts on; says why, and the remedy.
    """
    begun = time.perf_counter()
    asked = prepare_question(
        composition, measurements, instrument, library, validation, wanted, begin_at
    )
    ladder = _climb_ladder(asked, begin_at, progress, tell)
    instrument = apply_to_instrument(asked.instrument, ladder.revisions)
    ladder, coarse = _as_sure(ladder, instrument)
    hidden = _unseen(ladder, asked, instrument)
    ladder = _hidden_first(ladder, hidden)
    if asked.validation:
        progress("the models are tried on the second recording")
    second = SecondRecording.of(ladder, asked.validation, instrument)
    if not wanted and ladder.harmonic is None:
        by_first, ladder = ladder, second.conclude_ladder(ladder)
        if (ladder.verdict, ladder.final) != (by_first.verdict, by_first.final):
            hidden = _unseen(ladder, asked, instrument)
    progress("the next experiment is chosen")
    suggestion = _suggest_experiment(ladder, hidden, asked, instrument, possible)
    own = instrument_values.instrument_values(ladder.final, instrument)
    findings = [
        *_revise_findings(asked.findings, ladder),
        *coarse,
        *report_left_out(asked.measurements, ladder.final, instrument),
        *_of_fit(ladder, second),
        *instrument_values.findings(own),
    ]
    found = Diagnosis(
        "missing" if asked.spoilt and ladder.verdict == "adequate" else ladder.verdict,
        ladder, asked.spoilt, tuple(findings),
        ladder.tied if ladder.alternatives else (), hidden, suggestion,
        second.errors, time.perf_counter() - begun, second.noise,
        _command(suggestion, asked), second.uncertainty(ladder.final), own,
    )  # fmt: skip
    # A model that explains one recording of a specimen, and not another, does not explain it.
    if found.verdict in ("adequate", "missing") and not found.carries_over:
        return replace(found, verdict="unexplained")
    if found.verdict != "unexplained" or wanted:
        return found
    progress("the shape of the missing force is learnt")
    shape = _shape(ladder, instrument, second)
    return replace(found, shape=shape, seconds=time.perf_counter() - begun)


def _shape(ladder: Ladder, instrument: Instrument, second: SecondRecording) -> FoundShape:
    """Learn the shape beside the base, or beside the effects that come nearest."""
    # Only now: most diagnoses do without.
    from tissue_probe.diagnosis.shape.shape_report import find_shape

    return find_shape((ladder.base, *ladder.steps), instrument, second.measurements)


def _climb_ladder(
    asked: Prepared, begin_at: Mapping[str, float] | None, progress: Progress, tell: Tell
) -> Ladder:
    question = asked.composition, asked.measurements, asked.instrument
    if asked.wanted:
        return climb_by(*question, asked.wanted, begin_at, asked.given)
    return climb(*question, asked.library, begin_at, asked.given, progress, tell)


def _unseen(ladder: Ladder, asked: Prepared, instrument: Instrument) -> tuple[str, ...]:
    """Name the effects that may hide beside the last model, where that leaves noise only."""
    if ladder.verdict == "unexplained":
        return ()
    tried = ladder.ranking if ladder.verdict == "adequate" else ()
    hidden = unseen(ladder.final, asked.library, instrument, asked.composition, tried)
    favoured = list_favoured_effects(ladder.final, tried)
    named = {name for each in ladder.alternatives for name in each}
    return tuple(name for name in dict.fromkeys([*hidden, *favoured]) if name not in named)


def _hidden_first(ladder: Ladder, hidden: Sequence[str]) -> Ladder:
    """Put effects that may hide before those that would have shown, where none is missing."""
    if ladder.verdict != "adequate":
        return ladder
    order = sorted(ladder.ranking, key=lambda fit: find_added_effect(fit).name not in hidden)
    return replace(ladder, ranking=tuple(order))


def _suggest_experiment(
    ladder: Ladder,
    hidden: Sequence[str],
    asked: Prepared,
    instrument: Instrument,
    possible: PossibleExperiments,
) -> Suggestion | None:
    told = ladder.posterior
    rivals = ladder.rivals if ladder.alternatives and ladder.tied else (ladder.final,)
    if len(rivals) == 1 and told.probabilities[0] < possible.probability:
        rivals = told.models[:RIVALS_COMPARED]
    show = hidden if ladder.verdict == "adequate" else ()
    return suggest(rivals, instrument, asked.library, show, possible)


def _of_fit(ladder: Ladder, second: SecondRecording) -> Iterator[Finding]:
    """Yield the doubts about the last model."""
    doubts = list(check_fit(ladder.base, ladder.final))
    if not (doubts or second.measurements):
        doubts = list(check_held_out(ladder.final, second.instrument))
    yield from doubts
    if ladder.curtailed:
        yield CURTAILED
    yield from second.noisier(ladder.final)


def fit_plainly(
    composition: Composition, measurements: Sequence[Measurement], instrument: Instrument
) -> Fit:
    """Fit a model as ``diagnose`` does, and add nothing.

    Raises
    ------
    MeasurementError
        If any samples are such that a fit would be worthless, or no start leads to a fit.
    """
    asked = prepare_question(composition, measurements, instrument)
    return climb(asked.composition, asked.measurements, asked.instrument, {}).base


@_limit_threads
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
        The part of its residual that each effect could explain, to first order, and the model's own
        values cannot; the most first.
    findings : list of Finding
        Of reading and of the inspection.
    """
    asked = prepare_question(composition, measurements, instrument, library, begin_at=begin_at)
    composition, instrument = asked.composition, asked.instrument
    base = fit_base(composition, asked.measurements, instrument, begin_at)
    allowed = addable(composition, asked.library).values()
    (ranking,) = screen_effects([(base, allowed)], composition, instrument)
    return base, ranking, list(asked.findings)


def _revise_findings(findings: Sequence[Finding], ladder: Ladder) -> list[Finding]:
    """Return findings after the revisions of a ladder: the input's course may be another one."""
    found = list(findings)
    if COURSE in ladder.revisions:
        found = [each for each in found if each.name != COURSE]
        found += report_course(ladder.final.measurements[0].between)
    return [*found, QUIET] if NO_FLICKER in ladder.revisions else found


def _as_sure(ladder: Ladder, instrument: Instrument) -> tuple[Ladder, list[Finding]]:
    """Return models with intervals as wide as the samples and their simulation allow."""
    findings = []
    for fit in dict.fromkeys((ladder.base, ladder.final)):
        asked = ask_likelihood(fit, instrument)
        wider = widen_covariance(asked, instrument)
        if wider is not asked:
            findings = [Finding("coarse", TOO_COARSE)]
        if wider is not fit:
            ladder = ladder.exchange_model(fit, wider)
    return ladder, findings


def _command(suggestion: Suggestion | None, asked: Prepared) -> DriverCommand | None:
    """Return the command of an experiment on the suite's own driver, which is of the usual size.

    Others' instruments have no such driver, nor its coil.
    """
    usual = asked.measurements[0].scale.is_usual and asked.composition.rig is OWN
    if suggestion is None or not usual:
        return None
    return driver_command(suggestion, _coil_gain(asked.measurements))


def _coil_gain(measurements: Sequence[Measurement]) -> float:
    """Return the first gain of the coil that is known [m/V]; NaN where none is."""
    gains = (measurement.coil_gain for measurement in measurements)
    return next(filter(math.isfinite, gains), math.nan)
