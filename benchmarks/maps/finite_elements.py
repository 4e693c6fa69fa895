"""Tissues by finite elements: what a tip feels over a block, kept in a file.

Contents: the felt stiffness over a block, and its sites.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from benchmarks.maps import hyperelastic_block, linear_block
from benchmarks.maps.spheres import Sphere, random_spheres
from benchmarks.maps.tissues import SIDE, STATED, STIFFNESS

#: What the block is of, and who solves it.
SOLIDS: dict[str, ModuleType] = {"linear": linear_block, "hyperelastic": hyperelastic_block}
FELT = 1.2  # a nodule that is felt less is none


@dataclass(frozen=True)
class Block:
    """A block with spheres, and what is felt on it.

    Attributes
    ----------
    along : array
        Places of the raster, in x and in y alike [mm].
    felt : array
        Stiffness there over that of the plain block [-]; linear between.
    """

    spheres: tuple[Sphere, ...]
    along: np.ndarray
    felt: np.ndarray

    def contrast(self, sphere: Sphere) -> float:
        """Return how many times stiffer the block feels over a sphere, at most."""
        far = np.hypot(*np.meshgrid(self.along - sphere.x, self.along - sphere.y))
        return float(self.felt[far <= sphere.radius].max(initial=1.0))

    def palpated(self, x: np.ndarray, y: np.ndarray, noise: float, seed: int):
        """Return the table of sites [m, N/m] at places [mm]."""
        rng = np.random.default_rng([seed, 452])
        felt = RegularGridInterpolator((self.along, self.along), self.felt)((y, x))
        k = STIFFNESS * felt * (1.0 + noise * rng.standard_normal(x.size))
        return {"x": 1e-3 * x, "y": 1e-3 * y, "k": k, "k_sd": STATED * k}


def block(seed: int, folder: Path, solid: str = "linear") -> Block:
    """Return a random block of three spheres; solved once, then read from the folder."""
    spheres = random_spheres(np.random.default_rng([seed, 453]))
    folder.mkdir(parents=True, exist_ok=True)
    kept = "" if solid == "linear" else f"{solid}_"
    raster = SOLIDS[solid].RASTER
    along = np.arange(0.0, SIDE + raster / 2, raster)
    plain = _kept(folder / f"{kept}plain.npz", solid, (), along)
    felt = _kept(folder / f"{kept}block_{seed}.npz", solid, spheres, along)
    return Block(spheres, along, felt / plain)


def _kept(path: Path, solid: str, spheres: tuple[Sphere, ...], along: np.ndarray) -> np.ndarray:
    if not path.exists():
        np.savez(path, felt=SOLIDS[solid].stiffness(spheres, along))
    with np.load(path) as kept:
        return kept["felt"]
