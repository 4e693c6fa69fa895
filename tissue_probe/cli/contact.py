"""``tissue_probe contact``: stiffness and damping under a robot's tip."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli import measurement_options
from tissue_probe.cli.arguments import output_file
from tissue_probe.cli.groups import add_groups
from tissue_probe.cli.options_named import with_options
from tissue_probe.cli.question_options import Json, constants, uncertain, write_json


@add_groups
def contact(
    files: measurement_options.Measurements,
    signals: measurement_options.Signals,
    sensor: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Model of the force sensor by the command sensor: states mass, delay and drift.",
        ),
    ] = None,
    delay: Annotated[
        str | None,
        typer.Option(
            metavar="SECONDS[+-SD]",
            help="Of the force after the position, and its standard deviation; fitted by default.",
        ),
    ] = None,
    drift: Annotated[
        str | None,
        typer.Option(
            metavar="N/S[+-SD]",
            help="How fast the force's zero moves, and its standard deviation; fitted by default.",
        ),
    ] = None,
    constant: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE[+-SD]",
            help="tip_mass, contact_position or flicker_noise and its standard deviation, SI "
            "units; may be given several times.",
        ),
    ] = None,
    output: Annotated[
        Path, output_file("YAML file of the contact, for the commands admittance and mujoco.")
    ] = Path("contact.yaml"),
    json: Json = None,
) -> None:
    """Identify a robot's contact: stiffness and damping.

    From recordings in which the tip presses to and fro. The force's zero is fitted; mass, delay and
    drift are fitted, or known within their errors. Numbers that the motion does not tell are named,
    with the remedy.
    """
    measurement_options.check_there(files)
    layout = signals.layout()
    known = constants(constant or [])
    late, drifts = uncertain("--delay", delay), uncertain("--drift", drift)
    recordings = measurement_options.read(files, layout)
    from tissue_probe.analysis.contacting import identify_contact

    result = identify_contact(recordings, delay=late, drift=drifts, sensor=sensor, constants=known)
    measurement_options.tell(result.notes)
    result.save(output)
    if json:
        write_json(json, result.to_dict())
    print(with_options(result.text))
    print(f"The contact is in {output}.")
