"""How well a model follows measurements, and where it fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tissue_probe import arguments as take
from tissue_probe.analysis import fit_shown
from tissue_probe.analysis.asking import asks
from tissue_probe.analysis.error_view import ErrorView, error_view
from tissue_probe.analysis.measurements import Measurements, Source, measurements_of
from tissue_probe.analysis.other_values import predict_output
from tissue_probe.analysis.question import Asked, ModelQuestion, check_wanted, question
from tissue_probe.analysis.result_table import ResultTable
from tissue_probe.diagnosis.fit_checks import check_fit
from tissue_probe.diagnosis.fitting.corners import without_corners
from tissue_probe.diagnosis.fitting.fit import Fit as Fit
from tissue_probe.diagnosis.fitting.input_noise import whiten_input_noise
from tissue_probe.diagnosis.improvement.ladder import climb_by
from tissue_probe.diagnosis.left_out_samples import report_left_out
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.preparation import prepare_question
from tissue_probe.diagnosis.ranking.candidates import fit_base, refit
from tissue_probe.diagnosis.ranking.other_runs import carry_model
from tissue_probe.diagnosis.revisions.held_fineness import refine_held
from tissue_probe.diagnosis.sharing import WORKERS, among
from tissue_probe.diagnosis.sizing import library_of_size
from tissue_probe.errors import MeasurementError
from tissue_probe.likeness import Alike
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from typing_extensions import Unpack


@dataclass(frozen=True, eq=False, repr=False)
class ComparisonResult(Alike):
    """A model beside measurements.

    Attributes
    ----------
    fit : Fit
        The model with its values, errors and residuals.
    held : str
        The model file whose values were held; empty where they were fitted.
    sources : tuple of str
        Each stretch of samples, in the order of the fit's measurements.
    notes : tuple of str
        How the samples were read, and their faults, in sentences.
    asked : Question
        The model and the rig as asked for.
    fitted : Measurements
        As read.
    taken : tuple of Measurement
        Its stretches before the samples that are spoilt were left out.
    instrument : Instrument
        The rig with its tolerances when it was fitted.
    """

    fit: Fit
    held: str
    sources: tuple[str, ...]
    notes: tuple[str, ...]
    asked: ModelQuestion
    fitted: Measurements
    taken: tuple[Measurement, ...]
    instrument: Instrument

    @property
    def rmse(self) -> float:
        """Error on all samples, rms, in the unit of the output."""
        return self.fit.rmse

    @property
    def heldout_rmse(self) -> float:
        """Error on blocks that were held out of the fit, rms, in the unit of the output."""
        return self.fit.heldout_rmse

    @property
    def noise(self) -> float:
        """White noise of the output: the error that a right model would leave."""
        return self.fit.noise

    @property
    def parameters(self) -> ResultTable:
        """Fitted values with their 95 % intervals."""
        return fit_shown.parameters(self.fit)

    @property
    def model(self) -> FittedModel:
        """The model with its values; ``save`` writes it."""
        return fit_shown.model_of(self.fit, self.asked.model.effect_files)

    @cached_property
    def text(self) -> str:
        """Values, errors, and where the model fails, as ``compare`` prints them."""
        return "\n".join([*_errors(self.fit, self.held), *_failures(self.fit, self.sources)])

    @take.checks(effect=take.text, begin=take.optional(take.instance(Fit, "a fit of a ranking")))
    def plus(self, effect: str, begin: Fit | None = None) -> ComparisonResult:
        """Add an effect, and fit the model again: the next rung of a ladder.

        Parameters
        ----------
        effect : str
            Its name in the library.
        begin : Fit, optional
            The model with the effect as a ranking found it: the search goes on there, instead of
            from every start (``DiagnosisResult.beside``).

        Raises
        ------
        ParameterError
            If there is no such effect, or the model has it already.
        MeasurementError
            If it cannot be fitted to these measurements.
        """
        asked = replace(self.asked, model=self.model)
        check_wanted(asked, [effect])
        fit = None if begin is None else refit(begin, begin.composition, self.instrument)
        if fit is None:
            composition = self.fit.composition
            library = library_of_size(asked.library, composition.scale, [effect])
            fit = climb_by(
                composition, self.fit.measurements, self.instrument, [library[effect]],
                self.fit.named(),
            ).final  # fmt: skip
        told = [each.sentence for each in check_fit(fit, fit)]
        notes = tuple(dict.fromkeys((*self.notes, *told)))
        return replace(self, fit=fit, held="", notes=notes)

    @take.checks(values=take.by_name(take.number(), "numbers"))
    def predict(self, values: Mapping[str, float], index: int | None = None) -> FloatArray:
        """Return the model's prediction of a part if some values were others.

        The states at the first sample move with the values as a probe's at rest do.

        Parameters
        ----------
        values : mapping of float
            By the names of ``parameters`` [SI]; values that are not named stay as fitted.
        index : int, optional
            Which stretch; that with most of the error by default.

        Returns
        -------
        array, shape (n,)
            In the unit of the output; not finite where the model diverges.

        Raises
        ------
        ParameterError
            If the model has no such value, or it is out of its bounds.
        """
        return predict_output(self.fit, self.instrument, values, self._stretch(index))

    @take.checks()
    def view(self, index: int | None = None) -> ErrorView:
        """Return the samples of a stretch with all that their error is drawn over.

        By default that with most of the error.
        """
        return error_view(self.fit, self._stretch(index))

    def _stretch(self, index: int | None) -> int:
        """Return which stretch is meant."""
        if index is None:
            return self.fit.worst
        return int(take.whole(most=len(self.fit.measurements) - 1)("index", index))

    def __repr__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        lines = fit_shown.as_html(_failures(self.fit, self.sources))
        told = fit_shown.as_html([fit_shown.title(self.fit), *_errors(self.fit, self.held)[-6:]])
        return told + self.parameters._repr_html_() + lines

    def to_frame(self) -> Any:
        """Return the parameters as a pandas data frame."""
        return self.parameters.to_frame()

    def to_dict(self) -> dict[str, Any]:
        """Return values and errors as JSON holds them (``compared`` of the answer)."""
        from tissue_probe.diagnosis.answer import step

        return step(self.fit, self.fit.heldout_rmse).model_dump(mode="json")

    def plot(self) -> Figure:
        """Draw measured and predicted output, and the residual where it fails."""
        return fit_shown.picture(self.fit, self.fit.worst, self.sources)


@asks
@take.checks(workers=take.whole(1))
def compare(
    measured: Source | Sequence[Source],
    *,
    workers: int = WORKERS,
    **asked: Unpack[Asked],
) -> ComparisonResult:
    """Compare a model with measurements.

    A model with values of its own (``model``) is held at them, and only values of a run are fitted;
    any other is fitted.

    Parameters
    ----------
    measured : Measurements, path, data frame, mapping of arrays, or a sequence of these
        Of one specimen.
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
    put, fitted = question(**asked), measurements_of(measured)
    with among(workers):
        return _compare_model(put, fitted, asked.get("model"))


