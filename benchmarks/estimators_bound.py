"""The Cramer-Rao bound of an experiment, by finite differences of its exact simulation.

Independent of the package's own bound: no equation or code is shared.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from benchmarks.estimators_simulator import Experiment


def cramer_rao_bound(experiment: Experiment) -> np.ndarray:
    """Return the smallest possible standard deviations of k [N/m] and beta [N s/m] at its end.

    Tip position and velocity at the start are unknown too; the position's rounding is ignored.
    """
    phase = round(experiment.phase, 2)
    return _bound(replace(experiment, seed=0, phase=phase, force_noise=0.0, encoder_resolution=0.0))


@cache
def _bound(experiment: Experiment) -> np.ndarray:
    noise = Experiment().force_noise
    (_, k, b), *_ = experiment.tissue
    columns = []
    for change in (
        {"tissue": ((0.0, k + 0.5, b),)},
        {"tissue": ((0.0, k, b + 0.01),)},
        {"start": (1e-6, 0.0)},
        {"start": (0.0, 1e-4)},
    ):
        up = replace(experiment, **change).run()[1]
        down = replace(experiment, **_mirrored(experiment, change)).run()[1]
        columns.append((up - down) / 2)
    sensitivity = np.array(columns).T / np.array([0.5, 0.01, 1e-6, 1e-4]) / noise
    return np.sqrt(np.diag(np.linalg.inv(sensitivity.T @ sensitivity)))[:2]


def _mirrored(experiment: Experiment, change: dict) -> dict:
    """Return the same change in the other direction."""
    if "start" in change:
        return {"start": tuple(-value for value in change["start"])}
    (_, k, b), *_ = experiment.tissue
    (_, k_up, b_up), *_ = change["tissue"]
    return {"tissue": ((0.0, 2 * k - k_up, 2 * b - b_up),)}
