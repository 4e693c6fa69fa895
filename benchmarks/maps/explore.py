"""``python -m benchmarks explore``: tissues probed where it tells most, beside rasters.

Contents: explorations in numbers, and what they stated.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from rich.markup import escape
from rich.table import Table

import tissue_probe as tp
from benchmarks.maps import tables
from benchmarks.maps.marks import Marks, felt_radius, marks_of
from benchmarks.maps.measure import SHAPES, known, mapped
from benchmarks.maps.tissues import BODIES, ERRING, MIXED, SIDE, Tissue
from tissue_probe.mapping.exploration.answer import Sought, answer
from tissue_probe.mapping.exploration.choice import next_sites
from tissue_probe.mapping.exploration.first import first_sites
from tissue_probe.mapping.polygon import Polygon
from tissue_probe.mapping.posterior.posterior_sample import Sampled
from tissue_probe.mapping.sites import Sites

#: Seeds from here on were not looked at while the choice was made.
FRESH = 60_000
#: Numbers of probes at which a map is marked.
MARKED = (15, 20, 25, 30, 36)
_CORNERS = np.array([(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)])
AREA = Polygon(1e-3 * _CORNERS)
WITHIN = {"x": AREA.corners[:, 0], "y": AREA.corners[:, 1]}
SOUGHT = Sought()

#: Returns the table of sites [m, N/m] at places [mm].
Palpate = Callable[[np.ndarray, np.ndarray], dict[str, np.ndarray]]


@dataclass(frozen=True)
class Stated:
    """What an exploration stated first of "nothing is there".

    Attributes
    ----------
    probes : int or None
        After so many; None if it never stated it.
    wrong : bool
        Whether there is such an inclusion.
    """

    probes: int | None
    wrong: bool


@dataclass(frozen=True)
class Explored:
    """One exploration.

    Attributes
    ----------
    tables : dict
        The table of sites after each number of probes in ``MARKED``.
    decisions : list of float
        Processor time of each decision [s].
    nothing_after : int or None
        Probes when it was stated first that nothing is there.
    """

    tables: dict[int, dict[str, np.ndarray]]
    decisions: list[float]
    nothing_after: int | None


def explored(palpate: Palpate, most: int = MARKED[-1]) -> Explored:
    """Probe a tissue, each next site chosen from those before."""
    places = np.array(first_sites(AREA))
    decisions: list[float] = []
    nothing_after: int | None = None
    found: dict[int, dict[str, np.ndarray]] = {}
    while True:
        table = palpate(*(1e3 * places.T))
        if len(places) in MARKED:
            found[len(places)] = table
        sites = Sites(
            table["x"], table["y"], 0 * table["x"], table.get("t"), table["k"], table["k_sd"]
        )
        begin = time.process_time()
        sampled = Sampled.of(sites, AREA, quick=True)
        told = answer(sampled, SOUGHT, checked=False)
        chosen = next_sites(sampled, 1, AREA, start=tuple(places[-1]))
        decisions.append(time.process_time() - begin)
        # As ``decide`` does it, but the exploration goes on.
        if nothing_after is None and told.answered and told.none >= SOUGHT.probability:
            told = answer(Sampled.of(sites, AREA), SOUGHT)
            if told.answered and told.none >= SOUGHT.probability:
                nothing_after = len(places)
        if len(places) >= most:
            return Explored(found, decisions, nothing_after)
        places = np.append(places, [(chosen[0].x, chosen[0].y)], axis=0)


def _is_there(tissue: Tissue) -> bool:
    """Whether a nodule of the sought size and contrast is in the tissue, as it is felt."""
    return any(
        one.excess >= SOUGHT.contrast - 1.0 and felt_radius(one) >= 1e3 * SOUGHT.radius
        for one in tissue.nodules
    )


@dataclass(frozen=True)
class Measured:
    """All of one tissue: marks by number of probes, and of the raster; statement, and times."""

    marks: dict[str, Marks]
    stated: Stated
    decisions: list[float]


def measured(seed: int) -> Measured:
    """Explore a tissue, and scan it by a raster."""
    shape = SHAPES[seed % len(SHAPES)]
    tissue = Tissue.random(seed, shape, MIXED)
    found = explored(lambda x, y: tissue.palpated(x, y, seed))
    marks = {}
    for probes, table in found.tables.items():
        begin = time.process_time()
        told = tp.map(table, within=WITHIN).to_dict()
        seconds = time.process_time() - begin
        marks[f"{probes} probes"] = marks_of(tissue, told, shape, seconds)
    marks["raster of 81"] = mapped(tissue, 9, seed, shape)
    return Measured(marks, Stated(found.nothing_after, _is_there(tissue)), found.decisions)


def _after(probes: int, tissue: Tissue, seed: int, shape: str) -> Marks:
    """Explore a tissue by so many probes, and mark the map of all."""
    found = explored(lambda x, y: tissue.palpated(x, y, seed), probes)
    begin = time.process_time()
    told = tp.map(found.tables[probes], within=WITHIN).to_dict()
    return marks_of(tissue, told, shape, time.process_time() - begin)


def others(count: int, first: int) -> dict[str, list[Marks]]:
    """Return marks of tissues whose sites err, and of bodies of free form."""
    seeds = range(first, first + count)
    marks = {
        f"{name}, {MARKED[-1]} probes": [
            _after(MARKED[-1], Tissue.random(seed, shape, condition), seed, shape)
            for seed in seeds
            for shape in [SHAPES[seed % len(SHAPES)]]
        ]
        for name, condition in ERRING.items()
    }
    for name in BODIES:
        marks[f"{name}, 25 probes"] = [
            _after(25, Tissue.of_bodies(name, seed), seed, name) for seed in seeds
        ]
    return marks


def measure(count: int, first: int = FRESH) -> dict[str, Any]:
    """Return marks after each number of probes and of the raster, statements and times."""
    found = gathered([measured(seed) for seed in range(first, first + count)])
    return found | {"others": others(max(count // 2, 1), first)}


def gathered(tissues: Sequence[Measured]) -> dict[str, Any]:
    """Return the marks by number of probes, and all else, of many tissues."""
    return {
        "marks": {name: [one.marks[name] for one in tissues] for name in tissues[0].marks},
        "stated": [one.stated for one in tissues],
        "decisions": [each for one in tissues for each in one.decisions],
    }


def shown(found: Mapping[str, Any]) -> list[Table]:
    """Return the tables."""
    marks: Mapping[str, Sequence[Marks]] = found["marks"]
    return [
        tables.table("Explored, mixed condition", marks),
        tables.table("Sites that err; bodies of free form, hard-edged", found["others"]),
        _statements(found),
    ]


def _statements(found: Mapping[str, Any]) -> Table:
    told: list[Stated] = [one for one in found["stated"] if one.probes is not None]
    free = [one for one in found["stated"] if not one.wrong]
    table = Table("", "", title=f'"no {SOUGHT.text}" at P >= {SOUGHT.probability:g}')
    table.add_row("stated, and wrong", tables.share(sum(one.wrong for one in told), len(told)))
    right = sum(one.probes is not None for one in free)
    table.add_row("nothing is there, and it is stated", tables.share(right, len(free)))
    probes = [one.probes for one in told]
    table.add_row("after so many probes, median", f"{np.median(probes):.0f}" if probes else "-")
    times = 1e3 * np.array(found["decisions"])
    table.add_row(escape("a decision: processor time [ms], median"), f"{np.median(times):.0f}")
    table.add_row("longest of 95 %", f"{np.quantile(times, 0.95):.0f}")
    return table


def kept(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return all of it as JSON has it."""
    return {
        "marks": {n: [known(asdict(one)) for one in marks] for n, marks in found["marks"].items()},
        "others": {
            n: [known(asdict(one)) for one in marks] for n, marks in found["others"].items()
        },
        "stated": [asdict(one) for one in found["stated"]],
        "decisions": found["decisions"],
    }
