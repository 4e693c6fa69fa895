"""A peer: sparse regression of the next sample (SINDy with control; Brunton et al., 2016).

Contents: polynomials of the last outputs and inputs, by PySINDy, simulated freely.
"""

from __future__ import annotations

import time
import warnings
from itertools import product
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from pysindy import STLSQ, DiscreteSINDy, PolynomialLibrary

from benchmarks.beside.data import STARTING, Set
from benchmarks.beside.results import Result, scored
from tissue_probe.signals import FloatArray

NAME = "PySINDy, polynomials of degree 3"
#: How many earlier outputs the next one is a polynomial of, beside as many inputs and its own, and
#: the degree: a mass on a spring has two, and the springs of these sets are cubic.
LAGS, DEGREE = (2, 3, 4), 3
THRESHOLDS = (0.0, 1e-4, 1e-3, 1e-2)
#: Share of the training record by which lags and threshold are chosen.
KEPT = 0.25


def measure(of: Set, data: Path) -> Result:
    """Learn the next output of the last ones, at the threshold that simulates best, and predict."""
    begun = time.process_time()
    force, position, _ = of.arrays(data)
    sizes = np.std(position), np.std(force)
    first = int((1.0 - KEPT) * position.size)
    scaled = position[:first] / sizes[0], force[:first] / sizes[1]
    models = [_learnt(*scaled, *each) for each in product(LAGS, THRESHOLDS)]
    tried = [
        scored(_left(model, position[first:], force[first:], sizes), of.per_unit)
        for model in models
    ]
    best = models[int(np.argmin(tried))]
    seconds = time.process_time() - begun
    errors = []
    for test in of.tests:
        force, position, _ = of.arrays(data, test)
        errors.append(scored(_left(best, position, force, sizes), of.per_unit))
    return Result(of.name, NAME, "", tuple(errors), seconds)


def _learnt(position: FloatArray, force: FloatArray, lags: int, threshold: float) -> DiscreteSINDy:
    states, inputs = sliding_window_view(position, lags), sliding_window_view(force, lags + 1)
    inputs = np.append(inputs, inputs[-1:], axis=0)  # of the last state no next one is known
    model = DiscreteSINDy(STLSQ(threshold=threshold, alpha=1e-9), PolynomialLibrary(DEGREE))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model.fit(states, 1.0, u=inputs)
    return model


def _left(
    model: DiscreteSINDy, position: FloatArray, force: FloatArray, sizes: tuple[float, float]
) -> FloatArray:
    """Return the residual of a free simulation that is started by the first samples."""
    weights = model.coefficients()[-1]
    powers = model.feature_library.powers_
    found = position / sizes[0]
    lags = model.coefficients().shape[0]
    inputs = force / sizes[1]
    for n in range(STARTING, found.size):
        now = np.concatenate([found[n - lags : n], inputs[n - lags : n + 1]])
        found[n] = weights @ np.prod(now**powers, axis=1)
        if not abs(found[n]) < 1e3:
            return np.full(found.size, np.inf)
    return position - sizes[0] * found
