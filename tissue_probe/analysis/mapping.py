"""The map of a recorded scan or of a table of sites, and the true nodules where known."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from tissue_probe import arguments as take
from tissue_probe.analysis.choices import FILTERED_RIGS, FilteredRig
from tissue_probe.analysis.map_in_space import PlacedMap, RegisteredMap, registration_of
from tissue_probe.analysis.measurements import IN_MEMORY, Measurements, Source, measurements_of
from tissue_probe.analysis.recorded_facts import estimate_again, find_phantom, gather_sites
from tissue_probe.analysis.result_table import Column, ResultTable, number, two_decimals
from tissue_probe.errors import ParameterError, TissueProbeError
from tissue_probe.likeness import Alike
from tissue_probe.mapping.chart import Chart
from tissue_probe.mapping.exploration.answer import SiteAnswer, Sought, answer
from tissue_probe.mapping.exploration.choice import PURPOSES, NextSite, Purpose, next_sites
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.posterior_map import RASTER, SOUGHT_CONTRAST, read_out
from tissue_probe.mapping.posterior.posterior_sample import Sampled
from tissue_probe.mapping.posterior.results import Again, PosteriorMap
from tissue_probe.mapping.posterior.results import Inclusion as Inclusion
from tissue_probe.mapping.registration import Registration
from tissue_probe.mapping.scatter import scatter
from tissue_probe.mapping.site_result import SiteResult, sites_of
from tissue_probe.mapping.sites import Sites
from tissue_probe.mapping.verdict import CellVerdict
from tissue_probe.physics.felt_table import FeltTable
from tissue_probe.physics.phantom import Phantom
from tissue_probe.recording.bags.open_bag import is_bag
from tissue_probe.recording.bags.reader import read_estimates
from tissue_probe.recording.columns.in_memory import columns_in_memory
from tissue_probe.recording.columns.open_columns import open_columns
from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.tables.corners import read_corners
from tissue_probe.recording.tables.ply import write_ply
from tissue_probe.recording.tables.point_pairs import read_pairs
from tissue_probe.recording.tables.site_table import is_site_table, read_sites, refuse_misnamed

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Read = TypeVar("Read")
#: Said of a table of sites that does not tell its noise.
SCATTER_LEARNT = (
    "k_sd is not given: the scatter of sites about their neighbours, {:.2g} times k, stands for it"
)
#: The type that states which inclusions matter, in words.
SOUGHT = "a Sought, of tissue_probe.mapping.exploration.answer"
#: Said of a scan in which no site has a value.
UNHEARD = (
    "{}: none of its {} sites has an estimate: no estimator was heard while the probe dwelt there; "
    "give a filter by `estimator`"
)


@dataclass(frozen=True, eq=False, repr=False)
class MapResult(Alike):
    """A map of sites.

    Attributes
    ----------
    sites : Sites
        The estimate of each site, at its place in the map.
    results : tuple of SiteResult
        The dwells of a scan; none for a table.
    map : PosteriorMap
        Inclusions, surface, sizes that could hide, background, check.
    phantom : Phantom or FeltTable or None
        The tissue of a simulated run, where it is recorded.
    notes : tuple of str
        How the samples were read, in sentences.
    next : tuple of NextSite
        The sites that tell most, in their order, where they were asked for.
    answer : Answer or None
        The statement on inclusions in the area, where one is given.
    placed : PlacedMap
        The results in space: in the sites' frame, or in another where point pairs are given.
    laid_flat : bool
        Whether x and y of the map run along the sites' surface, not in their own frame.
    """

    sites: Sites
    results: tuple[SiteResult, ...]
    map: PosteriorMap
    phantom: Phantom | FeltTable | None
    notes: tuple[str, ...]
    placed: PlacedMap
    laid_flat: bool = False
    next: tuple[NextSite, ...] = ()
    answer: SiteAnswer | None = None

    @property
    def registered(self) -> RegisteredMap | None:
        """The results in another frame, where point pairs are given."""
        return self.placed if isinstance(self.placed, RegisteredMap) else None

    @property
    def inclusions(self) -> ResultTable:
        """The inclusions, in m and N/m, the most probable first.

        Where the sites' surface was laid flat, X, Y, Z are the place in space.
        """
        columns: tuple[Column, ...] = (
            Column("x", "x [mm]", number(3, 1e3), right=True),
            Column("y", "y [mm]", number(3, 1e3), right=True),
            Column("probability", "probability", two_decimals, right=True),
            Column("stiffness", "stiffness [N/m]", number(4), right=True),
            Column("stiffness_sd", "±", number(2), right=True),
            Column("contrast", "over background", number(3), right=True),
            Column("felt_by", "felt by", right=True),
        )
        names, found = [column.name for column in columns], self.map.inclusions
        rows = tuple(tuple(getattr(one, n) for n in names) for one in found)
        if self.laid_flat:
            columns += tuple(Column(n, f"{n} [mm]", number(3, 1e3), right=True) for n in "XYZ")
            places = [self.in_space(one) for one in found]
            rows = tuple((*row, *place) for row, place in zip(rows, places, strict=True))
        return ResultTable("Inclusions", columns, rows)

    @property
    def again(self) -> list[Again]:
        """Where to palpate again: inclusions that one site alone feels, the most probable first."""
        return list(self.map.again)

    @property
    def unusual(self) -> dict[str, int]:
        """How many dwells have each verdict but measured, in words; those that occur."""
        verdicts = [result.verdict for result in self.results]
        return {
            verdict.name.lower().replace("_", " "): verdicts.count(verdict)
            for verdict in CellVerdict
            if verdict in verdicts and verdict != CellVerdict.MEASURED
        }

    @property
    def text(self) -> str:
        """How many sites were measured, the fate of the others, and further notes."""
        background, check = self.map.background, self.map.check
        told = [f"{int(self.sites.felt.sum())} of {self.sites.x.size} sites measured"]
        told += [f"{count} {word}" for word, count in self.unusual.items()]
        told.append(f"background {background.stiffness:.1f} ± {background.stiffness_sd:.1f} N/m")
        lines = ["; ".join(told), *check.notes]
        if self.registered is not None:
            lines.append(self.registered.text)
        if self.answer is not None:
            lines += [self.answer.text, *(f"open: {each}" for each in self.answer.open)]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"{self.text}\n{self.inclusions!r}"

    def _repr_html_(self) -> str:
        return f"<p>{self.text}</p>{self.inclusions._repr_html_()}"

    def in_space(self, one: Inclusion) -> tuple[float, float, float]:
        """Return the middle of an inclusion of the map in the sites' own frame [m]."""
        x, y, z = self.placed.lift(np.array([one.x]), np.array([one.y]))[0].tolist()
        return x, y, z

    def surface(self) -> ResultTable:
        """Return a row a place of the raster, in m and N/m; None where nothing is known.

        Where registered, X, Y, Z are the place in the other frame; else where the sites' surface
        was laid flat, that in the sites' frame.
        """
        felt = self.map.surface
        names = ("mean", "sd", "probability")
        columns = (
            *(Column(name, f"{name} [m]", number(4), right=True) for name in "xy"),
            *(Column(name, name, number(5), right=True) for name in names),
        )
        layers = [getattr(felt, name) for name in names]
        rows = tuple(
            (float(x), float(y), *(_keep_finite(layer[i, j]) for layer in layers))
            for i, y in enumerate(felt.y)
            for j, x in enumerate(felt.x)
        )
        if self.registered is not None or self.laid_flat:
            columns += tuple(Column(n, f"{n} [m]", number(4), right=True) for n in "XYZ")
            x, y = (each.ravel() for each in np.meshgrid(felt.x, felt.y))
            places = self.placed.places(x, y).tolist()
            rows = tuple((*row, *place) for row, place in zip(rows, places, strict=True))
        return ResultTable("Surface", columns, rows)

    def to_frame(self) -> pd.DataFrame:
        """Return the surface as a pandas data frame."""
        return self.surface().to_frame()

    def to_dict(self) -> dict[str, Any]:
        """Return the map in SI units, with nothing in it that JSON has not: NaN is None."""
        found = self.map
        asked: dict[str, Any] = {}
        if self.next:
            asked["next"] = [asdict(one) for one in self.next]
        if self.answer is not None:
            asked["answer"] = asdict(self.answer)
        if self.registered is not None:
            asked["registered"] = self.registered.to_dict()
        if self.laid_flat:
            asked["space"] = PlacedMap(self.placed.lift, found).to_dict()
        return {
            **asked,
            "inclusions": [
                {
                    "x": one.x,
                    "y": one.y,
                    "covariance": one.covariance.tolist(),
                    "probability": one.probability,
                    "stiffness": one.stiffness,
                    "stiffness_sd": one.stiffness_sd,
                    "contrast": one.contrast,
                    "felt_by": one.felt_by,
                    "boundary_50": one.boundary_50.tolist(),
                    "boundary_90": one.boundary_90.tolist(),
                    "boundary_95": one.boundary_95.tolist(),
                }
                for one in found.inclusions
            ],
            "again": [asdict(one) for one in found.again],
            "surface": {
                "x": found.surface.x.tolist(),
                "y": found.surface.y.tolist(),
                "mean": _layer(found.surface.mean),
                "sd": _layer(found.surface.sd),
                "probability": _layer(found.surface.probability),
            },
            "could_hide": {
                "x": found.could_hide.x.tolist(),
                "y": found.could_hide.y.tolist(),
                "radius": _layer(found.could_hide.radius),
                "contrast": found.could_hide.contrast,
            },
            "background": {
                "stiffness": found.background.stiffness,
                "stiffness_sd": found.background.stiffness_sd,
                "tilt": list(found.background.tilt),
                "variation": found.background.variation,
                "drift": found.background.drift,
            },
            "check": {
                "model": found.check.model,
                "probability": found.check.probability,
                "disagreement": found.check.disagreement,
                "states": found.check.states,
                "notes": list(found.check.notes),
            },
        }

    def plot(self) -> Figure:
        """Draw stiffness, P(inclusion) and sizes that could hide, with sites and true nodules."""
        from tissue_probe.figures.stiffness_map import draw_map

        known = self.phantom.nodules if self.phantom and not self.laid_flat else ()
        nodules = [(n.x, n.y, n.radius) for n in known]
        return draw_map(self.map, self.sites, nodules)

    @take.checks(path=take.path)
    def report(self, path: str | Path) -> None:
        """Write the map as one page of HTML that works off line."""
        from tissue_probe import __version__
        from tissue_probe.report.map_page import MapPage, render_map

        created = f"{datetime.now():%Y-%m-%d %H:%M}; tissue_probe {__version__}"
        page = MapPage(
            "Map of the stiffness", self.map, self.sites, self.text.split("\n"), self.notes, created
        )
        Path(path).write_text(render_map(page), encoding="utf-8")

    @take.checks(path=take.path)
    def save_csv(self, path: str | Path) -> None:
        """Write the surface, a row a place: x, y [m], mean, sd [N/m], probability.

        Where registered or laid flat, X, Y, Z [m] follow, as in ``surface``.
        """
        table = self.surface()
        with Path(path).open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow([column.name for column in table.columns])
            writer.writerows(table.rows)

    @take.checks(path=take.path)
    def save_ply(self, path: str | Path) -> None:
        """Write the surface as a point cloud, where it is known, in the sites' frame [m].

        Where registered, it is in the other frame.
        """
        felt = self.map.surface
        known = np.isfinite(felt.mean)
        x, y = (layer[known] for layer in np.meshgrid(felt.x, felt.y))
        layers = [felt.mean[known], felt.sd[known], felt.probability[known]]
        places = self.placed.places(x, y)
        write_ply(
            path,
            {
                **dict(zip("xyz", places.T, strict=True)),
                **dict(zip(("stiffness", "stiffness_sd", "probability"), layers, strict=True)),
            },
        )


