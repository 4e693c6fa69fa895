"""The stiffness that a tip feels on a linear block, by finite elements.

The block is of trilinear bricks, on a floor that holds it; scikit-fem assembles it. The tip presses
with the pressure of a round indenter (Hertz), and its stiffness is force over displacement, both
weighted by the pressure: one factorisation serves all places.
"""

from __future__ import annotations

import numpy as np
import skfem
from scipy.sparse.linalg import splu
from skfem.helpers import ddot, sym_grad, trace

from benchmarks.maps.spheres import CELL, HEIGHT, POISSON, Sphere, modulus, pressure
from benchmarks.maps.tissues import SIDE

#: Distance between places where the tip is pressed [mm]; it costs little.
RASTER = 2.0
#: The block is wider than the scan, whose sides are not free [mm].
MARGIN = 10.0


def stiffness(spheres: tuple[Sphere, ...], along: np.ndarray) -> np.ndarray:
    """Return the stiffness at each place of a raster [mm], shape (y, x), in any unit."""
    sides = np.arange(-MARGIN, SIDE + MARGIN + CELL / 2, CELL)
    mesh = skfem.MeshHex.init_tensor(sides, sides, np.arange(0.0, HEIGHT + CELL / 2, CELL))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex1()), intorder=3)
    mu = 1.0 / (2.0 * (1.0 + POISSON))
    lam = POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))

    @skfem.BilinearForm
    def energy(u, v, w):
        strain, tested = sym_grad(u), sym_grad(v)
        return modulus(spheres, *w.x) * (
            lam * trace(strain) * trace(tested) + 2.0 * mu * ddot(strain, tested)
        )

    free = basis.complement_dofs(basis.get_dofs(lambda x: np.isclose(x[2], 0.0)).all())
    factor = splu(energy.assemble(basis)[free][:, free].tocsc())
    surface = skfem.Basis(mesh, skfem.ElementHex1())
    down = basis.nodal_dofs[2]
    felt = np.empty((along.size, along.size))
    points, weights = pressure()
    for i, y in enumerate(along):
        for j, x in enumerate(along):
            places = np.array([x + points[0], y + points[1], np.full(weights.size, HEIGHT - 1e-9)])
            load = np.zeros(basis.N)
            load[down] = surface.probes(places).T @ weights
            felt[i, j] = 1.0 / (load[free] @ factor.solve(load[free]))
    return felt
