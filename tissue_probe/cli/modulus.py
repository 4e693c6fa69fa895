"""``tissue_probe modulus``: a fitted stiffness as a modulus in kPa."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli.question_options import Json, write_json


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
    indenter: Annotated[
        TipShape | None, typer.Option(help="Shape of the tip.", show_default=False)
    ] = None,
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
    gauge_length: Annotated[
        str | None,
        typer.Option(
            metavar="LENGTH",
            help="Of a bar between grips or plates, without load: 20mm, or 20mm+-0.1mm.",
            show_default=False,
        ),
    ] = None,
    area: Annotated[
        str | None,
        typer.Option(
            metavar="AREA",
            help="Of the bar's cross-section: 30mm2, or 30mm2+-1mm2.",
            show_default=False,
        ),
    ] = None,
    frequency: Annotated[
        list[float] | None,
        typer.Option(
            metavar="HZ", help="Tell storage and loss there; repeatable.", show_default=False
        ),
    ] = None,
    json: Json = None,
) -> None:
    """Turn a fitted stiffness into a modulus in kPa.

    Under a tip by the laws of Hertz (sphere), Sneddon (flat punch, cone) and Dimitriadis (sphere on
    a thin layer); of a bar of known gauge length and area by stress over strain.
    """
    from tissue_probe.analysis.modulus import modulus as found

    result = found(
        model,
        indenter.value if indenter else None,
        radius=_metres("radius", radius),
        half_angle=half_angle,
        poisson=poisson,
        layer=_metres("layer", layer),
        depth=_metres("depth", depth),
        gauge_length=_size("gauge-length", gauge_length),
        area=_size("area", area, power=2),
        frequency=frequency or (),
    )
    if json:
        write_json(json, result.to_dict())
    print(result)


def _metres(name: str, written: str | None) -> float | None:
    """Return a length that is written with its unit, or in metres.

    Raises
    ------
    ValueError
        If it is neither.
    """
    if written is None:
        return None
    try:
        return _read(written, _units(1))
    except ValueError:
        raise ValueError(f"--{name} {written}: give a length such as 3mm, or in metres") from None


def _size(name: str, written: str | None, power: int = 1) -> tuple[float, float] | None:
    """Return a length or an area [m, m^2] with its standard deviation, 0 where none is stated.

    Raises
    ------
    ValueError
        If it is neither.
    """
    if written is None:
        return None
    value, given, deviation = written.partition("+-")
    units = _units(power)
    try:
        return _read(value, units), _read(deviation, units) if given else 0.0
    except ValueError:
        form = "20mm or 20mm+-0.1mm" if power == 1 else "30mm2 or 30mm2+-1mm2"
        raise ValueError(f"--{name} {written}: give {form}, or SI numbers") from None


def _units(power: int) -> dict[str, float]:
    """Return lengths by their units; of the power 2 areas, as in mm2."""
    from tissue_probe.recording.units import POSITION_UNITS

    mark = "" if power == 1 else str(power)
    return {f"{unit}{mark}": size**power for unit, size in POSITION_UNITS.items()}


def _read(written: str, units: Mapping[str, float]) -> float:
    """Return a number in SI units, of one that is written with its unit, or in SI."""
    for unit in sorted(units, key=len, reverse=True):
        if written.endswith(unit):
            return float(written.removesuffix(unit)) * units[unit]
    return float(written)
