"""A table's function is the natural cubic spline through its points, as are its derivatives."""

import numpy as np
import pytest
import sympy as sp
from scipy.interpolate import CubicSpline

from tissue_probe.physics.effects.effect import INDENTATION
from tissue_probe.physics.tabulated import tabulated

AT = (-1.2e-3, -3e-4, 0.0, 5e-4, 1e-3)
VALUES = (-0.4, -0.02, 0.1, 0.07, 0.5)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_a_table_gives_a_natural_spline_and_its_derivatives(order):
    spline = CubicSpline(AT, VALUES, bc_type="natural")
    written = tabulated(INDENTATION, AT, VALUES).diff(INDENTATION, order)
    for x in np.linspace(-1.1e-3, 9e-4, 9):
        found = float(written.subs(INDENTATION, sp.Float(x)))
        assert found == pytest.approx(float(spline(x, order)), rel=1e-9, abs=1e-12)


def test_beyond_its_points_a_table_goes_on_straight():
    written = tabulated(INDENTATION, AT, VALUES)
    near, far, farther = (float(written.subs(INDENTATION, x)) for x in (1e-3, 2e-3, 3e-3))
    assert farther - far == pytest.approx(far - near)
