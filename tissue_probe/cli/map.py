"""``tissue_probe map``: the stiffness map of a recorded scan."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tissue_probe.cli import measured
from tissue_probe.cli.arguments import EffectFiles

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tissue_probe.mapping.regions import Region
    from tissue_probe.mapping.stiffness_map import StiffnessMapData
    from tissue_probe.physics.phantom import Phantom


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
) -> None:
    """Draw the map of a recorded scan, and list the stiff regions.

    The map shows stiffness [N/m], damping [N s/m] and covariance trace over the sites [mm].
    """
    from tissue_probe.cli.recorded import build_map, estimate_again, recorded_phantom
    from tissue_probe.recording.any_file import is_own
    from tissue_probe.recording.reader import read_estimates

    layout = measured.layout(
        position, force, time, sample_rate, position_unit, force_unit, time_unit,
        force_polarity, position_polarity, topic, clock,
    )  # fmt: skip
    recording, notes = measured.read(samples, layout)
    for note in notes:
        print(f"note: {note}")
    if estimator:
        estimates = [estimate_again(recording, name, effects or []) for name in estimator]
    else:
        own = is_own(samples, layout)
        estimates = list(read_estimates(samples).values()) if own else []
        if not estimates:
            raise ValueError(f"{samples} has no recorded estimates: give a filter with --estimator")
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
    """Print what became of the sites, and the stiff regions, beside the true nodules if known."""
    from rich.console import Console
    from rich.table import Column, Table

    from tissue_probe.mapping.regions import Background, match

    console = Console(highlight=False, markup=False)
    told = [f"{int(found.measured.sum())} of {len(found.grid)} sites measured"]
    told += [f"{count} {word}" for word, count in unusual(found).items()]
    if not found.measured.any():
        console.print("; ".join(told))
        return
    told.append(f"background {Background.of(found.stiffness).stiffness:.1f} N/m")
    console.print("; ".join(told))
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


def unusual(found: StiffnessMapData) -> dict[str, int]:
    """Return how many cells have each verdict but measured, in words; those that occur."""
    from tissue_probe.mapping.verdict import Verdict

    counts = {each: int((found.verdict == each).sum()) for each in Verdict}
    del counts[Verdict.MEASURED]
    return {
        verdict.name.lower().replace("_", " "): count for verdict, count in counts.items() if count
    }


def _place(thing) -> str:
    return f"{1e3 * thing.x:.1f}, {1e3 * thing.y:.1f}"


def _stiffness(region: Region) -> str:
    return f"{region.stiffness:.1f} ± {region.stiffness_stddev:.1f}"
