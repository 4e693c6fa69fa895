"""The smooth course of a position that was measured in coarse steps.

Contents: smoothing a position that an encoder has rounded, and the remaining uncertainty.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded
from scipy.ndimage import uniform_filter1d

from tissue_probe.call_cache import for_a_call

FloatArray = NDArray[np.float64]

#: Finer steps are an encoder's own, and smaller than the force can tell [m].
COARSE_STEP = 3e-7
#: Order of the difference that is kept small; the response falls with its double.
DIFFERENCE_ORDER = 4
#: Samples over which the roughness of a motion counts as one.
ROUGHNESS_WINDOW = 200
#: Weights of roughness that are tried, by halving; beyond, the equations lose their digits.
LIGHTEST, HEAVIEST, WEIGHT_HALVINGS = 1e-9, 1e9, 12
SMOOTHING_ROUNDS = 4
#: No sample was rounded by more than half a step: those that seem to have been are trusted more by
#: this factor, again and again.
PULL, PULLS = 2.0, 16
#: Share of its due that is taken off a coarse rounding: the remaining roughness is known
#: (``SmoothedCourse.error``), and the part of the motion that is smoothed away is not.
CAUTION = 0.97
#: Samples at either end over which a fine rounding is smoothed less: there a spline strays most.
EDGE = 100


@dataclass(frozen=True)
class SmoothedCourse:
    """The course [m], and one of the errors that it may have [m]; both of shape (n,)."""

    course: FloatArray
    error: FloatArray


def smooth_rounding(position: FloatArray, step: float, fine: bool = False) -> SmoothedCourse:
    """Return the smoothest course within the errors of rounding.

    Rounding to ``step`` q is taken as white noise of variance q^2/12 (Widrow and Kollar 2008),
    the fourth difference of the true course as white too, with a variance that varies along the
    record: Whittaker's graduation (1923) with a weight for each sample. The weights follow the
    roughness found in the last round; their common factor is such that the removed part has the
    variance that rounding has (Morozov's principle of discrepancy, 1966). At last the course is
    drawn to where it came from wherever it has left that by more than half a step.

    Parameters
    ----------
    position : array, shape (n,)
        Rounded displacement [m].
    step : float
        The step of the rounding [m], positive.
    fine : bool
        Whether the step is an encoder's own, finer than ``COARSE_STEP``: then all of its due is
        taken off, but for the ends, where the course stays with the reading.
    """
    data = np.ascontiguousarray(position, dtype=np.float64).tobytes()
    return _smoothed(data, float(step), fine)


@for_a_call(8)
def _smoothed(position: bytes, step: float, fine: bool) -> SmoothedCourse:
    rounded = np.frombuffer(position) / step * np.sqrt(12.0)
    if rounded.size <= 2 * DIFFERENCE_ORDER:
        return SmoothedCourse(np.frombuffer(position), np.zeros(rounded.size))
    random = np.random.default_rng(0)
    probe = random.standard_normal(rounded.size)
    count = rounded.size - DIFFERENCE_ORDER
    shape = edges = _edges(count) if fine else np.ones(count)
    share = 1.0 if fine else CAUTION
    for _ in range(SMOOTHING_ROUNDS):
        weight = _balanced(rounded, probe, shape, share)
        course = _solve(weight, rounded)
        roughness = uniform_filter1d(
            np.diff(course, DIFFERENCE_ORDER) ** 2, ROUGHNESS_WINDOW, mode="nearest"
        )
        shape = edges * roughness.mean() / (roughness + 1e-4 * roughness.mean() + 1e-300)
    trust = np.ones(rounded.size)
    if not fine:
        course, trust = _within_steps(weight, rounded, course)
    # Perturbing both kinds of noise and solving again draws from the remaining uncertainty.
    rough = np.sqrt(weight) * random.standard_normal(weight.size)
    error = _solve(weight, np.sqrt(trust) * probe + _difference_transposed(rough), trust)
    unit = step / np.sqrt(12.0)
    return SmoothedCourse(course * unit, error * unit)


def _within_steps(
    weight: FloatArray, rounded: FloatArray, free: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Draw a course towards rounded samples that it has left by more than half a step.

    Where the variance of all errors is met, few of them may still be too large: at the ends, or
    where the motion turns. Where that costs more variance than rounding has, the record is one of
    jumps, and the course stays as it is.

    Returns
    -------
    course, trust : array, shape (n,)
        The course, and how much more each sample is trusted.
    """
    course, trust = free, np.ones(rounded.size)
    for _ in range(PULLS):
        beyond = np.abs(course - rounded) > np.sqrt(3.0)
        if not beyond.any():
            break
        trust[beyond] *= PULL
        course = _solve(weight, trust * rounded, trust)
    if np.mean((course - rounded) ** 2) > 1.0:
        return free, np.ones(rounded.size)
    return course, trust


def _edges(count: int) -> FloatArray:
    """Let the bandwidth of the smoother, the eighth root of its weight, open towards the ends."""
    place = np.arange(count) + 0.5
    near = np.minimum(place, place[::-1]) / EDGE
    found: FloatArray = np.minimum(near, 1.0) ** (2 * DIFFERENCE_ORDER)
    return found


def _balanced(
    rounded: FloatArray, probe: FloatArray, shape: FloatArray, share: float
) -> FloatArray:
    """Find the weights at which the removed part is as large as white noise of variance 1.

    Of n such errors a smoother S leaves n - trace(S); the trace is estimated by a random probe
    (Hutchinson 1989).
    """
    low, high = np.log(LIGHTEST), np.log(HEAVIEST)
    for _ in range(WEIGHT_HALVINGS):
        middle = 0.5 * (low + high)
        weight = np.minimum(np.exp(middle) * shape, HEAVIEST)
        course, followed = _solve(weight, np.stack([rounded, probe], axis=1)).T
        due = share * (rounded.size - probe @ followed)
        too_smooth = np.sum((course - rounded) ** 2) > due
        low, high = (low, middle) if too_smooth else (middle, high)
    found: FloatArray = np.minimum(np.exp(low) * shape, HEAVIEST)
    return found


def _solve(weight: FloatArray, right: FloatArray, trust: FloatArray | float = 1.0) -> FloatArray:
    """Solve (T + D' W D) s = right, D the fourth difference, W the weights, T those of samples."""
    count = right.shape[0]
    stencil = np.diff(np.eye(DIFFERENCE_ORDER + 1), DIFFERENCE_ORDER, axis=0)[0]
    bands = np.zeros((DIFFERENCE_ORDER + 1, count))
    bands[0] = trust
    for row in range(DIFFERENCE_ORDER + 1):
        for column in range(row, DIFFERENCE_ORDER + 1):
            bands[column - row, row : row + weight.size] += weight * stencil[row] * stencil[column]
    return np.asarray(solveh_banded(bands, right, lower=True, check_finite=False))


def _difference_transposed(values: FloatArray) -> FloatArray:
    """Return D' values: the transpose of ``np.diff`` to the fourth order."""
    for _ in range(DIFFERENCE_ORDER):
        values = -np.diff(values, prepend=0.0, append=0.0)
    return values
