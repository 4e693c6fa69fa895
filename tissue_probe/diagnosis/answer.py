"""What a diagnosis tells other programs: the layout of ``--json``.

Contents: names, types and meanings, version-numbered.
"""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from tissue_probe.diagnosis.diagnosis import Diagnosis
from tissue_probe.diagnosis.evidence.adequacy import adequacy
from tissue_probe.diagnosis.evidence.conclusion import Ladder
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.instrument_values import FoundInstrumentValue as Found
from tissue_probe.diagnosis.ranking.rules import find_added_effect
from tissue_probe.quantities import SIDE

if TYPE_CHECKING:
    from tissue_probe.diagnosis.shape.formula import Formula
    from tissue_probe.diagnosis.shape.learnt_curve import Curve
    from tissue_probe.diagnosis.shape.shape_report import FoundShape

Verdict = Literal["adequate", "missing", "ambiguous", "unexplained"]
#: A number, or null where there is none (JSON knows neither NaN nor infinity).
Number = Annotated[
    float | None, BeforeValidator(lambda v: v if v is None or math.isfinite(v) else None)
]


#: Models that are less probable are not told.
LEAST_TOLD = 1e-3


class _Entry(BaseModel):
    model_config = ConfigDict(extra="forbid")


class ParameterValue(_Entry):
    """A fitted value."""

    value: Number
    deviation: Number = Field(description="standard deviation of its error, same unit")
    unit: str
    at_limit: bool = Field(
        False, description="its search ended at a bound: the deviation holds on one side"
    )


class Value(ParameterValue):
    """A value of the last model, with its interval, and where the search for it lay."""

    name: str
    low: Number = Field(description="lower end of its 95 % interval, same unit")
    high: Number = Field(description="upper end")
    start: Number = Field(description="from where the search knew it: stated, or typical")
    lower: Number = Field(description="bounds of the search")
    upper: Number


class Errors(_Entry):
    """Errors of the last model, rms [output.unit]."""

    fitted: Number = Field(description="on the samples it was fitted to")
    heldout: Number = Field(description="on parts of the recording, by a fit to the others")
    second: Number = Field(description="on the second recording; null without")
    noise: Number = Field(description="of the samples fitted: what a right model would leave")
    second_noise: Number = Field(description="of the second recording; null without")
    over_noise: Number = Field(
        description="of the second over its noise, else of the fitted; about 1 where it is right"
    )


class Candidate(_Entry):
    """The base model with one effect more."""

    effect: str
    family: str
    heldout_rmse: Number = Field(description="error on held-out data [output.unit]")
    rmse: Number = Field(description="error on the data it was fitted to [output.unit]")
    gain: Number = Field(description="fall of the Bayesian information criterion")
    probability: Number = Field(
        default=None,
        description="that this effect is missing, over all models that were tried; null where "
        "effects were asked for",
    )
    parameters: dict[str, ParameterValue]
    converged: bool = Field(
        description="whether the search settled; else it gave up, far from the best, or ran out of "
        "steps, and its numbers are a guess"
    )


class ErrorPair(_Entry):
    """Error of the model asked about and of the improved one [output.unit]."""

    base: Number
    final: Number


class Rmse(_Entry):
    """Errors on the data of the fit, and on data held out from it."""

    training: ErrorPair
    heldout: ErrorPair


class Output(_Entry):
    """What the rig's models predict, and all errors are of."""

    quantity: Literal["force", "position"]
    unit: Literal["N", "m"]


class Experiment(_Entry):
    """What to record next."""

    excitation: dict[str, Any] = Field(
        description="parameters of the driver's excitation, by name; its amplitude as the coil's "
        "way [m]"
    )
    preload: float = Field(description="mean displacement of the coil [m]")
    duration: float = Field(description="time to record, from rest [s]")
    separation: Number = Field(
        description="residual over noise of the wrong model, predicted; null where there is none"
    )
    shows: list[str] = Field(default=[], description="effects of `unseen` that it would show")
    calibration: str = Field(description="what tells where no excitation does")
    command: str = Field(
        default="", description="command line that runs the excitation on the driver"
    )
    command_notes: list[str] = Field(
        default=[],
        description="what to do before, where the amplitude [V] comes from, and how it is "
        "recorded, in sentences",
    )


