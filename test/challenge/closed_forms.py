"""What the simulated probe must do under a steady sine of 10 Hz, in closed form."""

from __future__ import annotations

import numpy as np

from tissue_probe.challenge.motion import MOTION_RATE, move
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.trajectory import Trajectory

AMPLITUDE = 1e-3
ANGULAR = 2.0 * np.pi * 10.0
PERIOD = 5e-4


def vibrate(specimen, preload=0.0, amplitude=AMPLITUDE, rate=MOTION_RATE):
    """Return u [m] and F [N] of 2 s of an established sine of 10 Hz."""
    coil = Trajectory("sine10ss", amplitude, 2.0, preload=preload, hold=1.0)
    u, _ = coil.sample_motion(rate)
    return u[coil.before(rate) : -1], move(specimen, coil, rate)[coil.before(rate) :]


def hold(specimen, preload, duration=0.2):
    """Return F [N] of a coil at rest since 5 s."""
    coil = Trajectory("sine10", 0.0, duration, preload=preload, hold=5.0)
    return move(specimen, coil)[coil.before(MOTION_RATE) :]


def line(signal, frequency=10.0, rate=MOTION_RATE):
    """Return the complex amplitude at a frequency, over a whole number of its periods."""
    time = np.arange(signal.size) / rate
    return 2.0 * np.mean(signal * np.exp(-2j * np.pi * frequency * time))


def transfer(tissue, specimen):
    """Force of the load cell's spring by displacement of the coil [N/m], for a linear tissue Z.

    m x'' = (k0 + i w beta0)(u - x) - Z x, and F = k0 (u - x).
    """
    cell = specimen.load_cell_stiffness + 1j * ANGULAR * specimen.load_cell_damping
    tip = cell / (cell + tissue - specimen.tip_mass * ANGULAR**2)
    return specimen.load_cell_stiffness * (1.0 - tip)


def kelvin_voigt(specimen: Specimen) -> complex:
    """Dynamic stiffness k + i w beta [N/m]."""
    return specimen.stiffness + 1j * ANGULAR * specimen.damping


def lost_a_cycle(u, force, specimen):
    """Return the energy that tip and tissue take up in one of the 20 cycles [J], and tip x [m].

    The load cell must have no damper: the work of the coil is then that of the spring.
    """
    assert specimen.load_cell_damping == 0.0
    tip = u - force / specimen.load_cell_stiffness
    around = np.append(u, u[0])
    return np.sum(0.5 * (force + np.append(force[1:], force[0])) * np.diff(around)) / 20.0, tip
