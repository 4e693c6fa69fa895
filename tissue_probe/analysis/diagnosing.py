"""Which physical effect a model misses, and the model with it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tissue_probe import arguments as take
from tissue_probe.analysis import fit_shown, tables
from tissue_probe.analysis import verdict_in_words as words
from tissue_probe.analysis.asking import asks
from tissue_probe.analysis.measurements import Measurements, Source, measurements_of
from tissue_probe.analysis.other_rig import other_rig
from tissue_probe.analysis.question import (
    Asked,
    ModelQuestion,
    check_wanted,
    question,
)
from tissue_probe.analysis.result_table import ResultTable
from tissue_probe.analysis.segments import Segment
from tissue_probe.diagnosis.advice.separation import ALL_EXPERIMENTS, PossibleExperiments
from tissue_probe.diagnosis.answer import Answer, Verdict, answer
from tissue_probe.diagnosis.diagnosis import Diagnosis
from tissue_probe.diagnosis.diagnosis import diagnose as search
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.ranking.rules import find_added_effect
from tissue_probe.diagnosis.sharing import WORKERS, among
from tissue_probe.errors import ParameterError
from tissue_probe.likeness import Alike
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from typing_extensions import Unpack

    from tissue_probe.analysis.comparing import ComparisonResult
    from tissue_probe.diagnosis.fitting.fit import Fit

#: Where an effect shows in the difference of two recordings only, such as dry friction at one speed
#: in each.
SHOWN_TOGETHER = Finding(
    "together",
    "The model that explains the first recording does not explain the others, so all were fitted "
    "together: no recording is left to try the result on. The result holds if specimen, site and "
    "contact are the same in all recordings.",
)

#: Name of the effect of a learnt shape, and of its file.
FREE_FORM, EFFECT_FILE = "free_form", "my_effect.py"

Found = Callable[[str, "Fit"], None]
"""Told an effect, and the model that is asked about with it."""


@dataclass(frozen=True, eq=False, repr=False)
class DiagnosisResult(Alike):
    """The effects missing in a model, and the model that has them.

    Attributes
    ----------
    found : Diagnosis
        All that was found: fits, tests, suggestions.
    fitted, validated : Measurements
        The recordings that the models were fitted to, and those they were only tried on.
    sources : tuple of str
        Each stretch of samples that was fitted.
    notes : tuple of str
        How the samples were read, and their faults, in sentences.
    asked : Question
        The model and the rig as asked for.
    wording : callable
        Rewrites sentences of the report, which name parameters in backticks.
    """

    found: Diagnosis
    fitted: Measurements
    validated: Measurements
    sources: tuple[str, ...]
    notes: tuple[str, ...]
    asked: ModelQuestion
    wording: Callable[[str], str] = str

    @property
    def verdict(self) -> Verdict:
        """``adequate``, ``missing``, ``ambiguous`` or ``unexplained``."""
        return self.found.verdict

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects that are missing, in the order in which they are added."""
        return self.found.effects

    @property
    def converged(self) -> bool:
        """Whether the search for the values of the model asked about settled."""
        return self.found.ladder.base.converged

    @cached_property
    def text(self) -> str:
        """The verdict in sentences, and the next experiment."""
        return "\n".join(words.describe_diagnosis(self.found))

    @property
    def next_experiment(self) -> str:
        """The command line that runs the next experiment on the driver; empty if there is none."""
        return self.found.command.line if self.found.command else ""

    @cached_property
    def answer(self) -> Answer:
        """The answer for programs."""
        return self._answer(None)

    def _answer(self, compared: Fit | None) -> Answer:
        asked = {
            "prior": dict(self.asked.prior),
            "asked": self.asked.head,
            "sentences": words.verdict(self.found),
        }
        return answer(self.found, compared).model_copy(update=asked)

    @property
    def ranking(self) -> ResultTable:
        """Each effect beside the base model, the best first."""
        return tables.rank_effects(self.answer, self.found.ladder.base.output)

    @property
    def ladder(self) -> ResultTable:
        """Errors of each model, from the one asked about on."""
        return tables.ladder(self.found)

    @property
    def values(self) -> ResultTable:
        """Values of each model of the ladder."""
        return tables.values(self.found)

    @property
    def shape(self) -> ResultTable | None:
        """Each variable's share of the missing force, where the verdict is ``unexplained``."""
        return tables.shape(self.found)

    @property
    def exhaustion(self) -> str:
        """The meaning of values at their limit; empty where none is."""
        ladder = self.found.ladder
        return fit_shown.exhaustion((ladder.base, *ladder.steps))

    @property
    def model(self) -> FittedModel:
        """The last model of the ladder with its values; ``save`` writes it."""
        from tissue_probe.analysis.kept_files import make_kept_model

        return make_kept_model(self)

    @property
    def rivals(self) -> dict[str, FittedModel]:
        """Models that explain the measurement equally well, by their titles; at least the last."""
        ladder = self.found.ladder
        fits = (ladder.rivals if self.found.indistinguishable else ()) or (ladder.final,)
        files = self.asked.model.effect_files
        return {fit_shown.title(fit): fit_shown.model_of(fit, files) for fit in fits}

    @take.checks(effect=take.text)
    def explain_by(self, effect: str, index: int) -> FloatArray:
        """Return the part of a part's residual that an effect alone explains [unit of the output].

        Raises
        ------
        ParameterError
            If the ranking has no such effect.
        """
        stretches = len(self.found.ladder.base.measurements)
        index = take.whole(most=stretches - 1)("index", index)
        return self.beside(effect).predicted[index] - self.found.ladder.base.predicted[index]

    @take.checks(effect=take.text)
    def beside(self, effect: str) -> Fit:
        """Return the model that was asked about with an effect of the ranking.

        Raises
        ------
        ParameterError
            If the ranking has no such effect.
        """
        for fit in self.found.ladder.ranking:
            if find_added_effect(fit).name == effect:
                return fit
        raise ParameterError(f"`effect` {effect}: the ranking does not have it")

    def __repr__(self) -> str:
        return f"{self.asked.head}\n{self.text}\n{tables.shorten_table(self.ranking, 8)!r}"

    def _repr_html_(self) -> str:
        said = fit_shown.as_html([self.asked.head, *self.text.splitlines()])
        return (
            said + tables.shorten_table(self.ranking, 8)._repr_html_() + self.ladder._repr_html_()
        )

    def to_frame(self) -> Any:
        """Return the ranking as a pandas data frame."""
        return self.ranking.to_frame()

    def to_dict(self, compared: ComparisonResult | None = None) -> dict[str, Any]:
        """Return the answer as JSON holds it, with the model that was ``compared`` if one was."""
        told = self._answer(compared.fit) if compared else self.answer
        return told.model_dump(mode="json")

    def draw_shape(self) -> str | None:
        """Draw the shape of the missing force as an SVG element; None where none is claimed."""
        curve = self.found.shape and self.found.shape.curve
        if not curve:
            return None
        from tissue_probe.figures.shape import write_shape_picture

        return write_shape_picture(curve)

    def plot(self) -> Figure:
        """Draw the diagnosis on one page: where the model fails, the ranking, the ladder."""
        from tissue_probe.analysis.kept_files import story

        return story(self)

    @take.checks(path=take.path)
    def report(self, path: str | Path) -> None:
        """Write the report: one page of HTML that works off line."""
        from tissue_probe.analysis.kept_files import write_report

        write_report(self, Path(path))

    @take.checks(folder=take.path)
    def save(self, folder: str | Path) -> None:
        """Write model.yaml, story.png, ladder.png, compare.png and report.html into a folder.

        And shape.png, the shape of the missing force, if one is claimed.
        """
        from tissue_probe.analysis.kept_files import write

        write(self, Path(folder))


