"""Tissues by finite elements: blocks with stiff spheres, and what a tip feels on them.

What belongs here: the felt stiffness over a block, kept in a file. What does not: marks.

The block is linear, of trilinear bricks, on a floor that holds it; scikit-fem assembles it. The tip
presses with the pressure of a round indenter of 3 mm radius (Hertz), and its stiffness is force
over displacement, both weighted by the pressure: one factorisation serves all places.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import skfem
from scipy.interpolate import RegularGridInterpolator
from scipy.sparse.linalg import splu
from skfem.helpers import ddot, sym_grad, trace

from benchmarks.maps.tissues import SIDE, STATED, STIFFNESS

#: The block is wider than the scan, whose sides are not free [mm].
MARGIN, HEIGHT, CELL = 10.0, 12.0, 2.0
TIP = 3.0  # mm
POISSON = 0.45
RASTER = 2.0  # mm, of the places where the tip is pressed; linear between
FELT = 1.2  # a nodule that is felt less is none


@dataclass(frozen=True)
class Sphere:
    """A stiff sphere [mm]: middle, radius, depth of its top, modulus over the block's."""

    x: float
    y: float
    radius: float
    depth: float
    ratio: float


@dataclass(frozen=True)
class Block:
    """A block with spheres, and what is felt on it.

    Attributes
    ----------
    along : array
        Places of the raster, in x and in y alike [mm].
    felt : array
        Stiffness there over that of the plain block [-].
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


def block(seed: int, folder: Path) -> Block:
    """Return a random block of three spheres; solved once, then read from the folder."""
    spheres = _spheres(np.random.default_rng([seed, 453]))
    along = np.arange(0.0, SIDE + RASTER / 2, RASTER)
    folder.mkdir(parents=True, exist_ok=True)
    plain = _kept(folder / "plain.npz", (), along)
    felt = _kept(folder / f"block_{seed}.npz", spheres, along)
    return Block(spheres, along, felt / plain)


def _kept(path: Path, spheres: tuple[Sphere, ...], along: np.ndarray) -> np.ndarray:
    if not path.exists():
        np.savez(path, felt=_stiffness(spheres, along))
    with np.load(path) as kept:
        return kept["felt"]


def _spheres(rng: np.random.Generator) -> tuple[Sphere, ...]:
    found: list[Sphere] = []
    while len(found) < 3:
        x, y = rng.uniform(4.0, SIDE - 4.0, 2)
        if all(math.hypot(x - other.x, y - other.y) >= 12.0 for other in found):
            radius, depth = rng.uniform(3.0, 4.5), rng.uniform(1.0, 6.0)
            depth = min(depth, HEIGHT - 2.0 * radius - 0.5)
            found.append(Sphere(x, y, radius, max(depth, 1.0), rng.uniform(3.0, 10.0)))
    return tuple(found)


def _stiffness(spheres: tuple[Sphere, ...], along: np.ndarray) -> np.ndarray:
    """Return the stiffness at each place of a raster, shape (y, x), in any unit."""
    sides = np.arange(-MARGIN, SIDE + MARGIN + CELL / 2, CELL)
    mesh = skfem.MeshHex.init_tensor(sides, sides, np.arange(0.0, HEIGHT + CELL / 2, CELL))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex1()), intorder=3)
    mu = 1.0 / (2.0 * (1.0 + POISSON))
    lam = POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))

    @skfem.BilinearForm
    def energy(u, v, w):
        strain, tested = sym_grad(u), sym_grad(v)
        return _modulus(spheres, *w.x) * (
            lam * trace(strain) * trace(tested) + 2.0 * mu * ddot(strain, tested)
        )

    free = basis.complement_dofs(basis.get_dofs(lambda x: np.isclose(x[2], 0.0)).all())
    factor = splu(energy.assemble(basis)[free][:, free].tocsc())
    surface = skfem.Basis(mesh, skfem.ElementHex1())
    down = basis.nodal_dofs[2]
    felt = np.empty((along.size, along.size))
    points, weights = _pressure()
    for i, y in enumerate(along):
        for j, x in enumerate(along):
            places = np.array([x + points[0], y + points[1], np.full(weights.size, HEIGHT - 1e-9)])
            load = np.zeros(basis.N)
            load[down] = surface.probes(places).T @ weights
            felt[i, j] = 1.0 / (load[free] @ factor.solve(load[free]))
    return felt


def _modulus(spheres: tuple[Sphere, ...], x: np.ndarray, y: np.ndarray, z: np.ndarray):
    modulus = np.ones_like(x)
    for one in spheres:
        middle = HEIGHT - one.depth - one.radius
        inside = (x - one.x) ** 2 + (y - one.y) ** 2 + (z - middle) ** 2 < one.radius**2
        modulus = np.where(inside, one.ratio, modulus)
    return modulus


def _pressure() -> tuple[np.ndarray, np.ndarray]:
    """Return places about the middle [mm] and their shares of the force, by Hertz."""
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(-TIP, TIP, 13)] * 2))
    under = np.hypot(x, y) < TIP
    x, y = x[under], y[under]
    weights = np.sqrt(1.0 - (x**2 + y**2) / TIP**2)
    return np.array([x, y]), weights / weights.sum()
