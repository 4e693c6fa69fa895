"""The stiffness map of a recorded scan, its stiff regions, and the true nodules where known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tissue_probe.analysis.choices import FilteredRig
from tissue_probe.analysis.measurements import Source, measurements_of
from tissue_probe.analysis.recorded import build_map, estimate_again, recorded_phantom
from tissue_probe.analysis.result_table import Column, ResultTable, number
from tissue_probe.errors import ParameterError
from tissue_probe.mapping.regions import Background, Region, find_regions
from tissue_probe.mapping.stiffness_map import StiffnessMapData
from tissue_probe.mapping.verdict import Verdict
from tissue_probe.physics.phantom import Phantom
from tissue_probe.recording.reader import read_estimates

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class MapResult:
    """A stiffness map and what stands out in it.

    Attributes
    ----------
    map : StiffnessMapData
        Stiffness, damping and verdict of each cell.
    phantom : Phantom or None
        The tissue of a simulated run, where it is recorded.
    notes : tuple of str
        How the samples were read, in sentences.
    """

    map: StiffnessMapData
    phantom: Phantom | None
    notes: tuple[str, ...]

    @cached_property
    def stiff(self) -> Sequence[Region]:
        """Connected regions that are stiffer than the background."""
        return find_regions(self.map)

    @property
    def regions(self) -> ResultTable:
        """The stiff regions, in m and N/m."""
        columns = (
            Column("x", "x [mm]", lambda x: f"{1e3 * x:.1f}", right=True),
            Column("y", "y [mm]", lambda y: f"{1e3 * y:.1f}", right=True),
            Column("stiffness", "stiffness [N/m]", number(5), right=True),
            Column("stiffness_stddev", "+-", number(2), right=True),
            Column("ratio", "over background", number(3), right=True),
        )
        rows = tuple((r.x, r.y, r.stiffness, r.stiffness_stddev, r.ratio) for r in self.stiff)
        return ResultTable("Stiff regions", columns, rows)

    @property
    def unusual(self) -> dict[str, int]:
        """How many cells have each verdict but measured, in words; those that occur."""
        counts = {each: int((self.map.verdict == each).sum()) for each in Verdict}
        del counts[Verdict.MEASURED]
        return {
            verdict.name.lower().replace("_", " "): count
            for verdict, count in counts.items()
            if count
        }

    @property
    def text(self) -> str:
        """How many sites were measured, what became of the others, and the background."""
        told = [f"{int(self.map.measured.sum())} of {len(self.map.grid)} sites measured"]
        told += [f"{count} {word}" for word, count in self.unusual.items()]
        if self.map.measured.any():
            told.append(f"background {Background.of(self.map.stiffness).stiffness:.1f} N/m")
        return "; ".join(told)

    def __repr__(self) -> str:
        return f"{self.text}\n{self.regions!r}"

    def _repr_html_(self) -> str:
        return f"<p>{self.text}</p>{self.regions._repr_html_()}"

    def cells(self) -> ResultTable:
        """Return a row a cell, in m, N/m and N s/m; None where nothing is known."""
        names = ("stiffness", "stiffness_stddev", "damping", "damping_stddev")
        columns = (
            *(Column(name, f"{name} [m]", number(4), right=True) for name in "xy"),
            *(Column(name, name, number(5), right=True) for name in names),
            Column("verdict", "verdict"),
        )
        rows = []
        for row, y in enumerate(self.map.grid.y):
            for column, x in enumerate(self.map.grid.x):
                cell = [float(getattr(self.map, name)[row, column]) for name in names]
                verdict = Verdict(self.map.verdict[row, column]).name.lower()
                known = [None if value != value else value for value in cell]
                rows.append((float(x), float(y), *known, verdict))
        return ResultTable("Cells of the map", columns, tuple(rows))

    def to_frame(self) -> pd.DataFrame:
        """Return the cells as a pandas data frame."""
        return self.cells().to_frame()

    def to_dict(self) -> dict[str, Any]:
        """Return cells and stiff regions, in SI units."""
        return {"cells": self.cells().to_dict(), "regions": self.regions.to_dict()}

    def plot(self) -> Figure:
        """Draw stiffness, damping and covariance trace, with the regions and the true nodules."""
        from tissue_probe.figures.stiffness_map import draw_map

        nodules = [(n.x, n.y, n.depth) for n in self.phantom.nodules] if self.phantom else []
        return draw_map(self.map, self.stiff, nodules)


def map_sites(
    measured: Source,
    *,
    estimators: Sequence[str] = (),
    effects: Sequence[str | Path] = (),
    rig: FilteredRig | None = None,
) -> MapResult:
    """Map the stiffness over the sites of a recorded scan.

    Parameters
    ----------
    measured : Measurements, or path
        The scan, with its announced sites.
    estimators : sequence of str
        Filters to run on the samples; by default the recorded estimates are taken.
    effects : sequence of path
        Python files with effects of the user's own that a recorded model needs; they are run.
    rig : {"compliant_probe", "rigid_probe"}, optional
        How the instrument couples to the tissue; by default as recorded, else compliant_probe.

    Raises
    ------
    TissueProbeError
        If it cannot be read, has no recorded estimates, or no sites.
    """
    parts = measurements_of(measured).parts
    if len(parts) != 1:
        raise ParameterError(f"{len(parts)} recordings are given: a map is of one scan")
    (part,) = parts
    estimators = [estimators] if isinstance(estimators, str) else estimators
    if estimators:
        files = tuple(map(Path, effects))
        stated = {"rig": rig} if rig else {}
        estimates = [estimate_again(part.recording, name, files, stated) for name in estimators]
    else:
        estimates = list(read_estimates(part.path).values()) if part.is_own and part.path else []
        if not estimates:
            raise ParameterError(
                f"{part.name} has no recorded estimates: give a filter by `estimator`"
            )
    found = build_map(part.recording, estimates)
    return MapResult(found, recorded_phantom(part.recording), part.notes)
