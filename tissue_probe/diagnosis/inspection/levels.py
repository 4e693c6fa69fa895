"""The steps in which a channel's values come: resolution of an encoder or a converter.

Contents: finding the step from the values.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.signals import FloatArray

_LEVEL_SHARE = 0.95  # of the differences between levels must be whole steps
_MANY = 20  # differences that do not all fit a wrong step by chance
_FUZZ = 8.0  # units in the last place that rounding leaves between equal levels


def step_size(values: FloatArray) -> float | None:
    """Return the step of which all values are multiples (from some zero), or None.

    The differences between neighbours among the distinct values are taken as whole multiples of
    the smallest; the step is their sum over the sum of the multiples. Where that does not fit,
    whole parts of the smallest are tried, as few levels need have no neighbours; then the smallest
    but one in twenty, as a limit may lie between the steps.

    Parameters
    ----------
    values : array, shape (n,)
        Finite values in any unit, which the step then has too.
    """
    largest = np.abs(values).max(initial=0.0)
    differences = np.diff(np.unique(values))
    differences = differences[differences > _FUZZ * np.spacing(largest)]
    if differences.size < 2:
        return float(differences[0]) if differences.size else None
    divisors = np.arange(1, 10 if differences.size > _MANY else 2)
    candidates = [*(differences.min() / divisors), np.quantile(differences, 0.05)]
    steps = (_refine_step(differences, step) for step in candidates)
    return next((step for step in steps if step > 0.0 and _fits(differences, step, largest)), None)


def decimal_grain(values: FloatArray) -> float:
    """Return the power of ten that a tenth of the values are multiples of, 0 where there is none.

    Values written with few digits, and then resampled in part, come in no step throughout; equal
    neighbours are common among them all the same.

    Parameters
    ----------
    values : array, shape (n,)
        Finite values in any unit, which the grain then has too.
    """
    values = values[values != 0.0]
    for digits in range(1, 10):
        scaled = values * 10.0**digits
        if values.size and np.mean(np.abs(scaled - np.rint(scaled)) < 1e-6) >= 0.1:
            return 10.0**-digits
    return 0.0


def _refine_step(differences: FloatArray, step: float) -> float:
    small = differences[differences < max(10.0 * step, 1.5 * differences.min())]
    return float(small.sum() / max(np.rint(small / step).sum(), 1.0))


def _fits(differences: FloatArray, step: float, largest: float) -> bool:
    multiples = differences / step
    tolerance = 0.01 + _FUZZ * np.spacing(largest) / step
    whole = np.abs(multiples - np.rint(multiples)) < tolerance
    return bool(tolerance < 0.05 and whole.mean() >= _LEVEL_SHARE)
