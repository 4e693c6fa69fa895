"""Whether two ways to measure agree: limits between which 95 % of their differences lie.

J. M. Bland, D. G. Altman, Lancet 327 (1986) 307; the exact intervals of the limits are those of
A. Carkeet, Optometry and Vision Science 92 (2015) e71, by the non-central t distribution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import nct, norm, t

from tissue_probe.errors import ParameterError
from tissue_probe.signals import FloatArray
from tissue_probe.studies.spread import Interval

_NORMAL = float(norm.ppf(0.975))


@dataclass(frozen=True)
class Agreement:
    """Differences of two ways to measure the same, second less first.

    Attributes
    ----------
    pairs : int
        How many there are.
    bias : Interval
        Mean difference.
    lower, upper : Interval
        The limits of agreement.
    """

    pairs: int
    bias: Interval
    lower: Interval
    upper: Interval

    @property
    def text(self) -> str:
        """All of it in lines, 95 % intervals in brackets."""
        return (
            f"{self.pairs} pairs; 95 % intervals\nbias: {self.bias}\n"
            f"limits of agreement: {self.lower} to {self.upper}"
        )

    def __repr__(self) -> str:
        return self.text


def agreement_of(first: FloatArray, second: FloatArray) -> Agreement:
    """Return how two ways to measure agree.

    Parameters
    ----------
    first, second : array, shape (n,)
        Values of the same specimens, pair by pair.

    Raises
    ------
    ParameterError
        If there are fewer than three pairs.
    """
    apart = second - first
    n = apart.size
    if n < 3:
        raise ParameterError(f"{n} pairs tell no limits of agreement: give three or more")
    mean, sd = float(apart.mean()), float(apart.std(ddof=1))
    sure = float(t.ppf(0.975, n - 1)) * sd / np.sqrt(n)
    near, far = (
        float(nct.ppf(share, n - 1, _NORMAL * np.sqrt(n))) * sd / np.sqrt(n)
        for share in (0.025, 0.975)
    )
    limit = _NORMAL * sd
    return Agreement(
        n,
        Interval(mean, mean - sure, mean + sure),
        Interval(mean - limit, mean - far, mean - near),
        Interval(mean + limit, mean + near, mean + far),
    )
