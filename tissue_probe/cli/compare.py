"""``tissue_probe compare``: measured against predicted force, and where they part."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli import measurement_options
from tissue_probe.cli.arguments import picture
from tissue_probe.cli.groups import add_groups
from tissue_probe.cli.options_named import with_options
from tissue_probe.cli.question_options import Asked, Json, write_json


@add_groups
def compare(
    files: measurement_options.Measurements,
    signals: measurement_options.Signals,
    asked: Asked,
    json: Json = None,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", callback=picture, help="Picture: .png, .svg or .pdf."
        ),
    ] = Path("compare.png"),
) -> None:
    """Compare a model with measurements, and show where it fails.

    The model is fitted first, unless --model names one that was. Errors are of the force, or of the
    position where a force drives; the noise floor is the error of a right model.
    """
    measurement_options.check_there(files)
    layout, keywords = signals.layout(), asked.keywords()
    recordings = measurement_options.read(files, layout)
    # Only now: fits take longer to import than a file takes to be refused.
    from tissue_probe.analysis.comparing import compare as compare_model

    result = compare_model(
        recordings,
        **keywords,
    )
    measurement_options.tell(result.notes)
    print(with_options(result.asked.head))
    # Before the picture, which takes longer than the fit; a pipe would wait for it.
    print(with_options(result.text), flush=True)
    result.plot().savefig(output, dpi=100)
    print(f"The picture is in {output}.")
    if json:
        from tissue_probe.analysis.diagnosing import diagnosis_of

        write_json(json, diagnosis_of(result).to_dict(result))
