"""``tissue_probe reproduce``: the results figures of the paper, from simulated experiments."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tissue_probe.reproduction.finding import Reproduction


def reproduce(
    figure: Annotated[
        str,
        typer.Argument(help="fig3, fig4, fig6 to fig12, fig14 to fig16, or all.", metavar="FIGURE"),
    ] = "all",
    folder: Annotated[
        Path,
        typer.Option(
            metavar="FOLDER",
            help="Where to leave FIGURE.png and FIGURE.svg; earlier ones are replaced.",
            file_okay=False,
        ),
    ] = Path("reproduction"),
) -> None:
    """Make the paper's results figures again, from simulated data.

    Each shows the paper's filters beside robust_ekf: stiffness [N/m], damping [N s/m], covariance
    trace or force [N]. A table has the paper's values, those of its method here, and those of
    robust_ekf.
    """
    from tissue_probe.reproduction.table import FIGURES

    if figure != "all" and figure not in FIGURES:
        raise ValueError(f"there is no {figure}; there are {', '.join(FIGURES)}, all")
    folder.mkdir(parents=True, exist_ok=True)
    made = {}
    for name in FIGURES if figure == "all" else [figure]:
        made[name] = FIGURES[name]()
        for ending in ("png", "svg"):
            made[name].figure.savefig(folder / f"{name}.{ending}", dpi=100)
    summarize(made)
    print(f"The figures are in {folder}.")


def summarize(made: Mapping[str, Reproduction]) -> None:
    """Print the paper's values, those of its method, and those of robust_ekf."""
    from rich.console import Console
    from rich.table import Column, Table

    titles = ("quantity", "the paper states", "its method here", "robust_ekf")
    table = Table(Column("figure", no_wrap=True), *titles, show_lines=True)
    for name, reproduction in made.items():
        for row in reproduction.findings:
            table.add_row(name, row.quantity, row.stated, row.paper, row.ours)
    Console(highlight=False, markup=False).print(table)
