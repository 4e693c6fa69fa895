"""What ``diagnose`` and ``improve`` find in measured data of others: ``docs/measured_data.md``.

    python benchmarks/measured_data.py FOLDER [--only NAME] [--whole-library]

FOLDER holds the data, which are not part of this project (the page says where they come from); a
file that is not there is left out.
"""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

COLUMNS = (
    "--position qm --position-unit m --force vir --force-unit 35.1507 --force-polarity compression "
)
DRIVE = COLUMNS + "--rig rigid_probe --constant stiffness=0 --lowpass 100"
DRIVEN = COLUMNS + "--rig force_driven --constant stiffness=0 --constant contact_position=0"
PROBING = (
    "--position depth_mm --force fn_N --force-polarity compression --sample-rate 10 "
    "--rig rigid_probe --constant tip_mass=0"
)
ELASTOMER = (
    "--position disp_mm --force-polarity compression --starts at-rest --rig rigid_probe "
    "--constant tip_mass=0"
)
#: The drive by A. Janot, M. Gautier, M. Brunot (Nonlinear System Identification Benchmarks, 2019),
#: which names these values: least squares on the inverse model.
PUBLISHED = {
    "tip_mass": 95.1089,
    "damping": 203.5034,
    "coulomb_force": 20.3935,
    "force_bias": -3.1648,
}
#: And with other friction backwards than forwards: half the sums and the differences of what is
#: published of each direction (viscous 166.71 and 240.42 N s/m, dry 20.14 and 20.63 N).
PUBLISHED_BY_DIRECTION = {
    "damping": (166.71 + 240.42) / 2.0,
    "damping_difference": (166.71 - 240.42) / 2.0,
    "coulomb_force": (20.14 + 20.63) / 2.0,
    "force_bias": (20.14 - 20.63) / 2.0,
}
DIRECTIONAL = Path(__file__).parents[1] / "docs" / "directional_damping.py"
BAND = Path(__file__).parents[1] / "docs" / "rubber_band.py"
#: What the literature says of it.
DRY = ("coulomb_friction", "force_bias")
#: How many of a ranking are shown.
SHOWN = 3


@dataclass(frozen=True)
class Measured:
    """One file, how it is read, and the effects that the literature says are in it, its values.

    ``second`` is a file on which the models are tried that the first one gives.
    """

    name: str
    file: str
    options: str
    known: tuple[str, ...]
    published: dict[str, float] = field(default_factory=dict)
    second: str = ""

    def arguments(self, folder: Path, whole: bool) -> list[str]:
        """Return what follows ``tissue_probe``."""
        added = [word for effect in self.known for word in ("--add", effect)]
        command, asked = ("diagnose", []) if whole else ("improve", added)
        validate = ["--validate", str(folder / self.second)] if self.second else []
        return [command, str(folder / self.file), *shlex.split(self.options), *asked, *validate]


DATA = (
    Measured("EMPS", "emps/DATA_EMPS.mat", DRIVE, DRY, PUBLISHED),
    Measured("EMPS driven", "emps/DATA_EMPS.mat", DRIVEN, DRY, PUBLISHED),
    *(
        Measured(
            f"{name} by direction",
            "emps/DATA_EMPS.mat",
            f"{options} --effects {shlex.quote(str(DIRECTIONAL))}",
            (*DRY, "directional_damping"),
            PUBLISHED_BY_DIRECTION,
        )
        for name, options in (("EMPS", DRIVE), ("EMPS driven", DRIVEN))
    ),
    *(
        Measured(name, f"pig_liver_probing/{file}.csv", PROBING, ("hertz_contact",))
        for name, file in {
            "liver, region 1": "pig_liver_20150826_region1",
            "liver, region 4": "pig_liver_20150826_region4",
            "liver again, region 1": "pig_liver_20150826_v2_region1",
            "liver again, region 2": "pig_liver_20150826_v2_region2",
            "liver again, region 3": "pig_liver_20150826_v2_region3",
            "liver again, region 4": "pig_liver_20150826_v2_region4",
            "meat, region 4": "meat0904_region4",
            "meat, region 1": "meat20150903_region1",
            "silicone": "silicone_probingRAL2018_T1",
        }.items()
    ),
    *(
        Measured(f"VHB {name}, {effect}", f"vhb4910_elastomer/{name}.csv", ELASTOMER, (effect,))
        for name in ("relax_3d0", "relax_4d0", "relax_6d0", "cyc_0d05_3d0")
        for effect in ("standard_linear_solid", "generalized_maxwell")
    ),
    *(
        Measured(
            f"VHB cycles, {rate}",
            f"vhb4910_elastomer/{first}.csv",
            f"{ELASTOMER} --effects {shlex.quote(str(BAND))}",
            ("contact_loss", "rubber_band"),
            second=f"vhb4910_elastomer/{second}.csv",
        )
        for rate, first, second in (
            ("0.05 1/s", "cyc_0d05_3d0", "cyc_0d03_2d5"),
            ("0.03 1/s", "cyc_0d03_3d0", "cyc_0d05_2d5_1"),
            ("0.01 1/s", "cyc_0d01_3d0", "cyc_0d01_2d0"),
        )
    ),
)