class Step(_Entry):
    """One model of the ladder."""

    effects: list[str]
    parameters: dict[str, ParameterValue]
    rmse_training: Number
    rmse_heldout: Number
    converged: bool


class ModelAnswer(_Entry):
    """One of the models that were tried, and how probable it is."""

    effects: list[str] = Field(description="what it has beside the model that was asked about")
    probability: Number = Field(description="given that one of the models of the library is right")
    adequacy: Number = Field(description="below 1 it leaves noise only")
    heldout_rmse: Number = Field(description="error on held-out data [output.unit]")


class InstrumentValue(_Entry):
    """A value that belongs to the instrument, not to the tissue."""

    name: str = Field(description="contact_position, or by how much a part differs: zero_by_part")
    unit: str
    recording: str = Field(description="where it was measured; empty where that has no name")
    part: int | None = Field(description="number of the part from 1; null: the whole recording")
    value: Number
    deviation: Number = Field(description="standard deviation of its error, same unit")
    degenerate_with: list[str] = Field(
        description="effects that would change the output in the same way"
    )


class VariableShare(_Entry):
    """The share of the residual beyond the noise that a free function explains, held out."""

    alone: Number = Field(description="share from 0 to 1")
    beyond: Number = Field(description="how much it adds to the others of the first choice")


class ShapeCurve(_Entry):
    """A learnt function of one variable; SI units."""

    variable: str = Field(
        description="indentation [m], velocity [m/s], force [N]; past: time since a step [s]; "
        "path: way since a reversal [m]"
    )
    grid: list[float]
    value: list[float] = Field(
        description="force [N] beyond a straight line; of past the stiffness that is left [N/m]"
    )
    sd: list[float] = Field(description="standard deviation of its error")


class ShapeSurface(_Entry):
    """A learnt function of two variables; SI units."""

    variables: list[str]
    grid: list[list[float]] = Field(description="of each variable")
    value: list[list[float]] = Field(
        description="force [N] beyond a plane; a row for each of the first variable"
    )
    sd: list[list[float]]
    visited: list[list[bool]] = Field(description="false: extrapolated, the record was never there")


class FormulaConstant(_Entry):
    """A constant of a formula."""

    name: str
    unit: str
    value: Number
    low: Number = Field(description="lower end of its 95 % interval")
    high: Number


class ShapeFormula(_Entry):
    """A simple formula for the learnt function."""

    formula: str = Field(description="of indentation [m] or velocity [m/s], in newtons")
    constants: list[FormulaConstant]
    probability: Number = Field(description="among the simple formulas that were tried")
    rivals: list[str] = Field(description="other formulas within the noise")


class ShapeAnswer(_Entry):
    """The variables of the force that no law of the library explains, and the function."""

    variables: list[str] = Field(
        description="the first choice: indentation, velocity, past, path, force, clock"
    )
    share: Number = Field(description="of the residual, held out, that they explain together")
    shares: dict[str, VariableShare]
    told: bool = Field(description="false: this motion cannot tell them from `alternatives`")
    alternatives: list[list[str]] = Field(description="other variables that explain as much")
    beside: list[str] = Field(description="effects of the model that the shape is learnt beside")
    over_noise: Number = Field(description="residual over the noise, rms")
    heldout_over_noise: Number = Field(description="the same of held-out parts")
    curve: ShapeCurve | None = None
    surface: ShapeSurface | None = None
    formula: ShapeFormula | None = None


