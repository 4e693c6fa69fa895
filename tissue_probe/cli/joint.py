"""``tissue_probe joint``: the friction of a driven axis in a model of MuJoCo."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli.arguments import output_file


def joint(
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="model.yaml of the axis in free air.")
    ],
    class_name: Annotated[
        str, typer.Option(metavar="CLASS", help="Name of the class.")
    ] = "identified",
    output: Annotated[Path, output_file("MJCF file to write, which your model includes.")] = Path(
        "joint.xml"
    ),
) -> None:
    """Give joints in MuJoCo an identified friction.

    Writes a class of joints with damping, frictionloss and armature, each with its error.
    """
    from tissue_probe.analysis.joint_export import mujoco_joint

    result = mujoco_joint(model, class_name=class_name)
    result.save(output)
    print(result.text)
    print(
        f'The class is in {output}: write <include file="{output.name}"/> into your model, and '
        f'class="{class_name}" into its joint.'
    )
