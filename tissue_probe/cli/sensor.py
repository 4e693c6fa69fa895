"""``tissue_probe sensor``: a robot's force sensor in free air."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli.groups import add_groups
from tissue_probe.cli.question_options import Json, write_json


@add_groups
def sensor(
    samples: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="Bag or table of poses and wrenches, 30 to 60 s in free air."
        ),
    ],
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", help="YAML file of the model, for the node sensor."
        ),
    ] = Path("sensor.yaml"),
    pose: Annotated[
        str | None, typer.Option(metavar="TOPIC", help="Of the poses, if a bag has several.")
    ] = None,
    wrench: Annotated[
        str | None, typer.Option(metavar="TOPIC", help="Of the wrench, if a bag has several.")
    ] = None,
    joint: Annotated[
        list[str] | None,
        typer.Option(
            "--joint",
            metavar="NAME",
            help="Joint that a cable runs along, three at most; by default a cable is a function "
            "of the pose.",
        ),
    ] = None,
    json: Json = None,
) -> None:
    """Identify a robot's force sensor in free air.

    Tells mass, centre and inertia of the tool on the sensor, biases and their drift, gains of the
    axes against one another, delay, noise, and a cable's force, each with its standard deviation;
    and the numbers that cannot be told, with the poses that would tell them.
    """
    from tissue_probe.analysis.sensing import identify_sensor

    samples.stat()
    if output.exists() and output.samefile(samples):
        raise ValueError(f"{output} holds the samples and would be replaced: give another --output")
    result = identify_sensor(samples, pose=pose, wrench=wrench, joints=joint or [])
    result.save(output)
    if json:
        write_json(json, result.to_dict())
    print(result.text)
    print(f"The model is in {output}")
