"""``tissue_probe modulus``: a fitted stiffness as a modulus in kPa."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer


class TipShape(str, Enum):
    """Shape of the tip."""

    flat = "flat"
    sphere = "sphere"
    cone = "cone"


Length = Annotated[
    str | None,
    typer.Option(
        metavar="LENGTH", help="Of punch or sphere: 3mm, or in metres.", show_default=False
    ),
]


def modulus(
    model: Annotated[Path, typer.Argument(help="Model file with values.", metavar="MODEL")],
    indenter: Annotated[TipShape, typer.Option(help="Shape of the tip.")],
    radius: Length = None,
    half_angle: Annotated[
        float | None,
        typer.Option(metavar="DEGREES", help="Of a cone, from its axis.", show_default=False),
    ] = None,
    poisson: Annotated[float, typer.Option(help="Poisson's ratio of the tissue.")] = 0.5,
    layer: Annotated[
        str | None,
        typer.Option(
            metavar="LENGTH",
            help="Height of a layer bonded to a hard base, under a sphere.",
            show_default=False,
        ),
    ] = None,
    depth: Annotated[
        str | None,
        typer.Option(
            metavar="LENGTH",
            help="Depth from the touch; of a straight model that at which the tip moved.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Turn a fitted stiffness into a modulus in kPa.

    By the laws of Hertz (sphere), Sneddon (flat punch, cone) and Dimitriadis (sphere on a thin
    layer).
    """
    from tissue_probe.analysis.modulus import modulus as found

    print(
        found(
            model,
            indenter.value,
            radius=_metres("radius", radius),
            half_angle=half_angle,
            poisson=poisson,
            layer=_metres("layer", layer),
            depth=_metres("depth", depth),
        )
    )


def _metres(name: str, written: str | None) -> float | None:
    """Return a length that is written with its unit, or in metres.

    Raises
    ------
    ValueError
        If it is neither.
    """
    from tissue_probe.recording.units import POSITION_UNITS

    if written is None:
        return None
    for unit in sorted(POSITION_UNITS, key=len, reverse=True):
        if written.endswith(unit):
            number, size = written.removesuffix(unit), POSITION_UNITS[unit]
            break
    else:
        number, size = written, 1.0
    try:
        return float(number) * size
    except ValueError:
        raise ValueError(f"--{name} {written}: give a length such as 3mm, or in metres") from None
