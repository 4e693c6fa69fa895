"""What is simulated: rig, tissue and hidden effects as one record of numbers.

Contents: every number the equation of motion knows, each without effect at its default.
"""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np

MOST_BRANCHES = 32  # or sliders


class Specimen(NamedTuple):
    """Numbers of the equation of motion; SI units, defaults without effect.

    m x'' + friction + mode = cell - tissue, where u is the coil, x the tip, e = x - d(t) the
    indentation; terms are explained at the functions of ``tissue``, ``tip`` and ``motion``.
    """

    # rig
    tip_mass: float = 0.04
    load_cell_stiffness: float = 9700.0
    load_cell_damping: float = 0.8
    play: float = 0.0  # half the gap between coil and load cell [m]
    # tissue, Kelvin-Voigt
    stiffness: float = 450.0
    damping: float = 5.0
    # stiffening
    cubic: float = 0.0  # [N/m^3]
    fung: float = 0.0  # [1/m]
    hertz_exponent: float = 0.0  # 0: not a Hertzian contact
    hertz_depth: float = 1e-3  # depth at which Hertz and linear spring agree [m]
    depth_damping: float = 0.0  # lambda [N s / m^(1+n)]
    depth_exponent: float = 1.0
    saturation_depth: float = 0.0  # [m]; 0: no saturation
    hyperbola_depth: float = 0.0  # [m]; 0: no hyperbola
    knee_stiffness: float = 0.0  # share of k that is added beyond the knee
    knee: float = 0.0  # [m]
    # damage by the largest depth
    damage: float = 0.0  # share of the spring's force that is lost at the most
    damage_depth: float = 1e-3  # [m]
    damage_returns: float = 0.0  # 1: none at the largest depth itself
    damage_reached: float = 0.0  # largest depth before the record's motion [m]
    # softening as it is worked
    worked_off: float = 0.0  # share of the spring's force that work takes away in the end
    working_path: float = 0.03  # way after which 1/e of that is left [m]
    worked_before: float = 0.0  # way before the tissue was pressed in for the record [m]
    # relaxation: springs [N/m] in series with dampers, and the dampers' rates k/c [1/s]
    branch_stiffness: tuple[float, ...] = ()
    branch_rate: tuple[float, ...] = ()
    branch_curved: float = 0.0  # 1: the branches' springs are curved as the tissue's own
    # contact
    unilateral: float = 0.0  # 1: tissue cannot pull
    pull_off: float = 0.0  # [N]
    bond_range: float = 0.0  # [m]; 0: the pull-off is at once
    bond_threads: float = 0.0  # 1: the bond falls as an exponential, else evenly
    # friction on the tip
    coulomb: float = 0.0  # [N]
    static: float = 0.0  # [N]
    stribeck_velocity: float = 1.0  # [m/s]
    bouc_force: float = 0.0  # [N]
    bouc_yield: float = 1e-4  # [m]
    bouc_beta: float = 0.5  # [-]
    bouc_gamma: float = 0.5  # [-]
    bouc_weakening: float = 0.0  # of nu by the work done over the force [1/m]
    # springs [N/m] behind sliders, and the compression at which each slides [m]
    slider_stiffness: tuple[float, ...] = ()
    slider_reach: tuple[float, ...] = ()
    corrugation: float = 0.0  # [N]
    corrugation_period: float = 1e-4  # [m]
    # inertia
    mode_mass: float = 0.0  # [kg]
    mode_stiffness: float = 0.0
    mode_damping: float = 0.0
    # in time
    surface_amplitude: float = 0.0  # d(t) [m]
    surface_frequency: float = 1.0  # [Hz]
    surface_phase: float = 0.0
    step: float = 0.0  # share of k
    step_time: float = 0.0  # [s]
    ramp: float = 0.0  # share of k a second
    damping_wave: float = 0.0  # share of beta
    damping_wave_frequency: float = 5.0  # [Hz]
    # in speed and amplitude
    rate_stiffening: float = 0.0  # [s/m]
    drag: float = 0.0  # [N s^2/m^2]
    one_way_damping: float = 0.0  # [N s/m]
    power_damping: float = 0.0  # [N s/m] at 1 cm/s
    power_exponent: float = 1.5
    agile_damping: float = 0.0  # [N s^2/m^2] of recent speed
    agile_time: float = 0.1  # [s]
    softening: float = 0.0  # [1/m]
    softening_time: float = 0.05  # [s]

    @property
    def branches(self) -> int:
        """How many relaxation branches there are."""
        return len(self.branch_stiffness)

    @property
    def sliders(self) -> int:
        """How many springs behind sliders there are."""
        return len(self.slider_stiffness)

    def record(self) -> np.void:
        """Return the numbers as one record that compiled code takes by reference."""
        record = np.zeros((), _RECORD)
        for name, value in self._asdict().items():
            if name in _LISTS:
                record[name][: len(value)] = value
            else:
                record[name] = value
        record["branches"], record["sliders"] = self.branches, self.sliders
        return cast(np.void, record[()])


_LISTS = ("branch_stiffness", "branch_rate", "slider_stiffness", "slider_reach")
_RECORD = np.dtype(
    [(name, np.float64, (MOST_BRANCHES,) if name in _LISTS else ()) for name in Specimen._fields]
    + [("branches", np.int64, ()), ("sliders", np.int64, ())]
)
