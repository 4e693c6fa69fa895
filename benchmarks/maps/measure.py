"""``python -m benchmarks map``: maps of many tissues, marked.

Contents: which tissues, and the time of a map.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from rich.table import Table

import tissue_probe as tp
from benchmarks.maps import surfaces, tables
from benchmarks.maps.marks import Marks, marks_of
from benchmarks.maps.tissues import BODIES, ERRING, MIXED, SIDE, Condition, Tissue, raster

GRIDS = (5, 7, 9)
SHAPES = ("plateau", "heavy tail", "ellipse")
#: Seeds from here on were not looked at while the map was made.
FRESH = 50_000
#: Share of the sites that are palpated again at most.
MOST_AGAIN = 0.1
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


def mapped_scattered(tissue: Tissue, sites: int, seed: int, shape: str) -> Marks:
    """Palpate a tissue at scattered sites, as many as a raster's, map it, and mark the map."""
    x, y = np.random.default_rng([seed, 48]).uniform(0.0, SIDE, (2, sites**2))
    begin = time.process_time()
    found = tp.map(tissue.palpated(x, y, seed))
    return marks_of(tissue, found.to_dict(), shape, time.process_time() - begin)


def _set(
    count: int,
    sites: int,
    shapes: Sequence[str],
    condition: Condition,
    first: int,
    mark: Callable[[Tissue, int, int, str], Marks] = mapped,
) -> list[Marks]:
    marks = []
    for seed in range(first, first + count):
        shape = shapes[seed % len(shapes)]
        marks.append(mark(Tissue.random(seed, shape, condition), sites, seed, shape))
    return marks


def mapped_again(tissue: Tissue, sites: int, seed: int, shape: str) -> Marks:
    """Map sites that may err, palpate again what hangs on one, and mark the map of all."""
    x, y = raster(sites)
    begin = time.process_time()
    found = tp.map(tissue.palpated(x, y, seed), outliers=None)
    again = found.again[: round(MOST_AGAIN * x.size)]
    if again:
        x, y = (
            np.append(x, [1e3 * one.x for one in again]),
            np.append(y, [1e3 * one.y for one in again]),
        )
        found = tp.map(tissue.palpated(x, y, seed), outliers=None)
    seconds = time.process_time() - begin
    return replace(marks_of(tissue, found.to_dict(), shape, seconds), again=len(again))


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
    fewer = max(count // 4, 1)
    erring = {
        f"{name}{told}": _set(fewer, 7, SHAPES, condition, first, mark)
        for name, condition in {"mixed": MIXED, **ERRING}.items()
        for told, mark in (("", mapped), (", again", mapped_again))
    }
    places = {
        "hard edges, raster": _set(fewer, 7, ("disc",), MIXED, first),
        "49 scattered": _set(fewer, 7, SHAPES, MIXED, first, mapped_scattered),
    }
    bodies = {
        name: [
            mapped(Tissue.of_bodies(name, seed), 9, seed, name)
            for seed in range(first, first + fewer)
        ]
        for name in BODIES
    }
    return {
        "Mixed condition": mixed,
        "True shapes, 7 x 7": shapes,
        "Nothing there": others,
        "Sites that err, 7 x 7; again: what hangs on one site is palpated once more": erring,
        "Hard edges, 7 x 7; scattered sites in 40 x 40 mm": places,
        "Bodies of free form, hard-edged, noise 5 %, 9 x 9": bodies,
        "Sites in space, one nodule": surfaces.in_space(surfaces.COUNT, first),
    }


def shown(found: Mapping[str, Mapping[str, Sequence[Marks]]]) -> list[Table]:
    """Return the tables."""
    told = [tables.table(title, sets) for title, sets in found.items()]
    return [*told, tables.stated(found["Mixed condition"])]


def kept(found: Mapping[str, Mapping[str, Sequence[Marks]]]) -> dict[str, Any]:
    """Return the marks as JSON has them."""
    return {
        title: {name: [known(asdict(one)) for one in marks] for name, marks in sets.items()}
        for title, sets in found.items()
    }


def known(marks: dict[str, Any]) -> dict[str, Any]:
    """Return marks with None where a number is not known: JSON has no NaN."""
    return {
        name: None if isinstance(value, float) and not np.isfinite(value) else value
        for name, value in marks.items()
    }
