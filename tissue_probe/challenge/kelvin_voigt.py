"""The best that a Kelvin-Voigt model can do: a small output-error fit to measure an effect by.

Contents: the fit that says how much of the force an effect leaves unexplained, with the constants
of the rig known, or free within their tolerances.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter

from tissue_probe.challenge.instrument import CHALLENGE_RATE, FORCE_NOISE
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.tolerances import Tolerances
from tissue_probe.signals import FloatArray

LOWEST, HIGHEST = (1.0, 1e-4), (1e5, 1e3)  # k [N/m], beta [N s/m]
FARTHEST = 4.0  # standard deviations of a tolerance


def fit_residual(
    position: FloatArray, force: FloatArray, rig: Specimen, tolerances: Tolerances | None = None
) -> FloatArray:
    """Return what the best k, beta and initial state of the tip leave of the force [N].

    Parameters
    ----------
    position, force : arrays, shape (n,)
        At 2 kHz [m], [N].
    rig : Specimen
        Its mass, load cell, and the k and beta to begin with.
    tolerances : Tolerances, optional
        The rig's constants and the contact zero are fitted too, drawn to what they are.
    """
    coil = position - position[0]

    def measure_rest(values: FloatArray) -> FloatArray:
        k, beta = np.exp(values[:2])
        own, zero = (rig, 0.0) if tolerances is None else tolerances.draw_rig(rig, values[2:])
        poles = _poles(k, beta, own)
        over = force - _force(coil, position[0] - zero, k, poles, own)
        # The initial state acts linearly: the best one is known for each k, beta.
        free = _free_motion(force.size, poles)
        return over - free @ np.linalg.lstsq(free, over, rcond=None)[0]

    def draw_force(values: FloatArray) -> FloatArray:
        return np.concatenate([measure_rest(values), FORCE_NOISE * values[2:]])

    extra = 0 if tolerances is None else len(tolerances)
    start = np.concatenate([np.log([rig.stiffness, rig.damping]), np.zeros(extra)])
    low, high = (np.log(LOWEST), np.log(HIGHEST))
    bounds = (np.append(low, [-FARTHEST] * extra), np.append(high, [FARTHEST] * extra))
    return measure_rest(least_squares(draw_force, start, bounds=bounds, xtol=1e-6, ftol=1e-6).x)


def _poles(k: float, beta: float, rig: Specimen) -> tuple[complex, complex]:
    """Return the roots of m s^2 + (beta0 + beta) s + k0 + k."""
    b = rig.load_cell_damping + beta
    root = np.emath.sqrt(b**2 - 4.0 * rig.tip_mass * (rig.load_cell_stiffness + k))
    return (root - b) / (2.0 * rig.tip_mass), (-root - b) / (2.0 * rig.tip_mass)


def _force(
    coil: FloatArray, start: float, k: float, poles: tuple[complex, complex], rig: Specimen
) -> FloatArray:
    """Force k0 (u - x) from equilibrium; x / u = (beta0 s + k0) / (m (s - p) (s - q))."""
    k0, p, q = rig.load_cell_stiffness, *poles
    raised = _raise_bend(coil)
    share = (rig.load_cell_damping * p + k0) / (rig.tip_mass * (p - q))
    other = (rig.load_cell_damping * q + k0) / (rig.tip_mass * (q - p))
    if np.iscomplexobj(p):
        tip = 2.0 * (share * _first_order(raised, p)).real
    else:
        tip = share * _first_order(raised, p) + other * _first_order(raised, q)
    return k0 * (coil - tip + start * k / (k0 + k))


def _first_order(driven: FloatArray, pole: complex) -> FloatArray:
    """Return the response of 1 / (s - pole) to a signal that runs straight between samples."""
    z = pole / CHALLENGE_RATE
    decay = np.exp(z)
    new, old = (decay - 1.0 - z) / z**2, (1.0 - decay + z * decay) / z**2
    filtered: FloatArray = lfilter(
        [new / CHALLENGE_RATE, old / CHALLENGE_RATE], [1.0, -decay], driven
    )
    return filtered


def _raise_bend(coil: FloatArray) -> FloatArray:
    """Raise a signal by what straight lines between its samples cut off: 1/12 of its bend."""
    raised = coil.copy()
    raised[1:-1] -= np.diff(coil, 2) / 12.0
    return raised


def _free_motion(count: int, poles: tuple[complex, complex]) -> FloatArray:
    """Return the tip's two free motions, shape (n, 2)."""
    time = np.arange(count) / CHALLENGE_RATE
    swing = np.exp(poles[0] * time)
    if np.iscomplexobj(swing):
        return np.column_stack([swing.real, swing.imag])
    return np.column_stack([swing, np.exp(poles[1] * time)])
