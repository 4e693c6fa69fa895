"""The stiffness that a tip feels on a hyperelastic block into which it is pressed.

The block is neo-Hookean (felupe, trilinear bricks), under large strains: the tip presses as in
``linear_block``, to a depth of 1 mm, and its stiffness is the one about that state, as a probe that
vibrates there feels it. Pressed tissue above a stiff sphere is thinner, so that the sphere is felt
more than in a linear block.

Every place is a block of its own about the tip, since the strains are not small: a place takes a
second.
"""

from __future__ import annotations

import felupe as fem
import numpy as np
from scipy.interpolate import interpn
from scipy.sparse.linalg import splu

from benchmarks.maps.spheres import CELL, HEIGHT, POISSON, Sphere, modulus, pressure

#: Distance between places where the tip is pressed [mm]: half of the scans' own, which costs
#: minutes a block.
RASTER = 4.0
DEPTH = 1.0  # mm
#: A block about the tip ends here [mm]: beyond three radii of the contact little moves.
AROUND = 10.0


def stiffness(spheres: tuple[Sphere, ...], along: np.ndarray) -> np.ndarray:
    """Return the stiffness at each place of a raster [mm], shape (y, x), in any unit."""
    return np.array([[_felt(spheres, x, y) for x in along] for y in along])


def _felt(spheres: tuple[Sphere, ...], x: float, y: float) -> float:
    across = round(2.0 * AROUND / CELL) + 1
    mesh = fem.Cube(
        a=(x - AROUND, y - AROUND, 0.0),
        b=(x + AROUND, y + AROUND, HEIGHT),
        n=(across, across, round(HEIGHT / CELL) + 1),
    )
    region = fem.RegionHexahedron(mesh)
    field = fem.FieldContainer([fem.Field(region, dim=3)])
    young = modulus(spheres, *fem.Field(region, dim=3, values=mesh.points).interpolate())
    shear, bulk = young / (2.0 * (1.0 + POISSON)), young / (3.0 * (1.0 - 2.0 * POISSON))
    solid = fem.SolidBody(fem.NeoHooke(mu=shear, bulk=bulk), field)
    free = np.flatnonzero(np.repeat(~np.isclose(mesh.points[:, 2], 0.0), 3))
    return _pressed(solid, field, free, _load(mesh.points, x, y)[free])


def _load(points: np.ndarray, x: float, y: float) -> np.ndarray:
    """Return the shares of a unit force down on the nodes, shape (3 nodes,)."""
    top = np.flatnonzero(np.isclose(points[:, 2], HEIGHT))
    axes = [np.unique(points[:, axis]) for axis in (0, 1)]
    # One function a node, 1 there and 0 on the others; probed where the pressure acts.
    order = np.lexsort((points[top, 1], points[top, 0]))
    ones = np.eye(top.size).reshape(*map(len, axes), top.size)
    places, weights = pressure()
    shares = interpn(axes, ones, places.T + np.array([x, y])).T @ weights
    load = np.zeros(points.size)
    load[3 * top[order] + 2] = -shares
    return load


def _pressed(
    solid: fem.SolidBody, field: fem.FieldContainer, free: np.ndarray, load: np.ndarray
) -> float:
    """Press to DEPTH in two steps by Newton's method; return the stiffness about that state."""
    moved, force = field[0].values.reshape(-1), 0.0
    for depth in (DEPTH / 2.0, DEPTH):
        for _ in range(20):
            factor = splu(solid.assemble.matrix(field).tocsc()[free][:, free])
            inner = solid.assemble.vector(field).toarray().ravel()[free]
            rest, by_force = factor.solve(force * load - inner), factor.solve(load)
            # The displacement, weighted as the force is, is the depth.
            more = (depth - load @ (moved[free] + rest)) / (load @ by_force)
            force += more
            step = rest + more * by_force
            moved[free] += step
            if np.abs(step).max() < 1e-7 * DEPTH:
                break
        else:
            raise RuntimeError(f"no equilibrium was found at a depth of {depth:g} mm")
    factor = splu(solid.assemble.matrix(field).tocsc()[free][:, free])
    return 1.0 / float(load @ factor.solve(load))
