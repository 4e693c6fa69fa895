"""``tissue_probe compare``: measured against predicted force, and where they part."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli import diagnosing as asked
from tissue_probe.cli import measured
from tissue_probe.cli.arguments import EffectFiles, picture
from tissue_probe.cli.options_named import with_options


def compare(
    files: measured.Measurements,
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
    course: measured.CourseOption = measured.Course.auto,
    rig: asked.Rig = None,
    tissue: asked.TissueOption = None,
    known_rig: asked.KnownRig = False,
    constant: asked.Constants = None,
    model: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Compare this model.yaml, its values held."),
    ] = None,
    effects: EffectFiles = None,
    json: asked.Json = None,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", callback=picture, help="Picture: .png, .svg or .pdf."
        ),
    ] = Path("compare.png"),
) -> None:
    """Compare a model with measurements, and show where it fails.

    The model is fitted first, unless --model names one that was. Errors are of the force, or of the
    position where a force drives; the noise floor is what a right model would leave.
    """
    measured.check_there(files)
    layout = measured.layout(
        position, force, time, sample_rate, position_unit, force_unit, time_unit,
        force_polarity, position_polarity, topic, clock,
    )  # fmt: skip
    known = asked.constants(constant or [])
    recordings = measured.read(files, layout)
    # Only now: fits take longer to import than a file takes to be refused.
    from tissue_probe.analysis.comparing import compare as compare_model

    result = compare_model(
        recordings,
        model=model,
        rig=asked.name(rig),
        tissue=asked.name(tissue),
        known_rig=known_rig,
        constants=known,
        effects=effects or [],
        starts=starts.value,
        site=site,
        lowpass=lowpass,
        course=course.value,
    )
    measured.tell(result.notes)
    print(with_options(result.text))
    result.plot().savefig(output, dpi=100)
    print(f"The picture is in {output}.")
    if json:
        from tissue_probe.analysis.diagnosing import diagnosis_of

        asked.write_json(json, diagnosis_of(result).to_dict(result))
