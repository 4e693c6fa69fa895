"""Tissues whose surface is no horizontal plane: one nodule each, and whether it is found alone.

Contents: the surfaces, and marks of maps of their sites.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

import tissue_probe as tp
from benchmarks.maps.marks import DECLARED, HIT, Marks
from benchmarks.maps.tissues import MIXED, SIDE, Nodule, Tissue, raster

#: How many of each.
COUNT = 20
TILT = math.radians(75.0)
BALL = 30.0  # mm, radius
#: Sites go this far from the pole of the ball [mm]: 45 degrees.
_RIM = BALL * math.pi / 4.0
_SITES = 7


def _wall(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.column_stack([u, np.zeros_like(u), v])


def _tilted(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.column_stack([u, math.cos(TILT) * v, math.sin(TILT) * v])


def _cap(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return places on a ball, at their distance from its pole along it."""
    across, up = u - SIDE / 2.0, v - SIDE / 2.0
    angle, around = np.hypot(across, up) / BALL, np.arctan2(up, across)
    flat = [np.sin(angle) * np.cos(around), np.sin(angle) * np.sin(around)]
    return BALL * np.column_stack([*flat, np.cos(angle)])


#: Where places along a surface [mm] lie in space, shape (n, 3), by its name.
SURFACES: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "wall": _wall,
    "plane tilted by 75 degrees": _tilted,
    "cap of a ball of 30 mm": _cap,
}


def _with_one_nodule(seed: int) -> Tissue:
    """Return a tissue of the mixed condition with one nodule, felt 1.5 to 3 times as stiff."""
    rng = np.random.default_rng([seed, 47])
    x, y = SIDE / 2.0 + rng.uniform(-10.0, 10.0, 2)
    nodule = Nodule(x, y, rng.uniform(4.0, 6.0), 1.0, rng.uniform(0.5, 2.0), "plateau", 0.0)
    plain = Tissue.random(seed, "plateau", replace(MIXED, nodules=0))
    return replace(plain, nodules=(nodule,))


def mapped_in_space(name: str, seed: int) -> Marks:
    """Palpate a tissue on a surface at a raster along it, and mark the map."""
    tissue, place = _with_one_nodule(seed), SURFACES[name]
    u, v = raster(_SITES)
    if name.startswith("cap"):
        on = np.hypot(u - SIDE / 2.0, v - SIDE / 2.0) <= _RIM
        u, v = u[on], v[on]
    table = tissue.palpated(u, v, seed)
    table.update(zip("xyz", 1e-3 * place(u, v).T, strict=True))
    begin = time.process_time()
    found = tp.map(table)
    seconds = time.process_time() - begin
    sure = [one for one in found.map.inclusions if one.probability >= DECLARED]
    (nodule,) = tissue.nodules
    (true,) = place(np.array([nodule.x]), np.array([nodule.y]))
    off = [math.dist(1e3 * np.array(found.in_space(one)), true) for one in sure]
    hit = min(off, default=math.inf) <= HIT
    location = [min(off)] if hit else []
    return Marks(name, 1, 0, int(hit), 0, len(sure) - hit, location=location, seconds=seconds)


def in_space(count: int, first: int) -> dict[str, list[Marks]]:
    """Return marks of so many tissues on each surface."""
    return {
        name: [mapped_in_space(name, seed) for seed in range(first, first + count)]
        for name in SURFACES
    }
