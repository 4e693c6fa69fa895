"""What ``compare``, ``diagnose`` and ``improve`` share: the model asked about, the diagnosis.

What belongs here: options on the instrument, and from files to a diagnosis.
What does not: options on measured data (``measured``), the verdict in words, what is shown of a fit
(``fit_shown``), what one command prints.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tissue_probe.cli.arguments import in_a_folder
from tissue_probe.cli.measured import Segment, Starts
from tissue_probe.cli.options_named import with_options

if TYPE_CHECKING:
    from tissue_probe.diagnosis.answer import Answer
    from tissue_probe.diagnosis.diagnosis import Diagnosis
    from tissue_probe.diagnosis.fitting.fit import Fit
    from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
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
    from tissue_probe.diagnosis.fitting.measurement import KNOWN, Instrument
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
    from tissue_probe.diagnosis.advice.driver_command import coil_gain
    from tissue_probe.diagnosis.fitting.measurement import Measurement
    from tissue_probe.diagnosis.inspection.inspection import inspect

    found = []
    for each in segments:
        for note in each.notes:
            print(f"note: {note}")
        for finding in inspect(each.position, each.force, each.sample_period).findings:
            if finding.fatal:
                raise ValueError(f"{each.source}: {finding.sentence}")
            print(f"note: {each.source}: {with_options(finding.sentence)}")
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
                run=each.run,
                begins=each.begins,
                time_doubt=each.time_doubt,
            )
        )
    return found


def note_fit(base: Fit, final: Fit) -> None:
    """Print what a fit tells of the measurements: no contact, wrong units."""
    from tissue_probe.diagnosis.fit_checks import check_fit

    for finding in check_fit(base, final):
        print(f"note: {with_options(finding.sentence)}")


def held(model: FittedModel, taken: Sequence[Measurement]) -> Fit:
    """Return a model file's model on what was read: only what belongs to a run is fitted.

    Raises
    ------
    ValueError
        If it cannot be simulated on these measurements.
    """
    from tissue_probe.diagnosis.diagnosis import cleaned
    from tissue_probe.diagnosis.fitting.coloured import whitened
    from tissue_probe.diagnosis.fitting.measurement import Instrument
    from tissue_probe.diagnosis.ranking.carried import carried

    rig = Instrument(model.composition.rig, {})
    fit = carried(model.composition, model.values, cleaned(taken)[0], rig)
    if fit is None:
        raise ValueError(
            "--model: it diverges on these measurements; was it fitted to other units?"
        )
    return whitened(fit, rig, fit.named())


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
    write_json(path, answer(found, compared))


def write_json(path: Path, told: Answer) -> None:
    """Write the answer for programs; in its advice, parameters as the options that state them."""
    path.write_text(with_options(told.model_dump_json(indent=2)) + "\n", encoding="utf-8")
