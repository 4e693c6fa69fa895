"""``python -m benchmarks map``: maps of many tissues, marked.

What belongs here: which tissues, and the time of a map. What does not: marks and tables.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from rich.table import Table

import tissue_probe as tp
from benchmarks.maps import tables
from benchmarks.maps.marks import Marks, marks_of
from benchmarks.maps.tissues import MIXED, Condition, Tissue, raster

GRIDS = (5, 7, 9)
SHAPES = ("plateau", "heavy tail", "ellipse")
#: Seeds from here on were not looked at while the map was made.
FRESH = 50_000
CONDITIONS = {
    "40 % relaxation": replace(MIXED, relaxation=0.4, nodules=0),
    "50 % tilt": replace(MIXED, tilt=0.5, nodules=0),
}


def mapped(tissue: Tissue, sites: int, seed: int, shape: str) -> Marks:
    """Palpate a tissue at a raster of sites, map it, and mark the map."""
    table = tissue.palpated(*raster(sites), seed)
    begin = time.process_time()
    found = tp.map(table)
    seconds = time.process_time() - begin
    return marks_of(tissue, found.to_dict(), shape, seconds)


def _set(
    count: int, sites: int, shapes: Sequence[str], condition: Condition, first: int
) -> list[Marks]:
    marks = []
    for seed in range(first, first + count):
        shape = shapes[seed % len(shapes)]
        marks.append(mapped(Tissue.random(seed, shape, condition), sites, seed, shape))
    return marks


def measure(count: int, first: int = FRESH) -> dict[str, dict[str, list[Marks]]]:
    """Return marks by table and column."""
    mapped(Tissue.random(0, SHAPES[0]), 5, 0, SHAPES[0])  # compiles what is not kept compiled
    mixed = {f"{n} x {n}": _set(count, n, SHAPES, MIXED, first) for n in GRIDS}
    seven = mixed["7 x 7"]
    shapes = {shape: [one for one in seven if one.shape == shape] for shape in SHAPES}
    shapes["gaussian"] = _set(max(count // 3, 1), 7, ("gaussian",), MIXED, first)
    others = {
        f"{name}, {n} x {n}": _set(max(count // 4, 1), n, SHAPES, condition, first)
        for name, condition in CONDITIONS.items()
        for n in (5, 9)
    }
    return {"Mixed condition": mixed, "True shapes, 7 x 7": shapes, "Nothing there": others}


def shown(found: Mapping[str, Mapping[str, Sequence[Marks]]]) -> list[Table]:
    """Return the tables."""
    told = [tables.table(title, sets) for title, sets in found.items()]
    return [*told, tables.stated(found["Mixed condition"])]


def kept(found: Mapping[str, Mapping[str, Sequence[Marks]]]) -> dict[str, Any]:
    """Return the marks as JSON has them."""
    return {
        title: {name: [_known(asdict(one)) for one in marks] for name, marks in sets.items()}
        for title, sets in found.items()
    }


def _known(marks: dict[str, Any]) -> dict[str, Any]:
    return {
        name: None if isinstance(value, float) and not np.isfinite(value) else value
        for name, value in marks.items()
    }
