"""``tissue_probe improve``: add what is missing, and watch the error fall."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.table import Table

from tissue_probe.cli import diagnosing as asked
from tissue_probe.cli import fit_shown, measured
from tissue_probe.cli import verdict_in_words as words
from tissue_probe.cli.arguments import EffectFiles

if TYPE_CHECKING:
    from tissue_probe.diagnosis.diagnosis import Diagnosis
    from tissue_probe.diagnosis.fitting.fit import Fit


def improve(
    files: measured.Measurements,
    add: Annotated[
        list[str] | None,
        typer.Option(metavar="EFFECT", help="Add this effect, instead of what is missing."),
    ] = None,
    position: measured.Position = None,
    force: measured.Force = None,
    time: measured.Time = None,
    sample_rate: measured.SampleRate = None,
    position_unit: measured.PositionUnit = None,
    force_unit: measured.ForceUnit = None,
    time_unit: measured.TimeUnit = None,
    force_polarity: measured.ForcePolarity = None,
    position_polarity: measured.PositionPolarity = measured.Direction.into,
    topic: measured.SamplesTopic = None,
    clock: measured.ClockOption = None,
    site: measured.Site = None,
    lowpass: measured.Lowpass = None,
    starts: measured.StartsOption = measured.Starts.auto,
    rig: asked.Rig = None,
    tissue: asked.TissueOption = None,
    model: asked.ModelOption = None,
    known_rig: asked.KnownRig = False,
    constant: asked.Constants = None,
    effects: EffectFiles = None,
    validate: asked.Validate = None,
    json: asked.Json = None,
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="FOLDER",
            file_okay=False,
            help="Where model.yaml, pictures and report go.",
        ),
    ] = Path("improved"),
) -> None:
    """Add what is missing, effect by effect, while the error falls.

    The ladder's errors are root mean squares; the whitened one counts 1/f noise and an encoder's
    rounding as noise, where they are known, and is 1 where nothing is left to explain.

    Writes model.yaml, which estimators and the simulated probe take, story.png with all on one
    page, ladder.png, compare.png of the base model and report.html, which works off line.
    """
    from tissue_probe.cli.improved import write
    from tissue_probe.diagnosis.answer import answer

    layout = measured.layout(
        position, force, time, sample_rate, position_unit, force_unit, time_unit,
        force_polarity, position_polarity, topic, clock,
    )  # fmt: skip
    asked.check_validation(files, validate or [])
    begun = asked.begun(model, rig, tissue, effects or [])
    segments = measured.read_measured(files, layout, starts, site, lowpass)
    diagnosis = asked.diagnosis(
        segments,
        measured.read_measured(validate or [], layout, starts, site, lowpass),
        begun,
        asked.instrument(begun.composition.rig, known_rig, constant or []),
        add or [],
    )
    ladder = diagnosis.ladder
    steps = (ladder.base, *ladder.steps)
    console = Console(markup=False, highlight=False)  # units stand in square brackets
    console.print(_errors(diagnosis, steps))
    console.print(_values(steps))
    if told := fit_shown.exhaustion(steps):
        print(told)
    words.tell(diagnosis)
    output.mkdir(parents=True, exist_ok=True)
    sources = [segment.source for segment in segments]
    write(output, diagnosis, files, sources, validate or [], begun.effect_files)
    print(f"model.yaml, story.png, ladder.png, compare.png and report.html are in {output}.")
    if json:
        asked.write_json(json, answer(diagnosis))


def _errors(diagnosis: Diagnosis, steps: Sequence[Fit]) -> Table:
    """Return the error of each step beside the noise."""
    output = diagnosis.ladder.base.output
    noise = diagnosis.ladder.final.noise
    table = Table(title=f"The ladder; the noise is {output.tell(noise)}", title_justify="left")
    names = ("", "model", f"error [{output.small}]", f"held out [{output.small}]")
    for name in (*names, "held out / noise"):
        table.add_column(name, justify="left" if name == "model" else "right")
    for number, fit in enumerate(steps):
        heldout = diagnosis.heldout(fit)
        table.add_row(
            str(number),
            fit_shown.title(fit).replace(" + ", "\n+ ")
            + ("" if fit.converged else "\n(did not settle)"),
            f"{output.per_small * fit.rmse:.4g}",
            f"{output.per_small * heldout:.4g}",
            f"{heldout / noise:.3g}",
        )
    return table


def _values(steps: Sequence[Fit]) -> Table:
    """Return what each step was fitted to, a column a step."""
    table = Table(title="Values at each step, +- 95 % intervals", title_justify="left")
    table.add_column("", no_wrap=True)
    for number in range(len(steps)):
        table.add_column(str(number), justify="right")
    table.add_column("unit", no_wrap=True)
    rows: dict[tuple[str, str], list[str]] = {}
    for number, fit in enumerate(steps):
        for name, value, unit in fit_shown.table(fit):
            row = rows.setdefault((name, unit), [""] * len(steps))
            row[number] = value + (fit_shown.AT_LIMIT if name in fit.exhausted else "")
    for (name, unit), row in rows.items():
        table.add_row(name, *row, unit)
    table.add_row("whitened / noise", *(f"{fit.ratio:.3g}" for fit in steps), "1")
    return table
