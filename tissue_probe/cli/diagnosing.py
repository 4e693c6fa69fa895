"""What ``compare``, ``diagnose`` and ``improve`` share: the model asked about, the verdict.

What belongs here: options on the instrument, and from files to a diagnosis.
What does not: options on measured data (``measured``), what one command prints.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tissue_probe.cli.arguments import in_a_folder
from tissue_probe.cli.measured import Segment, Starts

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tissue_probe.diagnosis.diagnosis import Diagnosis
    from tissue_probe.diagnosis.fit import Fit
    from tissue_probe.diagnosis.localise import Localisation
    from tissue_probe.diagnosis.measurement import Instrument, Measurement
    from tissue_probe.diagnosis.residual_test import ResidualTest
    from tissue_probe.diagnosis.separation import Suggestion
    from tissue_probe.physics.model_file import FittedModel
    from tissue_probe.quantities import Quantity


class RigName(str, Enum):
    """How the instrument couples to the tissue."""

    compliant_probe = "compliant_probe"
    rigid_probe = "rigid_probe"
    force_driven = "force_driven"


class TissueName(str, Enum):
    """Table I of the paper."""

    kelvin_voigt = "kelvin_voigt"
    maxwell = "maxwell"
    standard_linear_solid = "standard_linear_solid"
    generalized_maxwell = "generalized_maxwell"


#: What may be known of the tissue, such as that there is none.
TISSUE = ("stiffness", "damping")
#: Known of a rig beside its constants: rms of the 1/f noise over a recording [N].
FLICKER = "flicker_noise"
#: Said of a value that the rig's tolerance lets go no farther.
AT_LIMIT = ", at its limit"
#: Said of samples that the converter spoilt.
LEFT_OUT = "The samples concerned were left out."

Rig = Annotated[
    RigName | None,
    typer.Option(
        help="How the instrument couples to the tissue; in force_driven the force is the input, "
        "and the position is predicted.",
        show_default="that of --model, else compliant_probe",
    ),
]
TissueOption = Annotated[
    TissueName | None,
    typer.Option(
        "--tissue",
        help="The model to begin with.",
        show_default="that of --model, else kelvin_voigt",
    ),
]
ModelOption = Annotated[
    Path | None,
    typer.Option(
        "--model",
        metavar="FILE",
        help="Begin with this model.yaml, in place of rig and tissue: its values are fitted again.",
    ),
]
KnownRig = Annotated[
    bool, typer.Option("--known-rig", help="Take the rig's constants as exactly known.")
]
Constants = Annotated[
    list[str] | None,
    typer.Option(
        "--constant",
        metavar="NAME=VALUE[+-SD]",
        help="A constant of the rig and its standard deviation (one; what is printed after +- is a "
        "95 % interval), SI units, such as tip_mass=0.04+-0.001, or what is known of the tissue, "
        "such as stiffness=0; may be given several times.",
    ),
]
EffectFiles = Annotated[
    list[Path] | None,
    typer.Option("--effects", metavar="FILE", help="Python file with effects of your own."),
]
Validate = Annotated[
    list[Path] | None,
    typer.Option(
        "--validate",
        metavar="FILE",
        help="Another recording of the same specimen: models are tried on it, not fitted.",
    ),
]
Json = Annotated[
    Path | None,
    typer.Option(
        "--json", metavar="FILE", callback=in_a_folder, help="Write the answer for programs."
    ),
]


def begun(
    file: Path | None,
    rig: RigName | None,
    tissue: TissueName | None,
    effect_files: Sequence[Path],
) -> FittedModel:
    """Return the model to begin with: that of a file, or of a rig and a tissue without numbers.

    Parameters
    ----------
    file : Path or None
        A model.yaml.
    rig, tissue
        As asked for; without a file the paper's where they are not.
    effect_files : sequence of Path
        Python files with effects of the user's own.

    Raises
    ------
    ValueError
        If the file is no model, or of another rig or tissue than is asked for.
    """
    from tissue_probe.physics.composition import Composition
    from tissue_probe.physics.model_file import FittedModel, load

    if file is None:
        plain = Composition(
            (rig or RigName.compliant_probe).value, (tissue or TissueName.kelvin_voigt).value
        )
        return FittedModel(plain, {}, {}, effect_files=tuple(effect_files))
    model = load(file, effect_files)
    for option, asked, own in (
        ("--rig", rig, model.composition.rig),
        ("--tissue", tissue, model.composition.tissue),
    ):
        if asked and asked.value != own:
            raise ValueError(
                f"{option} {asked.value} contradicts --model {file}, which is of a {own}; leave "
                "out one of them"
            )
    if model.data and not model.data.converged:
        print(f"note: {file}: the search for its values did not settle; take them for a guess")
    return model


def check_validation(files: Sequence[Path], validate: Sequence[Path]) -> None:
    """Refuse to try models on the recording that they are fitted to.

    Raises
    ------
    ValueError
        If a file is given for both.
    """
    fitted = {path.resolve() for path in files}
    for path in validate:
        if path.resolve() in fitted:
            raise ValueError(
                f"--validate {path} is what is fitted; give another recording of the same specimen"
            )


def instrument(rig: str, known: bool, constants: Sequence[str]) -> Instrument:
    """Return the rig's constants, those of the paper unless others are given.

    Raises
    ------
    ValueError
        If a constant is not one of the rig's, or is not a number within its bounds.
    """
    from tissue_probe.diagnosis.measurement import KNOWN, Instrument
    from tissue_probe.physics.composition import Composition

    values = dict(KNOWN[rig])
    flicker_noise = None
    for text in constants:
        name, _, number = text.partition("=")
        value, _, deviation = number.partition("+-")
        if name not in (*values, *TISSUE, FLICKER):
            raise ValueError(
                f"--constant {text}: {name} is no constant of {rig}; "
                f"give one of {', '.join((*values, *TISSUE, FLICKER))}"
            )
        try:
            if name == FLICKER:
                flicker_noise = float(value)
            else:
                values[name] = (float(value), float(deviation or 0.0))
        except ValueError:
            raise ValueError(
                f"--constant {text}: give NAME=VALUE+-SD, such as tip_mass=0.04+-0.001"
            ) from None
        if name == FLICKER:
            if not 0.0 <= flicker_noise < float("inf"):
                raise ValueError(f"--constant {text}: give its rms in newtons, 0 or more")
            continue
        (entry,) = Composition(rig).entries([name])
        if not entry.lower <= values[name][0] <= entry.upper:
            raise ValueError(
                f"--constant {text}: {name} of {rig} lies from {entry.lower:g} to "
                f"{entry.upper:g} {entry.unit}; give one that does"
            )
    chosen = Instrument(rig, values, flicker_noise)
    return chosen.exact() if known else chosen


def measurements(segments: Sequence[Segment], output: Quantity) -> list[Measurement]:
    """Make of what was read what is fitted; prints what was done to read it.

    Parameters
    ----------
    segments : sequence of Segment
        What was read.
    output : Quantity
        What the rig's models predict of it.

    Raises
    ------
    ValueError
        If the samples are such that any fit would be worthless.
    """
    from tissue_probe.diagnosis.driver_command import coil_gain
    from tissue_probe.diagnosis.inspection import inspect
    from tissue_probe.diagnosis.measurement import Measurement

    found = []
    for each in segments:
        for note in each.notes:
            print(f"note: {note}")
        for finding in inspect(each.position, each.force, each.sample_period).findings:
            if finding.fatal:
                raise ValueError(f"{each.source}: {finding.sentence}")
            print(f"note: {each.source}: {finding.sentence}")
        rested = each.starts is Starts.at_rest
        found.append(
            Measurement(
                each.position,
                each.force,
                each.sample_period,
                rested,
                used=each.measured,
                output=output,
                coil_gain=coil_gain(each.position, each.command),
                notes=each.notes,
                source=each.source,
            )
        )
    return found


def note_fit(base: Fit, final: Fit) -> None:
    """Print what a fit tells of the measurements: no contact, wrong units."""
    from tissue_probe.diagnosis.fit_checks import check_fit

    for finding in check_fit(base, final):
        print(f"note: {finding.sentence}")


def tell(diagnosis: Diagnosis) -> None:
    """Print the verdict, and what runs the next experiment: a line that can be pasted."""
    for sentence in verdict(diagnosis):
        print(sentence)
    if diagnosis.command:
        print("The next experiment's command line:", diagnosis.command.line, sep="\n")
        for note in diagnosis.command.notes:
            print(f"- {note}")


def verdict(diagnosis: Diagnosis) -> list[str]:
    """Say the verdict in words, a sentence or more each."""
    said = {
        "adequate": _adequate,
        "missing": _missing,
        "ambiguous": _ambiguous,
        "unexplained": _unexplained,
    }[diagnosis.verdict](diagnosis)
    said += _caveats(diagnosis)
    if diagnosis.suggestion:
        said += _advice(diagnosis.suggestion)
    return said


def _advice(suggestion: Suggestion) -> list[str]:
    """Say what to record or to calibrate next."""
    said = []
    if suggestion.excitation:
        told = ", ".join(f"{name} {value}" for name, value in settings(suggestion).items())
        said.append(f"Next experiment: {told}.")
        if math.isfinite(suggestion.separation):
            said.append(
                f"In it the wrong one would leave {suggestion.separation:.3g} times the noise."
            )
    if suggestion.shows:
        said.append(f"It would show {', '.join(suggestion.shows)} if there.")
    if suggestion.calibration:
        what = "show others" if suggestion.shows else "tell"
        said.append(f"Calibration that would {what}: {suggestion.calibration}.")
    return said


#: Units of an excitation's settings.
UNITS = {"frequency": " Hz", "start": " Hz", "stop": " Hz", "spacing": " Hz"}


def settings(suggestion: Suggestion) -> dict[str, str]:
    """Return the settings of a suggested experiment with their units, by name.

    The amplitude is the coil's way; the volts that it takes are in ``Diagnosis.command``.
    """
    told = {
        name: f"{value}{UNITS.get(name, '')}"
        for name, value in suggestion.excitation.items()
        if name not in ("amplitude", "duration")
    }
    amplitude = 1e3 * float(str(suggestion.excitation["amplitude"]))
    return {
        **told,
        "amplitude": f"{amplitude:g} mm at the coil",
        "preload": f"{1e3 * suggestion.preload:g} mm",
        "duration": f"{suggestion.duration:g} s from rest",
    }


def _adequate(diagnosis: Diagnosis) -> list[str]:
    final = diagnosis.ladder.final
    said = [
        "Adequate: nothing is missing that this recording could show; the error is "
        f"{final.rmse / final.noise:.2f} times the noise, {final.ratio:.2f} times where known 1/f "
        "noise and rounding count as noise."
    ]
    return said + _unseen(diagnosis)


def _unseen(diagnosis: Diagnosis) -> list[str]:
    if not diagnosis.unseen:
        return []
    return [f"This excitation could not have shown: {', '.join(diagnosis.unseen)}."]


def _missing(diagnosis: Diagnosis) -> list[str]:
    final = diagnosis.ladder.final
    told = _fall(diagnosis)
    if not diagnosis.ladder.steps:
        told = (
            f"{LEFT_OUT} On the others the model is adequate: its error is "
            f"{final.rmse / final.noise:.2f} times the noise."
        )
    return [f"Missing: {', '.join(diagnosis.effects)}. {told}", *_unseen(diagnosis)]


def _ambiguous(diagnosis: Diagnosis) -> list[str]:
    models = [" + ".join(names) for names in diagnosis.ladder.alternatives]
    said = f"One of {', '.join(models)}: this recording cannot tell which. {_fall(diagnosis)}"
    return [said, *_unseen(diagnosis)]


def _unexplained(diagnosis: Diagnosis) -> list[str]:
    said = "Unexplained: no effect of the library brings the error down to the noise. "
    if diagnosis.ladder.harmonic is not None:
        said = (
            f"Unexplained: a line at {diagnosis.ladder.harmonic:.4g} Hz, a multiple of the drive's "
            "frequency, explains more than any effect of the library; whatever is not linear "
            "leaves such lines. Drive at several frequencies to tell, as by a multisine. "
        )
    if diagnosis.ladder.asked:
        said = (
            f"Unexplained: with {', '.join(diagnosis.effects)} more is left than noise; other "
            f"effects were not tried. {_fall(diagnosis)}"
        )
    else:
        said += _nearest(diagnosis)
    return [said.strip()]


def _nearest(diagnosis: Diagnosis) -> str:
    """Say which effects come nearest where none explains all, if they help at all."""
    ladder, names = diagnosis.ladder, ", ".join(diagnosis.effects)
    if not ladder.steps:
        return f"In the samples: {names}. {LEFT_OUT}" if diagnosis.spoilt else ""
    if diagnosis.heldout(ladder.final) <= diagnosis.heldout(ladder.base):
        return f"Nearest: {names}. {_fall(diagnosis)}"
    # Not all of the ranking is tried on a second recording.
    tried = [
        fit
        for fit in ladder.ranking
        if not diagnosis.validated or fit.composition.names in diagnosis.validated
    ]
    if any(diagnosis.heldout(fit) < diagnosis.heldout(ladder.base) for fit in tried):
        return f"What fits best, {names}, raises the error on held-out data. {_fall(diagnosis)}"
    return f"No effect lowers the error on held-out data. With {names}: {_fall(diagnosis)}"


def _caveats(diagnosis: Diagnosis) -> list[str]:
    """Say what speaks against trusting the last model."""
    said = []
    final = diagnosis.ladder.final
    if not final.converged:
        said.append(
            "But the fit of the last model did not settle: take its values, its error and with "
            "them this verdict for a guess."
        )
    return said + _beyond(diagnosis)


def _beyond(diagnosis: Diagnosis) -> list[str]:
    """Say how the last model fares on a second recording, where that is not as on the first."""
    final = diagnosis.ladder.final
    error = final.output.tell(diagnosis.heldout(final))
    noise = final.output.tell(diagnosis.validation_noise)
    if not diagnosis.carries_over:
        return [
            f"But on the second recording the error stays at {error}, where the noise is {noise}: "
            "the model does not carry over. Either the specimen, the site or the contact is "
            "another one there, or more is missing than the first recording shows; record again, "
            "or fit both together."
        ]
    if not diagnosis.reaches:
        expected = final.output.tell(diagnosis.uncertainty)
        return [
            f"On the second recording the error is {error}, where the noise is {noise}: the first "
            f"tells the values so roughly that {expected} are to be expected there. Fit both "
            "together."
        ]
    return []


def _fall(diagnosis: Diagnosis) -> str:
    base, final = diagnosis.ladder.base, diagnosis.ladder.final
    before, after, noise = (
        base.output.tell(error)
        for error in (diagnosis.heldout(base), diagnosis.heldout(final), base.noise)
    )
    return f"The held-out error goes from {before} to {after}; the noise is {noise}."


def title(fit: Fit) -> str:
    """Name a model by what it consists of."""
    names = {"kelvin_voigt": "Kelvin-Voigt", "maxwell": "Maxwell"}
    tissue = names.get(fit.composition.tissue, "Kelvin-Voigt")
    return " + ".join([tissue, *fit.composition.names])


def table(fit: Fit) -> list[tuple[str, str, str]]:
    """Return the name of every fitted value, itself with its 95 % interval, and its unit."""
    deviations, values = fit.deviations(), fit.named()
    fitted = [entry for entry in fit.composition.values if deviations[entry.name] > 0]
    return [
        (e.name, f"{values[e.name]:.5g} +- {1.96 * deviations[e.name]:.2g}", e.unit) for e in fitted
    ]


def exhaustion(fits: Sequence[Fit]) -> str:
    """Say what it means that values are at their limit; empty where none is."""
    from tissue_probe.diagnosis.problem import FARTHEST

    if not any(fit.exhausted for fit in fits):
        return ""
    return (
        f"At its limit is what lies {FARTHEST:g} standard deviations of the rig's tolerance off, "
        "where its search ends: something is missing in the model, or the stated tolerance "
        "(--constant) is too small; its interval says nothing."
    )


def where(fit: Fit, index: int) -> Localisation:
    """Say where in one of its measurements a model fails."""
    from tissue_probe.diagnosis.localise import localise

    shown = fit.measurements[index]
    return localise(
        fit.evened[index], shown.position, fit.tip[index], shown.sample_period, shown.noise
    )


def tests(fit: Fit, index: int) -> tuple[ResidualTest, ...]:
    """Test what a model leaves of one of its measurements."""
    from tissue_probe.diagnosis.residuals import residual_tests

    shown = fit.measurements[index]
    return residual_tests(
        fit.evened[index], shown.input_values, shown.sample_period, shown.noise, fit.output
    )


def stretch(fit: Fit, index: int, sources: Sequence[str]) -> str:
    """Say which of several measurements is shown; empty where there is one only."""
    if len(sources) == 1:
        return ""
    number = f"stretch {index + 1} of {len(sources)}, that with most of the error"
    return f"{Path(sources[index]).name} ({number})"


def picture(fit: Fit, index: int, sources: Sequence[str]) -> Figure:
    """Draw a comparison of one of the measurements with what a model predicts of it."""
    from tissue_probe.figures.compare import draw_comparison

    shown = fit.measurements[index]
    return draw_comparison(
        shown.times,
        shown.output_values,
        fit.predicted[index],
        where(fit, index),
        shown.noise,
        fit.output,
        shown.used,
        stretch(fit, index, sources),
    )


def held(model: FittedModel, taken: Sequence[Measurement]) -> Fit:
    """Return a model file's model on what was read: only the state at the start is fitted.

    Raises
    ------
    ValueError
        If it cannot be simulated on these measurements.
    """
    from tissue_probe.diagnosis.coloured import whitened
    from tissue_probe.diagnosis.diagnosis import cleaned
    from tissue_probe.diagnosis.measurement import Instrument
    from tissue_probe.diagnosis.problem import Problem
    from tissue_probe.diagnosis.search import search

    rig = Instrument(model.composition.rig, {})
    problem = Problem(model.composition, cleaned(taken)[0], rig, model.values)
    fit = search(problem, problem.nominal, [begun.mean for begun in problem.begin(problem.nominal)])
    if fit is None:
        raise ValueError(
            "--model: it diverges on these measurements; was it fitted to other units?"
        )
    return whitened(fit, rig, model.values)


def diagnosis(
    segments: Sequence[Segment],
    validation: Sequence[Segment],
    model: FittedModel,
    known: Instrument,
    add: Sequence[str] = (),
) -> Diagnosis:
    """Diagnose what was read, with effects of the library and of the user's files.

    Raises
    ------
    ValueError
        If the samples are worthless, or an effect is not known, or in the model already.
    """
    from tissue_probe.diagnosis.diagnosis import diagnose
    from tissue_probe.physics.library import effects

    composition = model.composition
    library = effects(model.effect_files)
    for name in add:
        if name not in library:
            raise ValueError(f"--add {name}: no such effect; known are {', '.join(library)}")
        if name in composition.names:
            raise ValueError(f"--add {name}: the model has it already; leave it out")
    taken, tried = (measurements(each, composition.output) for each in (segments, validation))
    found = diagnose(composition, taken, known, library, tried, tuple(add), model.values)
    note_fit(found.ladder.base, found.ladder.final)
    return found


def write_answer(
    path: Path,
    compared: Fit,
    model: FittedModel,
    taken: Sequence[Measurement],
    known: Instrument,
) -> None:
    """Diagnose what was measured with the model of a fit, and write the answer for programs."""
    from tissue_probe.diagnosis.answer import answer
    from tissue_probe.diagnosis.diagnosis import diagnose
    from tissue_probe.physics.library import effects

    library = effects(model.effect_files)
    found = diagnose(model.composition, taken, known, library, begin_at=model.values)
    told = answer(found, compared)
    path.write_text(told.model_dump_json(indent=2) + "\n", encoding="utf-8")