def _keep_finite(value: float) -> float | None:
    return float(value) if value == value else None


def _layer(layer: np.ndarray) -> list[list[float | None]]:
    return [[_keep_finite(value) for value in row] for row in layer]


@take.checks(
    estimators=take.several(take.text, "names of estimators"),
    effects=take.several(take.path, "paths"),
    rig=take.optional(take.choice(*FILTERED_RIGS)),
    raster=take.number(above=0.0, unit="m"),
    contrast=take.number(above=1.0, below=100.0),
    next=take.whole(),
    sought=take.optional(take.instance(Sought, SOUGHT)),
    choose_for=take.choice(*PURPOSES),
    outliers=take.optional(take.number(least=0.0, below=1.0)),
)
def map_sites(
    measured: Source,
    *,
    estimators: Sequence[str] = (),
    effects: Sequence[str | Path] = (),
    rig: FilteredRig | None = None,
    raster: float = RASTER,
    contrast: float = SOUGHT_CONTRAST,
    within: Source | None = None,
    no_go: Sequence[Source] = (),
    next: int = 0,
    sought: Sought | None = None,
    register: Source | None = None,
    choose_for: Purpose = "both",
    outliers: float | None = 0.0,
) -> MapResult:
    """Map the stiffness over the sites of a recorded scan, or of a table of sites.

    Parameters
    ----------
    measured : Measurements, path, or table in memory
        The scan, with its announced sites; or a table with the columns x, y [m], k [N/m] and
        perhaps k_sd [N/m], z [m], t [s] and site, a row a visit of a site; or with other units in
        their names, such as x_mm.
    estimators : sequence of str
        Filters to run on the samples of a scan; by default the recorded estimates are taken.
    effects : sequence of path
        Python files with effects of the user's own that a recorded model needs; they are run.
    rig : FilteredRig, optional
        How the instrument couples to the tissue; by default as recorded, else this suite's own
        probe.
    raster : float
        Step of the surface [m].
    contrast : float
        Of the inclusions that could hide: stiffness over their middle, over the background's.
    within : path or table in memory, optional
        Corners of the area in question, with the columns x, y [m]: the map speaks of all of it,
        however far from the sites.
    no_go : sequence of path or table in memory
        Corners of each area where no further site may be.
    next : int
        How many further sites to choose within the area.
    sought : Sought, optional
        Which inclusions matter, and how surely the question is to be answered; by default of 4 mm
        or more at the contrast, with a probability of 0.95.
    register : path or table in memory, optional
        Point pairs: columns x, y and perhaps z [m] in the map's frame, X, Y and perhaps Z [m] in
        another one, in which the results are given, too.
    choose_for : str
        The purpose of further sites: ``edge``, the outline of found inclusions; ``find``,
        inclusions that no site has felt; ``both`` in turn.
    outliers : float, optional
        Share of the sites that err far more than they state, by a slip for one. 0 where the robot
        verified contact at each; None if it is learnt. Beside outliers an inclusion that one site
        feels is not sure: palpate again where ``again`` says.

    Raises
    ------
    TissueProbeError
        If it cannot be read, has no recorded estimates, no sites, or none with a value; if all are
        far from the area; or if there is no place for a further site.
    """
    area = _polygon(within, "within") if within is not None else None
    zones = [_polygon(zone, "no_go") for zone in _each_area(no_go)]
    pairs = _read("register", register, read_pairs, "point pairs") if register is not None else None
    for name, given in (("next", next), ("no_go", zones), ("sought", sought)):
        if given and area is None:
            raise ParameterError(f"`{name}` is of an area: give `within`")

    def answer_question(
        sites: Sites,
        results: tuple[SiteResult, ...],
        phantom: Phantom | FeltTable | None,
        notes: tuple[str, ...],
    ) -> MapResult:
        chart = Chart.of(sites)
        if area is not None:
            _check_near(area, sites, chart)
        sampled = Sampled.of(chart.sites, area, outliers=outliers, raster=raster)
        found = read_out(sampled, chart.sites, raster=raster, contrast=contrast)
        placed = PlacedMap(chart.places, found)
        if pairs is not None:
            placed = RegisteredMap(chart.places, found, _registration(pairs, sites))
        told = (*notes, chart.note) if chart.note else notes
        result = MapResult(
            chart.sites, results, found, phantom, told, placed, laid_flat=bool(chart.note)
        )
        if area is None:
            return result
        last = len(sites.x) - 1 if sites.t is None else int(sites.t.argmax())
        start = float(sites.x[last]), float(sites.y[last])
        chosen: list[NextSite] = []
        if next:
            chosen = next_sites(sampled, next, area, no_go=zones, start=start, purpose=choose_for)
        known = answer(sampled, sought or Sought(contrast=contrast))
        return replace(result, next=tuple(chosen), answer=known)

    table = _site_table(measured)
    if table is not None:
        if estimators or effects or rig:
            raise ParameterError(
                f"{table.path} is a table of sites, which has no samples: leave out `estimator`, "
                "`effects` and `rig`"
            )
        sites, learnt = _sites_of_table(read_sites(table))
        return answer_question(sites, (), None, learnt)
    refuse_misnamed_sites(measured)
    parts = measurements_of(measured).parts
    if len(parts) != 1:
        raise ParameterError(f"{len(parts)} recordings are given: a map is of one scan")
    (part,) = parts
    if not part.recording.sites:
        raise ParameterError(
            f"{part.name} announces no palpation sites: there is nothing to map; give a scan or a "
            "table of sites"
        )
    if estimators:
        files, stated = tuple(map(Path, effects)), {"rig": rig} if rig else {}
        estimates = [estimate_again(part.recording, name, files, stated) for name in estimators]
    else:
        if effects or rig:
            raise ParameterError(
                "`effects` and `rig` are for filters that run on the samples: give one by "
                "`estimator`, or leave them out to map the recorded estimates"
            )
        estimates = list(read_estimates(part.path).values()) if part.is_own and part.path else []
        if not estimates:
            raise ParameterError(
                f"{part.name} has no recorded estimates: give a filter by `estimator`"
            )
    results = tuple(gather_sites(part.recording, estimates).results())
    if results and not any(each.has_value for each in results):
        raise ParameterError(UNHEARD.format(part.name, len(results)))
    return answer_question(sites_of(results), results, find_phantom(part.recording), part.notes)


