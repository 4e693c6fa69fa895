"""``tissue_probe admittance``: gains of an admittance controller for a measured contact."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli.arguments import output_file

Contacts = Annotated[
    list[Path],
    typer.Argument(metavar="CONTACT...", help="Files of the command contact, of one tissue each."),
]


class Axis(str, Enum):
    """Axes of the control frame."""

    x = "x"
    y = "y"
    z = "z"
    rx = "rx"
    ry = "ry"
    rz = "rz"


def admittance(
    contacts: Contacts,
    mass: Annotated[float, typer.Option(metavar="KG", help="Virtual mass.")],
    stiffness: Annotated[
        float,
        typer.Option(metavar="N/M", help="Of the spring that draws back to the commanded pose."),
    ],
    delay: Annotated[
        float,
        typer.Option(
            metavar="SECONDS",
            help="From a motion to the force that the controller uses: sensor, filter, bus, and "
            "one and a half of its periods.",
        ),
    ],
    lag: Annotated[
        float, typer.Option(metavar="SECONDS", help="Time constant of the robot's position loop.")
    ] = 0.0,
    stiffest: Annotated[
        str | None,
        typer.Option(
            metavar="N/M or FILE",
            help="Stiffness that is known otherwise; or a map, by the file of `map --json`.",
        ),
    ] = None,
    gain_margin: Annotated[
        float, typer.Option(metavar="FACTOR", help="By which tissue may be stiffer.")
    ] = 2.0,
    phase_margin: Annotated[
        float, typer.Option(metavar="DEGREES", help="By which the loop may turn further.")
    ] = 45.0,
    axis: Annotated[
        list[Axis] | None,
        typer.Option(help="Axis along which the robot yields; may be given several times; else z."),
    ] = None,
    frame: Annotated[
        str, typer.Option(metavar="FRAME", help="The control frame, whose axes these are.")
    ] = "tool0",
    node: Annotated[
        str, typer.Option(metavar="NAME", help="Name of the controller.")
    ] = "admittance_controller",
    output: Annotated[Path, output_file("YAML file to write.")] = Path("admittance.yaml"),
) -> None:
    """Choose an admittance's gains for a contact.

    For ros2_controllers' admittance_controller: the least damping with which the loop of
    admittance, delay, position loop and tissue keeps the margins.
    """
    from tissue_probe.analysis.contact_export import design_admittance

    result = design_admittance(
        contacts,
        mass=mass,
        stiffness=stiffness,
        delay=delay,
        lag=lag,
        stiffest=_number_or_file(stiffest),
        gain_margin=gain_margin,
        phase_margin=phase_margin,
        axes=[each.value for each in axis or [Axis.z]],
        frame=frame,
        node=node,
    )
    result.save(output)
    print(result.text)
    print(f"The parameters are in {output}.")


def _number_or_file(given: str | None) -> float | str | None:
    try:
        return None if given is None else float(given)
    except ValueError:
        return given
