"""How well stiffness and damping can be known at all, before a run: the Cramer-Rao bound.

Contents: the information in an excitation. It replaces the persistence of excitation of the paper's
eqs. 11 and 12, which at 2 kHz, with u[t] so near u[t-1], say nothing practical.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissue_probe.estimation.layout import force_variance
from tissue_probe.estimation.settings import EstimatorSettings

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Bound:
    """Smallest possible standard deviations after each sample, shape (n,); inf where unknowable.

    Attributes
    ----------
    stiffness : array
        Of any unbiased estimate of k [N/m].
    damping : array
        Of any unbiased estimate of beta [N s/m].
    """

    stiffness: FloatArray
    damping: FloatArray


def cramer_rao_bound(
    position: FloatArray,
    sample_period: float,
    stiffness: float,
    damping: float,
    settings: EstimatorSettings,
    force_offset: bool = True,
) -> Bound:
    """Bound the error of (k, beta) against time for an excitation of the coil.

    The Fisher information is J = sum over the samples of s s^T / R, s being the force's
    derivatives by the tip's position and velocity at the start, k, beta and (with
    ``force_offset``) a constant force: all of them are unknown. The bound is the root of the
    diagonal of J^-1.

    Parameters
    ----------
    position : array, shape (n,)
        Displacement of the coil [m].
    sample_period : float
        Time between two samples [s].
    stiffness, damping : float
        The tissue's k [N/m] and beta [N s/m].
    settings : EstimatorSettings
        Instrument and noise.
    force_offset : bool
        Whether a constant force is unknown, too.
    """
    from tissue_probe.physics.rigs import OWN
    from tissue_probe.physics.simulation import simulate

    constants = (settings.tip_mass, settings.load_cell_stiffness, settings.load_cell_damping)
    offset = [0.0] if force_offset else []
    s = simulate(
        f"probe_{'offset' if force_offset else 'plain'}",
        OWN.compose(force_offset=force_offset),
        constants,
        [stiffness, damping, *offset],
        np.asarray(position, dtype=np.float64),
        sample_period,
    ).sensitivity
    scale = np.sqrt(np.mean(s**2, axis=0))
    if not np.all(scale > 0):
        nothing = np.full(len(s), np.inf)
        return Bound(nothing, nothing.copy())
    s = s / scale
    information = np.cumsum(s[:, :, None] * s[:, None, :], axis=0) / force_variance(settings)
    variances = np.full(s.shape, np.inf)
    known = np.linalg.cond(information) < 1e12
    variances[known] = np.diagonal(np.linalg.inv(information[known]), axis1=1, axis2=2)
    deviations = np.sqrt(variances) / scale
    return Bound(deviations[:, 2], deviations[:, 3])
