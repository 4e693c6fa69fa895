"""``tissue_probe improve``: add what is missing, and watch the error fall."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from tissue_probe.cli import diagnosing as asked
from tissue_probe.cli import measured


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
    force_polarity: measured.ForcePolarity = None,
    position_polarity: measured.PositionPolarity = measured.Direction.into,
    topic: measured.SamplesTopic = None,
    site: measured.Site = None,
    lowpass: measured.Lowpass = None,
    starts: measured.StartsOption = measured.Starts.auto,
    rig: asked.Rig = asked.RigName.compliant_probe,
    tissue: asked.TissueOption = asked.TissueName.kelvin_voigt,
    known_rig: asked.KnownRig = False,
    constant: asked.Constants = None,
    effects: asked.EffectFiles = None,
    validate: asked.Validate = None,
    json: asked.Json = None,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FOLDER", help="Where model.yaml, pictures and report go."
        ),
    ] = Path("improved"),
) -> None:
    """Add what is missing, effect by effect, while the error falls.

    Writes model.yaml, which estimators and the simulated probe take, ladder.png, compare.png of the
    base model and report.html, which works off line.
    """
    from tissue_probe.cli.improved import write
    from tissue_probe.diagnosis.answer import answer

    layout = measured.layout(
        position, force, time, sample_rate, position_unit, force_unit, force_polarity,
        position_polarity, topic,
    )  # fmt: skip
    diagnosis = asked.diagnosis(
        measured.read_measured(files, layout, starts, site, lowpass),
        measured.read_measured(validate or [], layout, starts, site, lowpass),
        asked.composition(rig, tissue),
        asked.instrument(rig, known_rig, constant or []),
        effects or [],
        add or [],
    )
    ladder = diagnosis.ladder
    table = Table(title="The ladder", title_justify="left")
    small, per_small = ladder.base.output.small, ladder.base.output.per_small
    for name in ("model", f"error [{small}]", f"held out [{small}]", "error / noise"):
        table.add_column(name, justify="left" if name == "model" else "right")
    for fit in (ladder.base, *ladder.steps):
        table.add_row(
            asked.title(fit),
            f"{per_small * fit.rmse:.4g}",
            f"{per_small * diagnosis.heldout(fit):.4g}",
            f"{fit.ratio:.3g}" + ("" if fit.converged else " (did not settle)"),
        )
    Console(markup=False, highlight=False).print(table)  # units stand in square brackets
    for name, value in asked.table(ladder.final):
        print(f"  {name:26s} {value}")
    for sentence in asked.verdict(diagnosis):
        print(sentence)
    output.mkdir(parents=True, exist_ok=True)
    write(output, diagnosis, files, validate or [], effects or [])
    print(f"model.yaml, ladder.png, compare.png and report.html are in {output}.")
    if json:
        json.write_text(answer(diagnosis).model_dump_json(indent=2) + "\n", encoding="utf-8")