def _sites_of_table(columns: Mapping[str, np.ndarray]) -> tuple[Sites, tuple[str, ...]]:
    """Return the sites of a table, and notes on them, in sentences."""
    x, y, k = (columns[name] for name in ("x", "y", "k"))
    z, t = columns.get("z", np.zeros_like(x)), columns.get("t")
    if "k_sd" in columns:
        return Sites(x, y, z, t, k, columns["k_sd"]), ()
    flat = Chart.of(Sites(x, y, z, t, k, np.zeros_like(k))).sites
    share = scatter(flat.x[flat.felt], flat.y[flat.felt], k[flat.felt])
    note = SCATTER_LEARNT.format(share)
    return Sites(x, y, z, t, k, share * np.abs(k)), (note,)


def _polygon(corners: Source, parameter: str) -> Polygon:
    """Return a polygon that is given by a table of its corners; errors name the parameter."""
    return _read(parameter, corners, lambda table: Polygon(read_corners(table)), "its corners")


def _each_area(given: Source | Sequence[Source]) -> Sequence[Source]:
    """Return several tables of corners; one that is given alone is one of them."""
    alone = isinstance(given, (str, os.PathLike, Mapping)) or hasattr(given, "columns")
    if not alone and not isinstance(given, (list, tuple)):
        take.refuse("no_go", given, "a list of tables of corners")
    return [given] if alone else given


