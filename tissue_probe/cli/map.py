"""``tissue_probe map``: the stiffness map of a recorded scan."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tissue_probe.cli import measured
from tissue_probe.cli.arguments import EffectFiles

if TYPE_CHECKING:
    from tissue_probe.analysis.mapping import MapResult
    from tissue_probe.mapping.regions import Region


def map_command(
    samples: measured.Samples,
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
    position: measured.Position = None,
    force: measured.Force = None,
    time: measured.Time = None,
    sample_rate: measured.SampleRate = None,
    position_unit: measured.PositionUnit = None,
    force_unit: measured.ForceUnit = None,
    time_unit: measured.TimeUnit = None,
    force_polarity: measured.ForcePolarity = None,
    position_polarity: measured.PositionPolarity = measured.Direction.into,
    topic: measured.SamplesTopic = None,
    clock: measured.ClockOption = None,
    effects: EffectFiles = None,
    rig: measured.FilteredRigOption = None,
) -> None:
    """Draw the map of a recorded scan, and list the stiff regions.

    The map shows stiffness [N/m], damping [N s/m] and covariance trace over the sites [mm].
    """
    from tissue_probe.analysis.mapping import map_sites

    layout = measured.layout(
        position, force, time, sample_rate, position_unit, force_unit, time_unit,
        force_polarity, position_polarity, topic, clock,
    )  # fmt: skip
    recordings = measured.read([samples], layout)
    measured.tell(recordings.notes)
    result = map_sites(
        recordings,
        estimators=estimator or [],
        effects=effects or [],
        rig=rig.value if rig else None,
    )
    result.plot().savefig(output, dpi=100)
    summarize(result)
    print(f"The map is in {output}.")


def summarize(result: MapResult) -> None:
    """Print what became of the sites, and the stiff regions, beside the true nodules if known."""
    from rich.console import Console
    from rich.table import Column, Table

    from tissue_probe.mapping.regions import match

    console = Console(highlight=False, markup=False)
    console.print(result.text)
    if not result.map.measured.any():
        return
    regions, phantom = result.stiff, result.phantom
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
    matched = match(regions, [(n.x, n.y) for n in phantom.nodules], result.map.grid.spacing)
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
