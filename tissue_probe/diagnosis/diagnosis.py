"""From measurements to a verdict: inspect, climb the ladder, prove on held-out data, advise.

What belongs here: the order of the steps. What does not: the steps.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from threadpoolctl import threadpool_limits

from tissue_probe.diagnosis import instrument_values
from tissue_probe.diagnosis.advice.driver_command import DriverCommand, driver_command
from tissue_probe.diagnosis.advice.separation import Suggestion, suggest
from tissue_probe.diagnosis.advice.visibility import unseen
from tissue_probe.diagnosis.cleaning import SPOILT, cleaned, from_touch
from tissue_probe.diagnosis.evidence.conclusion import Ladder, Verdict
from tissue_probe.diagnosis.fit_checks import check_fit, check_held_out
from tissue_probe.diagnosis.fitting.accuracy import widened
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.improvement.ladder import Progress, climb, climb_by
from tissue_probe.diagnosis.improvement.moves import addable
from tissue_probe.diagnosis.input_course import COURSE, told
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.instrument_values import InstrumentValue
from tissue_probe.diagnosis.left_out import left_out
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.prepared import prepared
from tissue_probe.diagnosis.ranking.candidates import Tell, fit_base
from tissue_probe.diagnosis.ranking.rules import added
from tissue_probe.diagnosis.ranking.screen import Promise, screened
from tissue_probe.diagnosis.revisions.table import FLICKER, observed_with
from tissue_probe.diagnosis.second_recording import FAR, SecondRecording
from tissue_probe.diagnosis.sizing import library_of_size, of_size, sized, told_of_size
from tissue_probe.errors import MeasurementError
from tissue_probe.physics.composition import Composition

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
#: Where a finer simulation would change the values, and no finer one is possible.
COARSE = (
    "The samples are too few to simulate the model as finely as its values are known: the "
    "intervals are wider by the error that this may leave. Sample more often."
)


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
    def revisions(self) -> tuple[str, ...]:
        """Names of the revisions of the samples and of their weights, in their order."""
        return self.ladder.revisions

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

    given = (COURSE,) if any(each.between is not None for each in measurements) else ()
    if wanted:
        ladder = climb_by(composition, clean, instrument, asked_for, begin_at, given)
    else:
        ladder = climb(composition, clean, instrument, library, begin_at, given, progress, tell)
    instrument = observed_with(instrument, ladder.revisions)
    findings = _revised(findings, ladder)
    hidden: tuple[str, ...] = ()
    if ladder.verdict == "adequate":
        hidden = unseen(ladder.final, library, instrument, composition, ladder.ranking)
        # What may hide comes before what would have shown.
        order = sorted(ladder.ranking, key=lambda fit: added(fit).name not in hidden)
        ladder = replace(ladder, ranking=tuple(order))
    ladder, coarse = _as_sure(ladder, instrument)
    findings += coarse
    if validation:
        progress("the models are tried on the second recording")
    second = SecondRecording.of(ladder, validation, instrument)
    if validation and not wanted and ladder.harmonic is None:
        ladder = second.concluded(ladder)
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
    findings += second.noisier(ladder.final)
    own = instrument_values.instrument_values(ladder.final, instrument)
    findings += instrument_values.findings(own)
    verdict: Verdict = "missing" if spoilt and ladder.verdict == "adequate" else ladder.verdict
    found = Diagnosis(
        verdict, ladder, spoilt, tuple(findings), indistinguishable, hidden, suggestion,
        second.errors, time.perf_counter() - begun, second.noise, _command(suggestion, clean),
        second.uncertainty(ladder.final), own,
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


def _revised(findings: Sequence[Finding], ladder: Ladder) -> list[Finding]:
    """Return findings after the revisions of a ladder: the input's course may be another one."""
    found = list(findings)
    if COURSE in ladder.revisions:
        found = [each for each in found if each.name != COURSE]
        found += told(ladder.final.measurements[0].between)
    return [*found, QUIET] if FLICKER in ladder.revisions else found


def _as_sure(ladder: Ladder, instrument: Instrument) -> tuple[Ladder, list[Finding]]:
    """Widen the intervals of models that no simulation of these samples follows finely enough."""
    findings = []
    for fit in dict.fromkeys((ladder.base, ladder.final)):
        wider = widened(fit, instrument)
        if wider is not fit:
            findings = [Finding("coarse", COARSE)]
            ladder = ladder.exchanged(fit, wider)
    return ladder, findings


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
