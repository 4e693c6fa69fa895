"""The probe behind the channels: coil, load cell, tip and tissue, stepped exactly.

The same equations as the package's simulated probe, but solved by the matrix exponential: the two
share nothing but the constants.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from tissue_probe.devices.simulated_settings import SimulatedProbeSettings


class Plant:
    """A probe in contact from the beginning, at rest.

    Parameters
    ----------
    period : float
        Time of a step [s], over which the voltage is held.
    stiffness, damping : float
        The tissue's [N/m], [N s/m]; 0 in free air.
    """

    def __init__(self, period: float, stiffness: float, damping: float) -> None:
        s = SimulatedProbeSettings()
        m, M = s.tip_mass, s.coil_mass
        k0, b0 = s.load_cell_stiffness, s.load_cell_damping
        # State: current, u, u', x, x'; the last column is the voltage.
        A = np.zeros((6, 6))
        A[0, [0, 2, 5]] = -s.coil_resistance, -s.force_constant, 1.0
        A[0] /= s.coil_inductance
        A[1, 2] = A[3, 4] = 1.0
        A[2, :5] = s.force_constant, -k0 - s.suspension_stiffness, -b0 - s.bearing_damping, k0, b0
        A[2] /= M
        A[4, 1:5] = k0 / m, b0 / m, -(k0 + stiffness) / m, -(b0 + damping) / m
        self._step = expm(period * A)[:5]
        self._state = np.zeros(6)
        self._cell_stiffness = k0

    def step(self, voltage: float) -> tuple[float, float]:
        """Return displacement [m] and force [N] now, then go on for a period with ``voltage``."""
        state = self._state
        now = state[1], self._cell_stiffness * (state[1] - state[3])
        state[5] = voltage
        state[:5] = self._step @ state
        return now