def main(
    folder: Annotated[Path, typer.Argument(help="Folder of the measured data.")],
    only: Annotated[str, typer.Option(help="Data whose name begins so.")] = "",
    whole_library: Annotated[
        bool, typer.Option(help="Diagnose, instead of adding what is known to be there.")
    ] = False,
) -> None:
    """Run the commands of the page, and print its tables."""
    console = Console(width=150)
    found = Table(title="What is found", title_justify="left")
    for name in ("data", "verdict", "effects", "error", "noise", "ranking (BIC gain)"):
        found.add_column(name, overflow="fold")
    ladders = []
    for data in (data for data in DATA if data.name.startswith(only)):
        if not (folder / data.file).exists():
            print(f"{data.name}: left out, {data.file} is not in {folder}")
            continue
        said = shlex.join(data.arguments(Path(), whole_library))
        console.print(f"$ tissue_probe {said}", soft_wrap=True)
        answer = told(data.arguments(folder, whole_library))
        if isinstance(answer, str):
            print(answer)
            continue
        found.add_row(*row(data.name, answer))
        ladders.append(ladder_table(data, answer))
    console.print(found, *ladders)


def told(arguments: list[str]) -> dict | str:
    """Return a command's answer for programs, or what it said where it failed."""
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "answer.json"
        output = ["--output", scratch] if arguments[0] == "improve" else []
        command = [sys.executable, "-m", "tissue_probe", *arguments, *output, "--json", path]
        done = subprocess.run(command, capture_output=True, text=True)
        return json.loads(path.read_text()) if path.exists() else done.stderr


def row(name: str, answer: dict) -> list[str]:
    """Return a data set's row of the first table."""
    errors, ranking = answer["rmse"]["training"], answer["ranking"][:SHOWN]
    unit = answer["output"]["unit"]
    return [
        name,
        answer["verdict"],
        ", ".join(answer["effects"]) or "none",
        f"{errors['base']:.4g} -> {errors['final']:.4g} {unit}{held_out(answer)}",
        f"{answer['noise_floor']:.3g} {unit}",
        ", ".join(f"{each['effect']} ({each['gain']:.0f}){settled(each)}" for each in ranking),
    ]


def held_out(answer: dict) -> str:
    """Return the errors on a second recording, if there is one."""
    if answer["carries_over"] is None:
        return ""
    held = answer["rmse"]["heldout"]
    return f" ({held['base']:.4g} -> {held['final']:.4g} on the second)"


def settled(entry: dict) -> str:
    """Say where a fit did not settle."""
    return "" if entry["converged"] else " [did not settle]"


def ladder_table(data: Measured, answer: dict) -> Table:
    """Return the parameters of the last model of a ladder, beside published ones."""
    last = answer["ladder"][-1]
    model = " + ".join(["Kelvin-Voigt", *last["effects"]])
    table = Table(title=f"{data.name}: {model}{settled(last)}", title_justify="left")
    published = data.published
    for column in ("parameter", "value", "95 %", "unit", *(["published"] if published else [])):
        table.add_column(column)
    for parameter, entry in last["parameters"].items():
        if entry["deviation"]:
            value, interval = f"{entry['value']:.5g}", f"+- {1.96 * entry['deviation']:.2g}"
            known = [f"{published[parameter]:g}"] if parameter in published else []
            table.add_row(parameter, value, interval, entry["unit"], *known)
    return table


if __name__ == "__main__":
    typer.run(main)
