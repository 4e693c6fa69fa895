"""The best that a Kelvin-Voigt model can do: a small output-error fit to measure an effect by.

What belongs here: the fit that says how much of the force an effect leaves unexplained.
What does not: diagnosis; it has a fit of its own, and the two share nothing.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import cont2discrete, lfilter

from tissue_probe.challenge.motion import SAMPLE_RATE
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.signals import FloatArray

LOWEST, HIGHEST = (1.0, 1e-4), (1e5, 1e3)  # k [N/m], beta [N s/m]


def fit_residual(position: FloatArray, force: FloatArray, rig: Specimen) -> FloatArray:
    """Return what the best k, beta and initial state of the tip leave of the force [N].

    Parameters
    ----------
    position, force : arrays, shape (n,)
        At 2 kHz [m], [N].
    rig : Specimen
        Its mass, load cell, and the k and beta to begin with.
    """
    coil = position - position[0]

    def left(values: FloatArray) -> FloatArray:
        k, beta = np.exp(values)
        explained = _force(coil, position[0], k, beta, rig)
        free = _free_motion(position.size, k, beta, rig)
        # The initial state acts linearly: the best one is known for each k, beta.
        amplitudes = np.linalg.lstsq(free, force - explained, rcond=None)[0]
        return force - explained - free @ amplitudes

    start = np.log([rig.stiffness, rig.damping])
    bounds = (np.log(LOWEST), np.log(HIGHEST))
    return left(least_squares(left, start, bounds=bounds, xtol=1e-6, ftol=1e-6).x)


def _force(coil: FloatArray, start: float, k: float, beta: float, rig: Specimen) -> FloatArray:
    """Force k0 (u - x) from equilibrium; x / u = (beta0 s + k0) / (m s^2 + b s + K)."""
    k0 = rig.load_cell_stiffness
    denominator = [rig.tip_mass, rig.load_cell_damping + beta, k0 + k]
    numerator, poles = _discrete((rig.load_cell_damping, k0), tuple(denominator))
    tip = lfilter(numerator, poles, _flattened(coil))
    return k0 * (coil - tip + start * k / (k0 + k))


def _discrete(
    numerator: tuple[float, ...], denominator: tuple[float, ...]
) -> tuple[FloatArray, FloatArray]:
    """Sample a transfer function whose input runs straight from sample to sample."""
    b, a, _ = cont2discrete((numerator, denominator), 1.0 / SAMPLE_RATE, "foh")
    return np.squeeze(b), a


def _flattened(coil: FloatArray) -> FloatArray:
    """Raise a signal by what straight lines between its samples cut off: 1/12 of its bend."""
    raised = coil.copy()
    raised[1:-1] -= np.diff(coil, 2) / 12.0
    return raised


def _free_motion(count: int, k: float, beta: float, rig: Specimen) -> FloatArray:
    """Force of the tip swinging freely from a displacement and from a velocity, shape (n, 2)."""
    root = np.emath.sqrt(
        (rig.load_cell_damping + beta) ** 2 - 4.0 * rig.tip_mass * (rig.load_cell_stiffness + k)
    )
    pole = (root - rig.load_cell_damping - beta) / (2.0 * rig.tip_mass)
    other = (-root - rig.load_cell_damping - beta) / (2.0 * rig.tip_mass)
    time = np.arange(count) / SAMPLE_RATE
    if np.iscomplexobj(pole):
        swing = np.exp(pole * time)
        return np.column_stack([swing.real, swing.imag])
    return np.column_stack([np.exp(pole * time), np.exp(other * time)])