def _check_near(area: Polygon, sites: Sites, chart: Chart) -> None:
    """Refuse an area of another plane than the map's, or too far from all sites for one map."""
    if chart.note:
        raise ParameterError(f"`within` is an area of the sites' own x and y, but {chart.note}")
    places = np.column_stack([sites.x, sites.y])
    low, high = area.corners.min(axis=0), area.corners.max(axis=0)
    off = np.maximum(np.maximum(low - places, places - high), 0.0)
    if np.hypot(*off.T).min() > (high - low).max():
        there, here = (
            f"x {a[0]:.4g} to {b[0]:.4g} m, y {a[1]:.4g} to {b[1]:.4g} m"
            for a, b in ((low, high), (places.min(axis=0), places.max(axis=0)))
        )
        raise ParameterError(
            f"`within`: no site is in the area or near it: the area is at {there}, the sites are "
            f"at {here}; give both in one frame and in m"
        )


def _registration(pairs: dict[str, np.ndarray], sites: Sites) -> Registration:
    try:
        return registration_of(pairs, sites)
    except TissueProbeError as error:
        raise ParameterError(f"`register`: {error}") from None


def _read(parameter: str, given: Source, read: Callable[[Columns], Read], what: str) -> Read:
    """Return the data of a table; errors name the parameter."""
    try:
        if isinstance(given, Measurements):
            raise ParameterError(f"samples are given; give a table of {what}")
        return read(_table(given))
    except TissueProbeError as error:
        raise ParameterError(f"`{parameter}`: {error}") from None


def _table(given: Any) -> Columns:
    """Return the columns of a table, from a file or from memory."""
    if isinstance(given, str | os.PathLike):
        return open_columns(Path(given))
    return columns_in_memory(given, IN_MEMORY)


def is_sites(measured: Source) -> bool:
    """Whether a table of sites is given, not samples."""
    return _site_table(measured) is not None


def refuse_misnamed_sites(measured: Source) -> None:
    """Refuse a table of places whose stiffness has another name than a table of sites needs.

    Raises
    ------
    RecordingError
        Says which columns it needs.
    """
    columns = _columns(measured)
    if columns is not None:
        refuse_misnamed(columns)


def _site_table(measured: Source) -> Columns | None:
    """Return the table of sites that is given, if it is one."""
    columns = _columns(measured)
    return columns if columns is not None and is_site_table(columns) else None


def _columns(measured: Source) -> Columns | None:
    """Return the columns of a given table, else None."""
    if isinstance(measured, Measurements):
        return None
    try:
        if isinstance(measured, str | os.PathLike):
            path = Path(measured)
            if path.is_dir() or is_bag(path):
                return None
        return _table(measured)
    except RecordingError:
        return None  # the reader of samples says why