class Answer(_Entry):
    """What ``compare``, ``diagnose`` and ``improve`` say."""

    version: Literal[1, 2, 3] = Field(
        default=3,
        description="1 has no probabilities; 3 has sentences, values, says, errors besides",
    )
    verdict: Verdict
    output: Output
    ranking: list[Candidate] = Field(
        description="best first; where the verdict is adequate, the unseen before the others"
    )
    models: list[ModelAnswer] = Field(
        default=[],
        description="the most probable first: those that together have a probability of 0.95, then "
        "others of more than 0.001; the asked one alone where effects were asked for",
    )
    families: dict[str, float] = Field(
        default={},
        description="probability that some effect of a family is missing, by the family's name",
    )
    family: str | None = Field(
        default=None,
        description="family of which an effect is surely missing, though no form of it is sure; "
        "else null",
    )
    indistinguishable: list[str] = Field(description="effects that this excitation cannot tell")
    alternatives: list[list[str]] = Field(
        description="what each model adds that explains the recording equally well; none if one"
    )
    unseen: list[str] = Field(description="effects that this excitation could not have shown")
    effects: list[str] = Field(
        description="what improve would add, in order; before them what spoilt the samples, which "
        "no model undoes: adc_saturation, stuck_samples"
    )
    rmse: Rmse
    noise_floor: Number = Field(
        description="standard deviation of the output's white noise [output.unit]"
    )
    ladder: list[Step]
    suggested_excitation: Experiment | None
    carries_over: bool | None = Field(
        default=None,
        description="whether the last model errs on the validating recordings no more than its "
        "noise and its values' uncertainty leave; null without any",
    )
    findings: list[str] = Field(
        description="what was done to read the samples, and what is wrong with them, in sentences"
    )
    revisions: list[str] = Field(
        default=[],
        description="names of the revisions of the samples and of their weights that models asked "
        "for, in their order: quieter and louder (noise), motion, undecided, outliers, corners, "
        "fineness (of the simulation), colour, course, flicker",
    )
    instrument: list[InstrumentValue] = Field(
        default=[], description="values of the last model that belong to the instrument"
    )
    asked: str = Field(
        default="", description="rig, tissue, and all else that was said, in one line"
    )
    prior: dict[str, float] = Field(
        default={},
        description="odds of effects or families before the measurement, as they were given",
    )
    sentences: list[str] = Field(
        default=[], description="the answer in words: verdict, effects, errors, what to record next"
    )
    values: list[Value] = Field(default=[], description="of the last model")
    correlations: list[list[Number]] = Field(
        default=[], description="of the errors of `values`, in their order"
    )
    says: dict[str, str] = Field(
        default={},
        description="what the values of each effect of the likely models mean, in few words",
    )
    errors: Errors | None = None
    shape: ShapeAnswer | None = Field(
        default=None,
        description="the missing force as a free function; null where none leaves noise only, in "
        "held-out parts, too, and where the verdict is not unexplained",
    )
    seconds: float = Field(description="time that the analysis took")
    compared: Step | None = Field(
        default=None,
        description="the model that compare printed and drew, as it was fitted or held; else null",
    )


