"""The probe's equations once more, for tests: as a matrix, integrated by SciPy's DOP853.

What belongs here: nothing of the package, so that it can be wrong in no common way.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

STAGE_LAG = 0.005


def integrate(settings, tissue, depths, voltages):
    """Return position [m] and force [N] at each sample, from rest.

    Parameters
    ----------
    settings : SimulatedProbeSettings
        Constants.
    tissue : tuple of float
        Stiffness [N/m] and damping [N s/m]; both 0 in free air.
    depths, voltages : array, shape (n,)
        Where the stage is told to stand below the surface [m], and the coil's command [V], each
        held for one sample. The stage stands at the first depth from the beginning.
    """
    m, M = settings.tip_mass, settings.coil_mass
    k0, b0 = settings.load_cell_stiffness, settings.load_cell_damping
    k, b = tissue
    s, c, K = settings.suspension_stiffness, settings.bearing_damping, settings.force_constant
    L, R = settings.coil_inductance, settings.coil_resistance
    # Columns: tip x and x', coil u and u', current, depth d; the target depth is an input.
    A = np.array(
        [
            [0, 1, 0, 0, 0, 0],
            [-(k0 + k) / m, -(b0 + b) / m, k0 / m, b0 / m, 0, (b / STAGE_LAG - k) / m],
            [0, 0, 0, 1, 0, 0],
            [k0 / M, b0 / M, -(k0 + s) / M, -(b0 + c) / M, K / M, 0],
            [0, 0, 0, -K / L, -R / L, 0],
            [0, 0, 0, 0, 0, -1 / STAGE_LAG],
        ]
    )
    by_voltage = np.array([0, 0, 0, 0, 1 / L, 0])
    by_depth = np.array([0, -b / STAGE_LAG / m, 0, 0, 0, 1 / STAGE_LAG])
    state = np.array([0, 0, 0, 0, 0, depths[0]])
    period = round(1e9 / settings.sample_rate) * 1e-9
    samples = []
    for voltage, depth in zip(voltages, depths, strict=True):
        samples.append((state[2], k0 * (state[2] - state[0])))
        constant = by_voltage * voltage + by_depth * depth
        solution = solve_ivp(
            lambda _, y, constant=constant: A @ y + constant,
            (0.0, period),
            state,
            method="DOP853",
            rtol=1e-10,
            atol=1e-14,
        )
        state = solution.y[:, -1]
    return np.array(samples).T
