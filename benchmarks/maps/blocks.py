"""``python -m benchmarks blocks``: maps and explorations of blocks by finite elements, marked.

Contents: how the blocks are scanned and explored.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path

import numpy as np
from rich.table import Table

import tissue_probe as tp
from benchmarks.maps import explore, measure, tables
from benchmarks.maps.finite_elements import SOLIDS, block
from benchmarks.maps.marks import Marks, marks_of_block
from benchmarks.maps.tissues import SIDE

#: Each is solved once: linear in half a minute, hyperelastic in two minutes.
BLOCKS = 8
#: How they are scanned: solid, raster [mm], noise.
SCANNED = (
    ("linear", 8.0, 0.01),
    ("linear", 8.0, 0.03),
    ("linear", 5.0, 0.01),
    ("hyperelastic", 8.0, 0.01),
)
#: How they are explored: probes, noise.
PROBES, NOISE = 25, 0.01


def measured(folder: Path) -> dict[str, list[Marks]]:
    """Return marks by kind of scan; what finite elements take long for is kept in a folder."""
    scanned = {
        f"{solid}, {spacing:g} mm, noise {noise:.0%}": _scanned(solid, spacing, noise, folder)
        for solid, spacing, noise in SCANNED
    }
    explored = {
        f"{solid}, {PROBES} probes, noise {NOISE:.0%}": _explored(solid, folder) for solid in SOLIDS
    }
    return scanned | explored


def _scanned(solid: str, spacing: float, noise: float, folder: Path) -> list[Marks]:
    """Map blocks at a raster [mm], each under two noises."""
    along = np.arange(0.0, SIDE + 1e-9, spacing)
    places = [each.ravel() for each in np.meshgrid(along, along)]
    marks = []
    for number, again in product(range(1, BLOCKS + 1), range(2)):
        of = block(number, folder, solid)
        begin = time.process_time()
        found = tp.map(of.palpated(*places, noise, measure.FRESH + 2 * number + again))
        marks.append(marks_of_block(found.to_dict(), of, time.process_time() - begin))
    return marks


def _explored(solid: str, folder: Path) -> list[Marks]:
    """Explore blocks, each under two noises."""
    marks = []
    for number, again in product(range(1, BLOCKS + 1), range(2)):
        of, seed = block(number, folder, solid), explore.FRESH + 2 * number + again

        def palpate(x: np.ndarray, y: np.ndarray, of=of, seed=seed) -> dict[str, np.ndarray]:
            return of.palpated(x, y, NOISE, seed)

        found = explore.explored(palpate, PROBES)
        begin = time.process_time()
        told = tp.map(found.tables[PROBES], within=explore.WITHIN).to_dict()
        marks.append(marks_of_block(told, of, time.process_time() - begin))
    return marks


def shown(found: Mapping[str, Sequence[Marks]]) -> Table:
    """Return the table."""
    return tables.table("Finite elements: spheres felt 1.2 times and more", found)
