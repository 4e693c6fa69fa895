"""``tissue_probe mujoco``: a measured contact in a model of MuJoCo."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli.arguments import output_file


def mujoco(
    contact: Annotated[
        Path, typer.Argument(metavar="CONTACT", help="File of the command contact.")
    ],
    model: Annotated[Path, typer.Option(metavar="FILE", help="Your model, in MJCF.")],
    tip: Annotated[str, typer.Option(metavar="GEOM", help="Name of the tip's geom.")],
    tissue: Annotated[str, typer.Option(metavar="GEOM", help="Name of the tissue's geom.")],
    output: Annotated[Path, output_file("MJCF file to write, which your model includes.")] = Path(
        "contact.xml"
    ),
) -> None:
    """Give geoms in MuJoCo a measured contact.

    Writes a pair of geoms with solref and solimp, by the weights of the bodies as MuJoCo compiles
    them. MuJoCo must be installed.
    """
    from tissue_probe.analysis.contact_export import mujoco_contact

    result = mujoco_contact(contact, model, tip=tip, tissue=tissue)
    result.save(output)
    print(result.text)
    print(f'The contact is in {output}: write <include file="{output.name}"/> into {model}.')