def answer(diagnosis: Diagnosis, compared: Fit | None = None) -> Answer:
    """Put a diagnosis, and the model that was compared, into the layout for programs."""
    ladder = diagnosis.ladder
    spoilt = [
        Candidate(
            effect=name, family="data", heldout_rmse=None, rmse=None, gain=None, probability=1.0,
            parameters={}, converged=True,
        )
        for name in diagnosis.spoilt
    ]  # fmt: skip
    base, final = ladder.base, ladder.final
    return Answer(
        verdict=diagnosis.verdict,
        output=Output(quantity=base.output.name, unit=base.output.unit),
        ranking=[*spoilt, *(_candidate(diagnosis, fit) for fit in ladder.ranking)],
        models=_models(diagnosis),
        families=ladder.posterior.families,
        family=ladder.family,
        indistinguishable=list(diagnosis.indistinguishable),
        alternatives=[list(names) for names in ladder.alternatives],
        unseen=list(diagnosis.unseen),
        effects=list(diagnosis.effects),
        rmse=Rmse(
            training=ErrorPair(base=base.rmse, final=final.rmse),
            heldout=ErrorPair(base=diagnosis.heldout(base), final=diagnosis.heldout(final)),
        ),
        noise_floor=base.noise,
        ladder=[step(fit, diagnosis.heldout(fit)) for fit in (base, *ladder.steps)],
        suggested_excitation=_experiment(diagnosis),
        carries_over=diagnosis.carries_over if diagnosis.validated else None,
        findings=[finding.sentence for finding in diagnosis.findings],
        revisions=list(diagnosis.revisions),
        instrument=[_of_instrument(value) for value in diagnosis.instrument],
        values=values(final),
        correlations=correlations(final),
        says=says(ladder),
        errors=errors(diagnosis),
        shape=shape(diagnosis.shape),
        seconds=diagnosis.seconds,
        compared=None if compared is None else step(compared, compared.heldout_rmse),
    )


def values(fit: Fit) -> list[Value]:
    """Put the values of a model, but those held, into the layout for programs."""
    deviations, named = fit.deviations(), fit.named()
    return [
        Value(
            name=e.name,
            value=named[e.name],
            deviation=deviations[e.name],
            unit=e.unit,
            at_limit=e.name in fit.exhausted,
            low=named[e.name] - SIDE * deviations[e.name],
            high=named[e.name] + SIDE * deviations[e.name],
            start=e.default,
            lower=e.lower,
            upper=e.upper,
        )
        for e in fit.entries
        if deviations[e.name] > 0.0
    ]


def correlations(fit: Fit) -> list[list[Number]]:
    """Return the correlations of the errors of ``values``."""
    deviations = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    known = fit.deviations()
    kept = [n for n, name in enumerate(fit.names) if known[name] > 0.0]
    spread = np.where(deviations > 0.0, deviations, np.inf)
    found = fit.covariance / np.outer(spread, spread)
    rows: list[list[Number]] = found[np.ix_(kept, kept)].tolist()
    return rows


def says(ladder: Ladder) -> dict[str, str]:
    """Return what the values of each effect of the likely models mean, in a few words."""
    found: dict[str, str] = {}
    for fit in ladder.rivals or ladder.steps[-1:]:
        more, named = ladder.posterior.more(fit), fit.named()
        for each in fit.composition.effects:
            if each.name in more:
                found.setdefault(each.name, each.told(named))
    return {name: words for name, words in found.items() if words}


def errors(diagnosis: Diagnosis) -> Errors:
    """Put the errors of the last model into the layout for programs."""
    final = diagnosis.ladder.final
    second = diagnosis.heldout(final) if diagnosis.validated else math.nan
    of_second = second / diagnosis.validation_noise
    return Errors(
        fitted=final.rmse,
        heldout=final.heldout_rmse,
        second=second,
        noise=final.noise,
        second_noise=diagnosis.validation_noise,
        over_noise=of_second if diagnosis.validated else final.rmse / final.noise,
    )


def shape(found: FoundShape | None) -> ShapeAnswer | None:
    """Put the shape of a missing force into the layout for programs; None where none is claimed."""
    if found is None or not found.accepted:
        return None
    return ShapeAnswer(
        variables=list(found.variables),
        share=found.share,
        shares={
            name: VariableShare(alone=each.alone, beyond=each.beyond)
            for name, each in found.shares.items()
        },
        told=found.told,
        alternatives=[list(each) for each in found.rivals],
        beside=list(found.fit.composition.names),
        over_noise=found.ratio,
        heldout_over_noise=found.heldout,
        curve=_curve(found.curve),
        surface=_surface(found.curve),
        formula=_formula(found.formula),
    )


