"""``tissue_probe map``: the map of a recorded scan, or of a table of sites."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from tissue_probe.cli import measurement_options
from tissue_probe.cli.arguments import EffectFiles, in_a_folder, picture
from tissue_probe.cli.groups import add_groups

if TYPE_CHECKING:
    from rich.table import Column

    from tissue_probe.analysis.mapping import MapResult
    from tissue_probe.analysis.measurements import Source
    from tissue_probe.mapping.exploration.choice import NextSite
    from tissue_probe.mapping.posterior.results import Inclusion
    from tissue_probe.physics.phantom import Nodule

#: Inclusions that are less probable are in the file for programs alone.
TOLD_PROBABILITY = 0.5
#: From here on one counts as found: so benchmarks and documents count.
FOUND = 0.9
#: Head of a column, no wider than its numbers: all are to fit 80 characters.
PROBABILITY = "proba-\nbility"


ChooseFor = Literal["edge", "find", "both"]
"""The purpose of further sites."""


@add_groups
def map_command(
    samples: measurement_options.Samples,
    signals: measurement_options.Signals,
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            callback=picture,
            help="Picture to write: .png, .svg or .pdf.",
        ),
    ] = Path("map.png"),
    estimator: Annotated[
        list[str] | None,
        typer.Option(
            "--estimator",
            "-e",
            metavar="NAME",
            help="Filter to run on the samples, may be repeated.  "
            "[default: the recorded estimates]",
        ),
    ] = None,
    effects: EffectFiles = None,
    rig: measurement_options.FilteredRigOption = None,
    raster: Annotated[float, typer.Option(metavar="MM", help="Step of the surface [mm].")] = 0.5,
    contrast: Annotated[
        float,
        typer.Option(help="Of inclusions that could hide: stiffness over the background's."),
    ] = 1.5,
    within: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Corners of the area in question: columns x, y [m]."),
    ] = None,
    no_go: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="Corners of an area where no further site may be, may be repeated.",
        ),
    ] = None,
    next_count: Annotated[
        int,
        typer.Option("--next", metavar="N", min=0, help="Further sites to choose in the area."),
    ] = 0,
    choose_for: Annotated[
        ChooseFor,
        typer.Option(help="Of further sites: edges of inclusions, to find unseen ones, or both."),
    ] = "both",
    register: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Point pairs, x, y, z [m] here and X, Y, Z [m] in another frame: results there.",
        ),
    ] = None,
    outliers: Annotated[
        float,
        typer.Option(
            metavar="SHARE",
            help="Of sites that err far more than they state, such as 0.01 where the tip may "
            "slip; 0 where contact was verified.",
        ),
    ] = 0.0,
    json_file: Annotated[
        Path | None,
        typer.Option("--json", metavar="FILE", callback=in_a_folder, help="The map for programs."),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(metavar="FILE", callback=in_a_folder, help="The surface as a table, .csv."),
    ] = None,
    ply: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", callback=in_a_folder, help="The surface as a point cloud, .ply."
        ),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", callback=in_a_folder, help="The map as a page for people, .html."
        ),
    ] = None,
) -> None:
    """Map a scan or a table of sites, and where inclusions may hide.

    A table of sites has the columns x, y [m], k [N/m] and perhaps k_sd [N/m], z [m], t [s], site,
    or with other units in their names (x_mm, k [N/mm]).
    The picture shows stiffness [N/m], P(inclusion) and the radius that an unseen inclusion could
    have [mm] over the sites [mm].
    """
    from tissue_probe.analysis.mapping import is_sites, map_sites, refuse_misnamed_sites
    from tissue_probe.recording.layout import Layout

    measurement_options.check_there([samples])
    source: Source = samples
    layout = signals.layout()
    if is_sites(samples):
        if layout != Layout():
            raise ValueError(
                f"{samples} is a table of sites, which has no samples: leave out the options on "
                "position, force, time, topic, clock and adapter"
            )
    else:
        if layout == Layout():
            refuse_misnamed_sites(samples)
        source = measurement_options.read([samples], layout)
    result = map_sites(
        source,
        estimators=estimator or [],
        effects=effects or [],
        rig=rig,
        raster=1e-3 * raster,
        contrast=contrast,
        within=within,
        no_go=no_go or [],
        next=next_count,
        register=register,
        choose_for=choose_for,
        outliers=outliers,
    )
    result.plot().savefig(output, dpi=100)
    if json_file is not None:
        json_file.write_text(json.dumps(result.to_dict(), allow_nan=False) + "\n")
    if csv is not None:
        result.save_csv(csv)
    if ply is not None:
        result.save_ply(ply)
    if report is not None:
        result.report(report)
    measurement_options.tell(result.notes)
    summarize(result)
    tell_next(result)
    print(f"The map is in {output}.")


def summarize(result: MapResult) -> None:
    """Print the fate of the sites, and the inclusions, beside the true nodules if known."""
    from rich.console import Console
    from rich.table import Table

    from tissue_probe.mapping.matching import match
    from tissue_probe.physics.phantom import Phantom

    console = Console(highlight=False, markup=False)
    console.print(result.text)
    found = [one for one in result.map.inclusions if one.probability >= TOLD_PROBABILITY]
    phantom = result.phantom
    if not isinstance(phantom, Phantom):
        titles = ["inclusion", "x, y\n[mm]", PROBABILITY, "stiffness\n[N/m]", "over back-\nground"]
        if result.laid_flat:
            titles.append("X, Y, Z\n[mm]")
        table = Table(*_columns([*titles, *(["truth\n[N/m]"] if phantom else [])]))
        for number, one in enumerate(found, 1):
            place = result.in_space(one)
            further = [", ".join(f"{1e3 * each:.1f}" for each in place)] * result.laid_flat
            true = [f"{phantom.stiffness(*place[:2]):.1f}"] if phantom else []
            ratio = f"{one.contrast:.2f}"
            cells = _place(one), _sure(one), _stiffness(one), ratio, *further, *true
            table.add_row(str(number), *cells)
        console.print(table)
        return
    heads = (
        "nodule at\nx, y [mm]",
        "depth\n[mm]",
        "found at\nx, y [mm]",
        "off\n[mm]",
        PROBABILITY,
        "stiffness\n[N/m]",
        "truth\n[N/m]",
    )
    table = Table(*_columns(heads))
    places = [result.in_space(one)[:2] for one in found]
    matched = match(places, [(n.x, n.y) for n in phantom.nodules])
    by_nodule = {nodule: (found[one], off) for one, nodule, off in matched.pairs}
    for number, nodule in enumerate(phantom.nodules):
        row = [_place(nodule), f"{1e3 * nodule.depth:.0f}"]
        if number in by_nodule:
            one, off = by_nodule[number]
            known = float(phantom.stiffness(*result.in_space(one)[:2]))
            row += [_place(one), f"{1e3 * off:.1f}", _sure(one), _stiffness(one), f"{known:.1f}"]
        table.add_row(*row, *(["missed"] if number not in by_nodule else []))
    console.print(table)
    sure = {number for number, one in enumerate(found) if one.probability >= FOUND}
    console.print(
        f"{sum(one in sure for one, _, _ in matched.pairs)} of {len(phantom.nodules)} nodules "
        f"found, {len(sure.intersection(matched.false))} inclusions where there is no nodule"
    )


def tell_next(result: MapResult) -> None:
    """Print the sites that tell most, where they were asked for."""
    from rich.console import Console
    from rich.table import Table

    if not result.next:
        return
    table = Table(*_columns(["next site", "x, y [mm]", "settles [mm²]", "chosen for"]))
    for number, one in enumerate(result.next, 1):
        table.add_row(str(number), _place(one), f"{1e6 * one.gain:.2f}", one.purpose)
    Console(highlight=False, markup=False).print(table)


def _columns(titles: Sequence[str]) -> list[Column]:
    """Return columns that break in a narrow window, where others would be cut."""
    from rich.table import Column

    return [Column(title, overflow="fold") for title in titles]


def _place(found: Inclusion | Nodule | NextSite) -> str:
    return f"{1e3 * found.x:.1f}, {1e3 * found.y:.1f}"


def _sure(one: Inclusion) -> str:
    return f"{one.probability:.2f}"


def _stiffness(one: Inclusion) -> str:
    return f"{one.stiffness:.1f} ± {one.stiffness_sd:.1f}"
