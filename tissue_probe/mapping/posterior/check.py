"""Whether the model of a map holds: that it would make data like these.

Contents: the posterior-predictive check.

Two properties of the sites' residuals, each told by all other sites and over its own error, are
held against those of data drawn from the states (Gelman, Meng and Stern, Posterior predictive
assessment of model fitness, Statistica Sinica 6 (1996) 733): the largest, and how far neighbours go
together. A model that needs nearly as many inclusions as it may have does not hold either, nor one
whose smooth background varies like inclusions do.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cholesky
from scipy.spatial import cKDTree

from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.felt_surface import sums_at
from tissue_probe.mapping.posterior.prior import MOST_INCLUSIONS
from tissue_probe.mapping.posterior.sampling import States
from tissue_probe.signals import FloatArray

#: Of maps of which the model is right, one in a hundred fails: either property in one of 200.
LEAST_PASSED = 0.005
#: Two standard deviations of the variation are then a contrast of 1.3.
LARGEST_VARIATION = 0.13
_CHECK_STATES = 100
#: Of data, from each of these states.
_DRAWS = 4


def predictive_probability(states: States, background: Background, log_k: FloatArray) -> float:
    """Return how probable residuals as odd as these are, the odder of the two properties; 0 to 1.

    0 where most states have more inclusions than three quarters of ``MOST``, or a background that
    varies by more than ``LARGEST_VARIATION``.
    """
    sizes = background.levels.sizes[states.level % background.levels.sizes.size]
    if np.median(states.count) > 0.75 * MOST_INCLUSIONS or np.median(sizes) > LARGEST_VARIATION:
        return 0.0
    rows, count, level, kinds = states.some(_CHECK_STATES)
    residuals = log_k - np.log(sums_at(rows, count, background.x, background.y))
    places = np.column_stack([background.x, background.y])
    neighbour = cKDTree(places).query(places, k=min(2, len(places)))[1].reshape(len(places), -1)
    beside = neighbour[:, -1]
    rng = np.random.default_rng(len(places))
    odd, known = [], {}
    for r, used, erring in zip(residuals, level, kinds, strict=True):
        state = int(used), erring.tobytes()
        if state not in known:
            precision = background.precision_of(int(used), erring)
            known[state] = precision, cholesky(precision, lower=True)
        precision, factor = known[state]
        scale = 1.0 / np.sqrt(np.diag(precision))
        drawn = (factor @ rng.standard_normal((len(places), _DRAWS))).T * scale
        ours = (precision @ r) * scale
        odd.append(_properties(drawn, beside) >= _properties(ours[None], beside))
    return float(np.concatenate(odd, axis=1).mean(axis=1).min())


def _properties(z: FloatArray, beside: np.ndarray) -> FloatArray:
    """Return the two properties of each row of standardised residuals, shape (2, rows)."""
    return np.array([np.abs(z).max(axis=1), np.abs((z * z[:, beside]).mean(axis=1))])
