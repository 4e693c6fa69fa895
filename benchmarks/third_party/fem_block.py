"""A block of tissue that a flat punch presses, by finite elements.

Contents: force against depth.

The block is a cylinder that rests on a floor without friction; a flat round punch, bonded, presses
its middle. scikit-fem solves the axisymmetric linear block (quadratic triangles, x is the radius);
felupe the block of a neo-Hookean solid (trilinear bricks of a quarter, by symmetry, large strains
in steps), which stiffens as it is pressed.

| block | what it is to the library |
|---|---|
| linear (scikit-fem) | a spring: nothing is hidden |
| neo-Hookean (felupe) | stiffening: exponential_stiffening, cubic_stiffening or hertz_contact |
"""

from __future__ import annotations

from dataclasses import dataclass

import felupe as fem
import numpy as np
import skfem
from skfem.helpers import sym_grad, trace

Array = np.ndarray


@dataclass(frozen=True)
class Block:
    """Radius and height of the block, radius of the punch [m]; Young's modulus [Pa], Poisson's."""

    radius: float
    height: float
    punch: float
    modulus: float
    poisson: float = 0.45

    @property
    def lame(self) -> tuple[float, float]:
        """Lame's constants lambda and mu [Pa]."""
        mu = self.modulus / (2.0 * (1.0 + self.poisson))
        return 2.0 * mu * self.poisson / (1.0 - 2.0 * self.poisson), mu


def linear_stiffness(block: Block, cells: int = 24) -> float:
    """Return force over depth [N/m] of the linear block, for small depths.

    Parameters
    ----------
    block : Block
        The block.
    cells : int
        Of the mesh along the radius.
    """
    steps = block.punch / max(round(cells * block.punch / block.radius), 1)
    outside = np.linspace(block.punch, block.radius, max(cells // 2, 2))
    radii = np.unique(np.concatenate([np.arange(0.0, block.punch, steps), outside]))
    mesh = skfem.MeshTri.init_tensor(radii, np.linspace(0.0, block.height, cells + 1))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP2()))
    lam, mu = block.lame

    @skfem.BilinearForm
    def energy(u, v, w):
        # Around the axis the strain is u_r / r, and a ring has the length 2 pi r.
        radius = w.x[0]
        around, other = u[0] / radius, v[0] / radius
        strain, tested = sym_grad(u), sym_grad(v)
        products = sum(strain[i, j] * tested[i, j] for i in range(2) for j in range(2))
        volume, other_volume = trace(strain) + around, trace(tested) + other
        whole = lam * volume * other_volume + 2.0 * mu * (products + around * other)
        return 2.0 * np.pi * radius * whole

    stiffness = energy.assemble(basis)
    axis = basis.get_dofs(lambda x: np.isclose(x[0], 0.0)).all("u^1")
    floor = basis.get_dofs(lambda x: np.isclose(x[1], 0.0)).all("u^2")
    pressed = basis.get_dofs(
        lambda x: np.isclose(x[1], block.height) & (x[0] <= block.punch * (1.0 + 1e-9))
    )
    down, across = pressed.all("u^2"), pressed.all("u^1")
    solution = basis.zeros()
    solution[down] = -1.0
    held = np.unique(np.concatenate([axis, floor, down, across]))
    solution = skfem.solve(*skfem.condense(stiffness, x=solution, D=held))
    return float(-(stiffness @ solution)[down].sum())


def neo_hookean_force(block: Block, depths: Array, cells: int = 6) -> Array:
    """Return the force [N] of the neo-Hookean block at some depths [m], ascending from 0.

    The block is a square column as wide as the cylinder, the punch a square as wide as the round
    one: a quarter of it is solved.
    """
    count = max(round(cells * block.punch / block.radius), 2)
    mesh = fem.Cube(b=(block.radius, block.radius, block.height), n=(cells + 1,) * 3)
    points = mesh.points.copy()
    for axis in range(2):
        # The first planes of the mesh lie under the punch, evenly.
        even = np.linspace(0.0, block.radius, cells + 1)
        moved = np.concatenate([
            np.linspace(0.0, block.punch, count + 1),
            np.linspace(block.punch, block.radius, cells - count + 1)[1:],
        ])  # fmt: skip
        points[:, axis] = np.interp(points[:, axis], even, moved)
    mesh = fem.Mesh(points, mesh.cells, mesh.cell_type)
    field = fem.FieldContainer([fem.Field(fem.RegionHexahedron(mesh), dim=3)])
    lam, mu = block.lame
    solid = fem.SolidBody(fem.NeoHooke(mu=mu, bulk=lam + 2.0 * mu / 3.0), field)
    under = np.isclose(points[:, 2], block.height)
    under &= np.all(points[:, :2] <= block.punch * (1.0 + 1e-9), axis=1)
    bounds = {
        "left": fem.Boundary(field[0], fx=0.0, skip=(False, True, True)),
        "front": fem.Boundary(field[0], fy=0.0, skip=(True, False, True)),
        "floor": fem.Boundary(field[0], fz=0.0, skip=(True, True, False)),
        "across": fem.Boundary(field[0], mask=under, skip=(False, False, True)),
        "down": fem.Boundary(field[0], mask=under, skip=(True, True, False)),
    }
    forces = np.zeros(depths.size)
    for number, depth in enumerate(depths):
        bounds["down"].value = -depth
        held, free = fem.dof.partition(field, bounds)
        prescribed = fem.dof.apply(field, bounds, held)
        fem.newtonraphson(items=[solid], dof0=held, dof1=free, ext0=prescribed, verbose=0)
        reaction = solid.assemble.vector(field).toarray().reshape(-1, 3)
        forces[number] = -4.0 * reaction[under, 2].sum()
    return forces