@asks
@take.checks(
    add=take.several(take.text, "names of effects"),
    progress=take.function,
    found=take.function,
    workers=take.whole(1),
)
def diagnose(
    measured: Source | Sequence[Source],
    *,
    validate: Source | Sequence[Source] | None = None,
    add: Sequence[str] = (),
    progress: Callable[[str], None] = lambda doing: None,
    found: Found = lambda effect, fit: None,
    workers: int = WORKERS,
    **asked: Unpack[Asked],
) -> DiagnosisResult:
    """Say which physical effect a model misses.

    Parameters
    ----------
    measured : Measurements, path, data frame, mapping of arrays, or a sequence of these
        Of one specimen.
    validate : as ``measured``, optional
        Other recordings of the same specimen, on which models are tried and not fitted. Where the
        last model explains ``measured`` and not these, all are fitted together; if an effect then
        explains all of them, that is the result. A file is read as the first of ``measured`` was.
    add : sequence of str
        Effects to be added in this order, instead of those that are missing.
    progress : callable
        Called with the step under way; an exception that it raises ends the diagnosis.
    found : callable
        Told each effect's name and the model with it (``rmse``, ``heldout_rmse``, ``predicted``) as
        soon as that is fitted, maybe again when it is fitted better. It is called in this process
        or in a copy of it, where nothing of this one can be changed: let it write to a pipe or a
        file.
    workers : int
        Processes that may share the work, 1 or more: this one, and one copy of it (fork) at most;
        1 keeps all of it in this process. The numbers are the same.
    **asked
        See ``Asked``.

    Raises
    ------
    TissueProbeError
        If something cannot be read or fitted; says why, and the remedy.
    """
    put = question(**asked)
    check_wanted(put, add)
    fitted = measurements_of(measured)
    validated = Measurements(()) if validate is None else measurements_of(validate, fitted)
    _check_validation(fitted, validated)
    with among(workers):
        return _diagnose_measurements(put, fitted, validated, add, progress, found)


