"""Blocks of tissue with stiff spheres, and the tip that presses them.

Contents: geometry, moduli, pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from benchmarks.maps.tissues import SIDE

HEIGHT, CELL = 12.0, 2.0  # mm, of the block and of its bricks
TIP = 3.0  # mm
POISSON = 0.45


@dataclass(frozen=True)
class Sphere:
    """A stiff sphere [mm]: middle, radius, depth of its top, modulus over the block's."""

    x: float
    y: float
    radius: float
    depth: float
    ratio: float


def random_spheres(rng: np.random.Generator) -> tuple[Sphere, ...]:
    """Draw three spheres that do not touch."""
    found: list[Sphere] = []
    while len(found) < 3:
        x, y = rng.uniform(4.0, SIDE - 4.0, 2)
        if all(math.hypot(x - other.x, y - other.y) >= 12.0 for other in found):
            radius, depth = rng.uniform(3.0, 4.5), rng.uniform(1.0, 6.0)
            depth = min(depth, HEIGHT - 2.0 * radius - 0.5)
            found.append(Sphere(x, y, radius, max(depth, 1.0), rng.uniform(3.0, 10.0)))
    return tuple(found)


def modulus(spheres: tuple[Sphere, ...], x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return Young's modulus over the block's at places [mm]; z is the height over the floor."""
    found = np.ones_like(x)
    for one in spheres:
        middle = HEIGHT - one.depth - one.radius
        inside = (x - one.x) ** 2 + (y - one.y) ** 2 + (z - middle) ** 2 < one.radius**2
        found = np.where(inside, one.ratio, found)
    return found


def pressure() -> tuple[np.ndarray, np.ndarray]:
    """Return places about the middle [mm], shape (2, n), and their shares of the force (Hertz)."""
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(-TIP, TIP, 13)] * 2))
    under = np.hypot(x, y) < TIP
    x, y = x[under], y[under]
    weights = np.sqrt(1.0 - (x**2 + y**2) / TIP**2)
    return np.array([x, y]), weights / weights.sum()