def _compare_model(
    put: ModelQuestion, fitted: Measurements, model: str | Path | FittedModel | None
) -> ComparisonResult:
    """Compare a model with measurements that are read."""
    found = put.segments(fitted)
    taken = [each.measurement(put.composition.output) for each in found]
    known, at = put.instrument_for(fitted), put.model.values
    ready = prepare_question(put.composition, taken, known, begin_at=at)
    composition, clean, instrument = ready.composition, ready.measurements, ready.instrument
    findings = list(ready.findings)
    if model is not None:
        fit = evaluate_model(put.model, clean)
    else:
        fit = fit_base(composition, clean, instrument)
        if kept := without_corners(fit):
            fit = fit_base(composition, kept, instrument)
            findings += report_left_out(clean, fit, instrument)
    notes = list(put.notes)
    notes += [each.sentence for each in (*findings, *check_fit(fit, fit))]
    named = "" if model is None else str(model) if not isinstance(model, FittedModel) else "given"
    sources = tuple(each.source for each in found)
    return ComparisonResult(
        fit, named, sources, tuple(notes), put, fitted, tuple(taken), instrument
    )


def evaluate_model(model: FittedModel, clean: Sequence[Measurement]) -> Fit:
    """Return a model at its values on measurements: only values of a run are fitted.

    It is simulated as finely as its error asks: its values may be of a fit that was finer.

    Raises
    ------
    MeasurementError
        If it cannot be simulated on these measurements.
    """
    rig = Instrument(model.composition.rig, {})
    carry = partial(carry_model, model.composition, model.values, instrument=rig)
    fit = carry(clean)
    if fit is None:
        raise MeasurementError(
            "`model`: it diverges on these measurements; was it fitted to other units?"
        )
    fit = refine_held(fit, rig, carry)
    return whiten_input_noise(fit, rig, fit.named())


def _errors(fit: Fit, model: str) -> list[str]:
    """Tell values and errors; a model held at its file's values has no held-out error."""
    output = fit.output
    signal = np.concatenate([m.output_values for m in fit.measurements])
    share = f"{100 * fit.rmse / output.size(signal):.3g} % of the {output.name}'s rms"
    if not output.zeroed:
        share += " about its mean"
    values = f"values held, as in {model}" if model else "values +- 95 % intervals"
    told = [f"{fit_shown.title(fit)}, {values}:", *fit_shown.lines(fit)]
    told.append(f"  error                      {output.tell(fit.rmse, 4)} rms, {share}")
    if not model:
        told.append(f"  error on held-out parts    {output.tell(fit.heldout_rmse, 4)} rms")
    noise = output.tell(fit.noise, 4)
    told.append(f"  noise floor                {noise} rms: the error that noise alone leaves")
    told.append(f"  error over noise           {fit_shown.over_noise(fit)}")
    if not fit.converged:
        told.append("  the fit did not settle: take its values for a guess")
    if fit.exhausted:
        told.append(fit_shown.exhaustion([fit]))
    return told


def _failures(fit: Fit, sources: Sequence[str]) -> list[str]:
    """Tell where a model fails, in the measurement that it predicts worst."""
    told = []
    if shown := fit_shown.stretch(fit, fit.worst, sources):
        error = fit.output.tell(fit.error(fit.worst), 4)
        told.append(
            f"The lines below, and the picture, are of {shown}; the error in it is {error} rms."
        )
    tests = fit_shown.tests(fit, fit.worst)
    failed = [t for t in tests if not t.passed and np.isfinite(t.statistic)]
    where = fit_shown.where(fit, fit.worst)
    if failed or where.here:
        told.append("Where it fails, known 1/f noise taken out:")
    told += [f"- {test.name}: {test.finding}. {test.hint}" for test in failed]
    here = where.here
    told.append(f"Here: {here.describe()}" if here else "The error stands out nowhere.")
    return told
