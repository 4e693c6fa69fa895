"""Where a search stands: cost and normal equations, with exact sensitivities.

Contents: evaluating a problem at values and starts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tissue_probe.diagnosis.fitting.effort import count
from tissue_probe.diagnosis.fitting.problem import Problem, StartPrior
from tissue_probe.signals import FloatArray


@dataclass
class SearchPoint:
    """Where a search stands: unknowns, cost, and the normal equations there."""

    values: FloatArray
    starts: list[FloatArray]
    begins: list[StartPrior]
    cost: float
    misfits: list[float]
    gradient: FloatArray
    normal: FloatArray
    simulated: list[tuple[FloatArray, FloatArray]]


def scale_of(problem: Problem, values: FloatArray) -> FloatArray:
    """Return d value / d unknown: the value itself where its logarithm is searched."""
    return np.where(problem.logarithmic, values, 1.0)


def point_at(
    problem: Problem, values: FloatArray, starts: Sequence[FloatArray], most: float = np.inf
) -> SearchPoint | None:
    """Evaluate cost and normal equations; None where the cost exceeds the most, or is infinite."""
    simulated, begins = problem.simulate(values, starts), problem.begin(values)
    count(sensitivity for _, sensitivity in simulated)
    if not all(np.isfinite(residual).all() for residual, _ in simulated):
        return None
    weighed = [problem.weighed(index, residual) for index, (residual, _) in enumerate(simulated)]
    misfits = [float(r @ r) for r in weighed]
    drawn, deviation = problem.drawn, problem.deviation[problem.drawn]
    departure = (problem.nominal - values)[drawn] / deviation
    off = [begun.mean - start for begun, start in zip(begins, starts, strict=True)]
    back = [begun.precision @ each for begun, each in zip(begins, off, strict=True)]
    strain = float(departure @ departure) + sum(
        float(a @ b) for a, b in zip(off, back, strict=True)
    )
    cost = sum(misfits) + strain
    if cost > most:
        return None
    q, n = problem.count, problem.states
    size = q + n * len(simulated)
    normal, gradient = np.zeros((size, size)), np.zeros(size)
    scale = np.ones(size)
    scale[:q] = scale_of(problem, values)
    for index, (_, sensitivity) in enumerate(simulated):
        J = problem.weighed(index, sensitivity)
        own = q + index * n + np.arange(n)
        place = np.concatenate([own, np.arange(q)])
        scaled = scale[place]
        normal[place[:, None], place] += (J.T @ J) * (scaled[:, None] * scaled)
        gradient[place] += (J.T @ weighed[index]) * scaled
        normal[own[:, None], own] += begins[index].precision
        gradient[own] += back[index]
    normal[drawn, drawn] += deviation**-2
    gradient[drawn] += departure / deviation
    if not np.isfinite(normal).all():
        return None
    return SearchPoint(values, list(starts), begins, cost, misfits, gradient, normal, simulated)