def _curve(drawn: Curve | None) -> ShapeCurve | None:
    if drawn is None or len(drawn.variables) > 1:
        return None
    return ShapeCurve(
        variable=drawn.variables[0],
        grid=drawn.grid[0].tolist(),
        value=drawn.value.tolist(),
        sd=drawn.sd.tolist(),
    )


def _surface(drawn: Curve | None) -> ShapeSurface | None:
    if drawn is None or len(drawn.variables) == 1:
        return None
    return ShapeSurface(
        variables=list(drawn.variables),
        grid=[each.tolist() for each in drawn.grid],
        value=drawn.value.tolist(),
        sd=drawn.sd.tolist(),
        visited=drawn.visited.tolist(),
    )


def _formula(found: Formula | None) -> ShapeFormula | None:
    if found is None:
        return None
    return ShapeFormula(
        formula=found.text,
        constants=[
            FormulaConstant(name=c.name, unit=c.unit, value=c.value, low=c.low, high=c.high)
            for c in found.constants
        ],
        probability=found.probability,
        rivals=list(found.rivals),
    )


def _of_instrument(found: Found) -> InstrumentValue:
    return InstrumentValue(
        name=found.name,
        unit=found.unit,
        recording=found.recording,
        part=found.part,
        value=found.value,
        deviation=found.deviation,
        degenerate_with=list(found.degenerate_with),
    )


def _experiment(diagnosis: Diagnosis) -> Experiment | None:
    suggestion, command = diagnosis.suggestion, diagnosis.command
    if suggestion is None:
        return None
    return Experiment(
        excitation=dict(suggestion.excitation),
        preload=suggestion.preload,
        duration=suggestion.duration,
        separation=suggestion.separation,
        shows=list(suggestion.shows),
        calibration=suggestion.calibration,
        command=command.line if command else "",
        command_notes=list(command.notes) if command else [],
    )


def step(fit: Fit, heldout: float) -> Step:
    """Put one model of a ladder into the layout for programs."""
    return Step(
        effects=list(fit.composition.names),
        parameters=parameters(fit),
        rmse_training=fit.rmse,
        rmse_heldout=heldout,
        converged=fit.converged,
    )


def parameters(fit: Fit) -> dict[str, ParameterValue]:
    """Fitted values by name."""
    deviations = fit.deviations()
    return {
        entry.name: ParameterValue(
            value=fit.named()[entry.name],
            deviation=deviations[entry.name],
            unit=entry.unit,
            at_limit=entry.name in fit.exhausted,
        )
        for entry in fit.entries
    }


def _models(diagnosis: Diagnosis) -> list[ModelAnswer]:
    told = diagnosis.ladder.posterior
    every = list(zip(told.models, told.probabilities, strict=True))
    return [
        ModelAnswer(
            effects=list(told.more(fit)),
            probability=probability,
            adequacy=adequacy(fit),
            heldout_rmse=diagnosis.heldout(fit),
        )
        for number, (fit, probability) in enumerate(every)
        if number < len(told.likely) or probability > LEAST_TOLD
    ]


def _candidate(diagnosis: Diagnosis, fit: Fit) -> Candidate:
    ladder = diagnosis.ladder
    others = {entry.name for entry in fit.composition.without(find_added_effect(fit).name).values}
    values = parameters(fit)
    kept = set(fit.names) - others | {"stiffness", "damping"}
    return Candidate(
        effect=find_added_effect(fit).name,
        family=find_added_effect(fit).family,
        heldout_rmse=diagnosis.heldout(fit),
        rmse=fit.rmse,
        gain=diagnosis.ladder.base.bic - fit.bic,
        probability=None if ladder.asked else ladder.posterior.effect(find_added_effect(fit).name),
        parameters={name: value for name, value in values.items() if name in kept},
        converged=fit.converged,
    )


if __name__ == "__main__":
    print(json.dumps(Answer.model_json_schema(), indent=2))
