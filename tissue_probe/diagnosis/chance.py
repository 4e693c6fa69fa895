"""Chances: how often a quantity of a known distribution lies beyond a value.

Contents: tails of distributions, by SciPy's special functions.

``scipy.stats`` has the same numbers, but takes longer to import than a recording to be fitted.
"""

from __future__ import annotations

import numpy as np
from scipy import special

from tissue_probe.signals import FloatArray

#: Median of the size of a standard normal variable: a median of sizes is divided by it.
MEDIAN_SIZE = float(special.ndtri(0.75))


def normal_beyond(value: float) -> float:
    """Return the chance that a standard normal variable lies above a value."""
    return float(special.ndtr(-value))


def normal_at(chance: float) -> float:
    """Return the value above which a standard normal variable lies by this chance."""
    return float(-special.ndtri(chance))


def chi_squared_beyond(value: float, freedom: float) -> float:
    """Return the chance that chi^2 of so many degrees of freedom lies above a value."""
    return float(special.chdtrc(freedom, value))


def chi_squared_median(freedom: float) -> float:
    """Return the median of chi^2 of so many degrees of freedom."""
    return float(2.0 * special.gammaincinv(0.5 * freedom, 0.5))


def f_beyond(values: FloatArray, above: float, below: float) -> FloatArray:
    """Return the chance that F, of degrees of freedom above and below, lies above each value."""
    chances: FloatArray = special.fdtrc(above, below, values)
    return chances


def binomial_from(count: int, trials: int, chance: float) -> float:
    """Return the chance of ``count`` or more successes among ``trials``, each by ``chance``."""
    if not 0 < count <= trials:
        return float(count <= 0)
    return float(special.bdtrc(count - 1, trials, chance))


def mean_is_zero(values: FloatArray) -> float:
    """Return the p-value of Student's t test, of either side, that the mean of values is zero.

    ``values``, shape (n,), are independent and normal; n is 2 at least.
    """
    spread = float(np.std(values, ddof=1))
    mean = abs(float(np.mean(values)))
    t = mean / spread * np.sqrt(values.size) if spread > 0.0 else (np.inf if mean > 0.0 else 0.0)
    return float(2.0 * special.stdtr(values.size - 1, -t))
