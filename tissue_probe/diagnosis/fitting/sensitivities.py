"""The sensitivity of the force to each unknown of a model, over the noise: columns of one matrix.

Contents: the columns of several measurements under one another, and the precision that tolerances
give.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.signals import FloatArray


def by_unknown(problem: Problem, values: FloatArray, starts: Sequence[FloatArray]) -> FloatArray:
    """Return columns of all values, then of the starts of each measurement: (N, q + n m)."""
    n = problem.states
    simulated = [sensitivity for _, sensitivity in problem.simulate(values, starts)]
    columns = [stack_parts(problem, [each[:, n:] for each in simulated])]
    for index in range(len(simulated)):
        parts = [each[:, :n] * (i == index) for i, each in enumerate(simulated)]
        columns.append(stack_parts(problem, parts))
    return np.concatenate(columns, axis=1)


def unknown(problem: Problem) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which of these columns belong to a free unknown, and not to a constant that is held."""
    starts = np.ones(problem.states * len(problem.measurements), dtype=bool)
    return np.concatenate([problem.free, starts])


def precision(problem: Problem, values: FloatArray) -> FloatArray:
    """Return the prior precision of each unknown: one over the square of its deviation."""
    known = np.where(problem.free, problem.deviation, np.inf) ** -2.0
    spreads = [begun.deviation**-2.0 for begun in problem.begin(values)]
    return np.concatenate([known, *spreads])


def stack_parts(problem: Problem, parts: Sequence[FloatArray]) -> FloatArray:
    """Join arrays of all measurements, each over its noise, unused samples zero."""
    return np.concatenate([problem.weighed(index, part) for index, part in enumerate(parts)])
