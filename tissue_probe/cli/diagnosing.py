"""Options of ``compare``, ``diagnose`` and ``improve`` on model and instrument.

What belongs here: these options, and their values as the analysis takes them.
What does not: options on measured data (``measured``), the output of one command.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import Annotated, Any

import typer

from tissue_probe.analysis.choices import RIG_NAMES, TISSUE_NAMES
from tissue_probe.cli.arguments import in_a_folder
from tissue_probe.cli.options_named import with_options
from tissue_probe.physics.rigs import OWN, named
from tissue_probe.quantities import FORCE

RigName = Enum("RigName", {name: name for name in RIG_NAMES}, type=str)
TissueName = Enum("TissueName", {name: name for name in TISSUE_NAMES}, type=str)
FORCE_DRIVES = named(lambda rig: rig.input is FORCE)

Rig = Annotated[
    RigName | None,
    typer.Option(
        help=f"How the instrument couples to the tissue; in {FORCE_DRIVES} the force is the "
        "input, and the position is predicted.",
        show_default=f"that of --model, else {OWN}",
    ),
]
TissueOption = Annotated[
    TissueName | None,
    typer.Option(
        "--tissue",
        help="The model to begin with.",
        show_default="that of --model, else kelvin_voigt",
    ),
]
ModelOption = Annotated[
    Path | None,
    typer.Option(
        "--model",
        metavar="FILE",
        help="Begin with this model.yaml, in place of rig and tissue: its values are fitted again.",
    ),
]
KnownRig = Annotated[
    bool, typer.Option("--known-rig", help="Take the rig's constants as exactly known.")
]
Constants = Annotated[
    list[str] | None,
    typer.Option(
        "--constant",
        metavar="NAME=VALUE[+-SD]",
        help="A constant of the rig and its standard deviation (one; what is printed after +- is a "
        "95 % interval), SI units, such as tip_mass=0.04+-0.001, or what is known of the tissue, "
        "such as stiffness=0; may be given several times.",
    ),
]
Validate = Annotated[
    list[Path] | None,
    typer.Option(
        "--validate",
        metavar="FILE",
        help="Another recording of the same specimen: models are tried on it, not fitted.",
    ),
]
Json = Annotated[
    Path | None,
    typer.Option(
        "--json", metavar="FILE", callback=in_a_folder, help="Write the answer for programs."
    ),
]


def constants(texts: Sequence[str]) -> dict[str, float | tuple[float, float]]:
    """Return constants by name, with their standard deviations, of NAME=VALUE+-SD each.

    Raises
    ------
    ValueError
        If one is written otherwise.
    """
    found = {}
    for text in texts:
        name, _, number = text.partition("=")
        value, given, deviation = number.partition("+-")
        try:
            found[name] = (float(value), float(deviation) if given else 0.0)
        except ValueError:
            raise ValueError(
                f"--constant {text}: give NAME=VALUE+-SD, such as tip_mass=0.04+-0.001"
            ) from None
    return found


def write_json(path: Path, told: dict[str, object]) -> None:
    """Write an answer for programs; in its advice, parameters as the options that state them."""
    import json

    path.write_text(with_options(json.dumps(told, indent=2)) + "\n", encoding="utf-8")


def name(choice: Enum | None) -> Any:
    """Return the value of an option that was chosen, or None."""
    return choice.value if choice else None