def _diagnose_measurements(
    put: ModelQuestion,
    fitted: Measurements,
    validated: Measurements,
    add: Sequence[str],
    progress: Callable[[str], None] = lambda doing: None,
    found: Found = lambda effect, fit: None,
    possible: PossibleExperiments = ALL_EXPERIMENTS,
) -> DiagnosisResult:
    """Diagnose measurements that are read."""
    output = put.composition.output
    taken, tried = (put.segments(each) for each in (fitted, validated))

    def search_effects(samples: Sequence[Segment], others: Sequence[Segment]) -> Diagnosis:
        diagnosis: Diagnosis = search(
            put.composition,
            [each.measurement(output) for each in samples],
            put.instrument_for(fitted),
            put.library,
            [each.measurement(output) for each in others],
            tuple(add),
            put.model.values,
            progress,
            lambda fit: found(find_added_effect(fit).name, fit),
            possible,
        )
        return diagnosis

    diagnosis = search_effects(taken, tried)
    if diagnosis.fails_elsewhere and not add:
        progress("the model does not carry over: all recordings are fitted together")
        together = search_effects([*taken, *tried], [])
        if together.verdict == "missing":
            diagnosis = replace(together, findings=(SHOWN_TOGETHER, *together.findings))
            fitted, validated = Measurements((*fitted.parts, *validated.parts)), Measurements(())
            taken = [*taken, *tried]
    notes = (*put.notes, *(finding.sentence for finding in diagnosis.findings))
    if not add and (other := other_rig(diagnosis, put, taken)):
        notes += (other,)
    sources = tuple(each.source for each in taken)
    return DiagnosisResult(diagnosis, fitted, validated, sources, notes, put)


def diagnose_read(
    put: ModelQuestion, measured: Measurements, possible: PossibleExperiments = ALL_EXPERIMENTS
) -> DiagnosisResult:
    """Answer a question about measurements, all of it in this process.

    Parameters
    ----------
    put : ModelQuestion
        The question.
    measured : Measurements
        Of one specimen, fitted together.
    possible : PossibleExperiments
        Of which the next one is chosen.
    """
    with among(1):
        return _diagnose_measurements(put, measured, Measurements(()), (), possible=possible)


def diagnosis_of(compared: ComparisonResult, workers: int = WORKERS) -> DiagnosisResult:
    """Diagnose the measurements of a comparison, with the model that was compared."""
    asked, fitted = compared.asked, compared.fitted
    with among(workers):
        found = search(
            asked.composition, compared.taken, asked.instrument_for(fitted), asked.library, (), (),
            asked.model.values,
        )  # fmt: skip
    return DiagnosisResult(found, fitted, Measurements(()), compared.sources, compared.notes, asked)


