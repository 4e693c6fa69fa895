"""``tissue_probe map``: the stiffness map of a recorded scan."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tissue_probe.cli.arguments import Bag, EffectFiles

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tissue_probe.mapping.regions import Region
    from tissue_probe.mapping.stiffness_map import StiffnessMapData
    from tissue_probe.physics.phantom import Phantom


def map_command(
    bag: Bag,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", help="Picture to write: .png, .svg or .pdf."
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
) -> None:
    """Draw the map of a recorded scan, and list the stiff regions.

    The map shows stiffness [N/m], damping [N s/m] and covariance trace over the sites [mm].
    """
    from tissue_probe.cli.recorded import build_map, estimate_again, recorded_phantom
    from tissue_probe.recording.reader import read_estimates, read_recording

    recording = read_recording(bag)
    if estimator:
        estimates = [estimate_again(recording, name, effects or []) for name in estimator]
    else:
        estimates = list(read_estimates(bag).values())
        if not estimates:
            raise ValueError(f"{bag} has no recorded estimates: give a filter with --estimator")
    found = build_map(recording, estimates)
    phantom = recorded_phantom(recording)
    regions = draw(found, phantom, output)
    summarize_map(found, regions, phantom)
    print(f"The map is in {output}.")


def draw(found: StiffnessMapData, phantom: Phantom | None, output: Path) -> Sequence[Region]:
    """Draw a map into a file and return its stiff regions."""
    from tissue_probe.figures.stiffness_map import draw_map
    from tissue_probe.mapping.regions import find_regions

    regions = find_regions(found)
    nodules = [(n.x, n.y, n.depth) for n in phantom.nodules] if phantom else []
    draw_map(found, regions, nodules).savefig(output, dpi=100)
    return regions


def summarize_map(
    found: StiffnessMapData, regions: Sequence[Region], phantom: Phantom | None
) -> None:
    """Print the stiff regions, beside the true nodules where they are known."""
    from rich.console import Console
    from rich.table import Column, Table

    from tissue_probe.mapping.regions import Background, match

    console = Console(highlight=False, markup=False)
    background = Background.of(found.stiffness).stiffness
    console.print(
        f"{int(found.measured.sum())} of {len(found.grid)} sites measured; "
        f"background {background:.1f} N/m"
    )
    if phantom is None:
        table = Table("stiff region", "x, y [mm]", "stiffness [N/m]", "over background")
        for number, region in enumerate(regions, 1):
            table.add_row(str(number), _place(region), _stiffness(region), f"{region.ratio:.2f}")
        console.print(table)
        return
    titles = (
        "true nodule\nat x, y [mm]",
        "depth\n[mm]",
        "found\nat x, y [mm]",
        "off by\n[mm]",
        "stiffness\nthere [N/m]",
        "truth\nthere",
    )
    table = Table(*(Column(title, no_wrap=True) for title in titles))
    matched = match(regions, [(n.x, n.y) for n in phantom.nodules], found.grid.spacing)
    by_nodule = {nodule: (regions[region], off) for region, nodule, off in matched.pairs}
    for number, nodule in enumerate(phantom.nodules):
        cells = [_place(nodule), f"{1e3 * nodule.depth:.0f}"]
        if number in by_nodule:
            region, off = by_nodule[number]
            true = phantom.stiffness(region.x, region.y)
            cells += [_place(region), f"{1e3 * off:.1f}", _stiffness(region), f"{true:.1f}"]
        table.add_row(*cells, *(["missed"] if number not in by_nodule else []))
    console.print(table)
    console.print(
        f"{len(matched.pairs)} of {len(phantom.nodules)} nodules found, "
        f"{len(matched.false)} stiff regions where there is no nodule"
    )


def _place(thing) -> str:
    return f"{1e3 * thing.x:.1f}, {1e3 * thing.y:.1f}"


def _stiffness(region: Region) -> str:
    return f"{region.stiffness:.1f} ± {region.stiffness_stddev:.1f}"
