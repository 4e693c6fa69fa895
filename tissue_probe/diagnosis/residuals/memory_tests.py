"""Whether a residual remembers its past: that of a right model is white.

Contents: tests of the residual's own autocorrelation.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.diagnosis.chance import chi_squared_beyond, normal_beyond
from tissue_probe.diagnosis.residuals.residual_test import ResidualTest, judge_test
from tissue_probe.diagnosis.transforms import correlation
from tissue_probe.signals import FloatArray

LAGS = 40  # samples; 20 ms at 2 kHz, in which the tip's resonance rings more than once
_HINT = (
    "the model misses something that lasts longer than a sample: it moves with the tissue or "
    "the tip, not the electronics' noise; the tests of drive and lines say which"
)


def autocorrelations(residual: FloatArray, lags: int = LAGS) -> FloatArray:
    """Return the residual's autocorrelation at 1 ... ``lags`` samples, each within -1 ... 1."""
    products = correlation(residual, residual)[residual.size - 1 :]
    return products[1 : lags + 1] / (products[0] or 1.0)


def whiteness(residual: FloatArray) -> ResidualTest:
    """Test the largest autocorrelation (each ~ normal(0, 1 / N) under white noise).

    L. Ljung, System Identification, 2nd ed. (1999), section 16.6; Bonferroni over the lags.
    """
    found = autocorrelations(residual)
    largest = int(np.argmax(np.abs(found)))
    score = abs(found[largest]) * np.sqrt(residual.size)
    return judge_test(
        "whiteness",
        found[largest],
        min(1.0, 2.0 * found.size * normal_beyond(score)),
        f"autocorrelation reaches {found[largest]:+.2g} at {largest + 1} samples",
        _HINT,
    )


def ljung_box(residual: FloatArray) -> ResidualTest:
    """Test all autocorrelations together: Q = N (N + 2) sum of rho_l^2 / (N - l) ~ chi^2(lags).

    G. Ljung, G. Box, "On a measure of lack of fit in time series models", Biometrika 65 (1978),
    297. No degree is taken off for the model's parameters: they are few beside the lags.
    """
    found, size = autocorrelations(residual), residual.size
    lags = np.arange(1, found.size + 1)
    statistic = size * (size + 2) * np.sum(found**2 / (size - lags))
    return judge_test(
        "Ljung-Box",
        statistic,
        chi_squared_beyond(statistic, found.size),
        f"Q is {statistic:.3g} over {found.size} lags; white noise has {found.size}",
        _HINT,
    )