@asks
@take.checks(output=take.optional(take.path), free_form=take.flag, workers=take.whole(1))
def improve(
    measured: Source | Sequence[Source],
    *,
    validate: Source | Sequence[Source] | None = None,
    add: Sequence[str] = (),
    output: str | Path | None = None,
    free_form: bool = False,
    progress: Callable[[str], None] = lambda doing: None,
    workers: int = WORKERS,
    **asked: Unpack[Asked],
) -> DiagnosisResult:
    """Add the missing effects (or those of ``add``), and keep the model, pictures and report.

    Parameters
    ----------
    measured, validate, add, progress, workers
        As ``diagnose`` has them.
    output : path, optional
        Folder into which all is written.
    free_form : bool
        Where no law explains the record, write ``my_effect.py`` there, an effect of the shape that
        was learnt, and add that.
    **asked
        See ``Asked``.

    Raises
    ------
    TissueProbeError
        As ``diagnose``, and with ``free_form`` as ``with_free_form``.
    """
    if free_form and output is None:
        raise ParameterError("`free_form` writes an effect: say into which folder, by `output`")
    if free_form and output is not None:
        result = with_free_form(
            measured, output, validate=validate, add=add, progress=progress, workers=workers,
            **asked,
        )  # fmt: skip
    else:
        result = diagnose(
            measured, validate=validate, add=add, progress=progress, workers=workers, **asked
        )
    if output is not None:
        result.save(output)
    return result


def with_free_form(
    measured: Source | Sequence[Source],
    folder: str | Path,
    *,
    validate: Source | Sequence[Source] | None = None,
    add: Sequence[str] = (),
    progress: Callable[[str], None] = lambda doing: None,
    workers: int = WORKERS,
    **asked: Unpack[Asked],
) -> DiagnosisResult:
    """Write the learnt shape of the missing force as an effect into a folder, and add that.

    Parameters
    ----------
    folder : path
        Where ``my_effect.py`` goes, and ``shape.png``.
    measured, validate, add, progress, workers, **asked
        As ``diagnose`` has them.

    Raises
    ------
    ParameterError
        If ``add`` names effects, the file is there already, or there is no shape, since the
        diagnosis found the missing effects, or that none is missing.
    MeasurementError
        If no shape is claimed, or one that no effect can have.
    """
    path = Path(folder) / EFFECT_FILE
    if add:
        raise ParameterError(
            "`free_form` adds the shape that is learnt: leave out `add` or `free_form`"
        )
    if path.exists():
        raise ParameterError(
            f"{path} is there already, and may be changed by hand: rename it, or give another "
            "`output`"
        )

    def diagnose_again(add: Sequence[str], asked: Asked) -> DiagnosisResult:
        return diagnose(
            measured, validate=validate, add=add, progress=progress, workers=workers, **asked
        )

    result = diagnose_again((), asked)
    _write_effect(result, path)
    asked["effects"] = (*result.asked.stated.get("effects", ()), path)
    beside = result.found.shape.fit.composition.effects if result.found.shape else ()
    own = {each.name for each in result.asked.composition.effects}
    return diagnose_again([*(e.name for e in beside if e.name not in own), FREE_FORM], asked)


def _write_effect(result: DiagnosisResult, path: Path) -> None:
    """Write the shape of the missing force as an effect, and its picture beside it."""
    from tissue_probe.analysis.kept_files import write_shape
    from tissue_probe.diagnosis.shape.effect_file import effect_text

    if result.found.fails_elsewhere:
        raise ParameterError(
            "`free_form`: the model explains the fitted recording, and not that of `validate`, so "
            "that no force is left to learn a shape of: swap the recordings, or leave it out"
        )
    if result.found.shape is None:
        raise ParameterError(
            f"`free_form`: the verdict is {result.verdict}: no shape was learnt; leave it out"
        )
    text = effect_text(result.found.shape)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    write_shape(result, path.parent)


def _check_validation(fitted: Measurements, validated: Measurements) -> None:
    """Refuse to try models on the recording that they are fitted to."""
    for part in validated.parts:
        if any(part.is_same(other) for other in fitted.parts):
            raise ParameterError(
                f"`validate` {part.name} is the fitted recording; give another recording of the "
                "same specimen"
            )
