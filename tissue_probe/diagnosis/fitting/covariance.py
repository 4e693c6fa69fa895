"""How well a fit knows its unknowns: also where a part of the sensitivities is noise.

Contents: from the normal equations to a covariance.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.diagnosis.fitting.point import SearchPoint, scale_of
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.signals import FloatArray

#: Largest share of noise in the information of the samples on a direction: an interval is then some
#: thirty times as wide as without noise, and tells that nothing is known.
MOSTLY = 0.95
#: The information of the samples on a direction, over that on the best one: less is rounding.
LEAST_INFORMATION = 1e-12


def covariance(problem: Problem, point: SearchPoint) -> FloatArray:
    """Return the covariance of values and starts as they are searched, of those that are free.

    In the order of ``free``; residuals over the noise count as of variance 1. How far noise in
    the positions draws them aside counts as an error, too.
    """
    chosen = free(problem, point)
    if not chosen.size:  # all is held, as where a model without states is carried over
        return np.zeros((0, 0))
    place = np.ix_(chosen, chosen)
    root = np.sqrt(np.diag(point.normal)[chosen])
    scale = np.outer(root, root)
    found = _by_noise(problem, point)
    if found is None:
        sizes, directions = _decompose_information(point.normal[place] / scale)
        inverse = (directions / sizes) @ directions.T
    else:
        noise, pull = found
        inverse = _without(point.normal[place] / scale, noise[place] / scale)
        aside = inverse @ (pull[chosen] / root)
        inverse = inverse + np.outer(aside, aside)
    return inverse / scale


def free(problem: Problem, point: SearchPoint) -> np.ndarray:
    """Return which values, and after them starts, the samples or tolerances tell at all."""
    q = problem.count
    told = np.flatnonzero(np.diag(point.normal) > 0)
    return told[(told >= q) | problem.free[np.minimum(told, q - 1)]]


def _decompose_information(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how much the samples tell in each direction, and the directions.

    Where they tell nothing that is not the arithmetic's, nothing is known: the variance there is as
    large as can be told beside the others. Two values of which one makes up for the other have such
    a direction.
    """
    sizes, directions = np.linalg.eigh(normal)
    return np.maximum(sizes, LEAST_INFORMATION * sizes[-1]), directions


def _without(normal: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the inverse of a normal matrix in which noise has a share.

    Let s be the share in a direction: the samples tell 1 - s of the matrix, towards which a value
    is too small by as much, and the gradient varies by 1 + s (W. Fuller, Measurement Error Models
    (1987), section 1.2).
    """
    sizes, directions = _decompose_information(normal)
    whiten = directions / np.sqrt(sizes)
    shares, turned = np.linalg.eigh(whiten.T @ noise @ whiten)
    shares = np.clip(shares, 0.0, MOSTLY)
    basis = whiten @ turned
    reduced: FloatArray = (basis * ((1.0 + shares) / (1.0 - shares) ** 2)) @ basis.T
    return reduced


def _by_noise(problem: Problem, point: SearchPoint) -> tuple[FloatArray, FloatArray] | None:
    """Return the parts of normal matrix and gradient that noise left in the positions makes.

    The output that noise makes and its derivatives go together: values are drawn to where the model
    answers less to the noise (W. Fuller, as above, section 1.1). None without such noise.
    """
    if all(measurement.motion is None for measurement in problem.measurements):
        return None
    random, n, q = np.random.default_rng(0), problem.states, problem.count
    normal, scale = np.zeros_like(point.normal), np.ones(len(point.normal))
    pull = np.zeros(len(point.normal))
    scale[:q] = scale_of(problem, point.values)
    for index, measurement in enumerate(problem.measurements):
        if measurement.motion is None:
            continue
        noisy = measurement.position + measurement.motion.noise_left(random)
        wrong = problem.response(index, noisy, point.values, point.starts[index])
        right = point.simulated[index][1]
        changed = problem.runs.spread(index, wrong.sensitivity) - right
        if not np.isfinite(changed).all():  # a tip that the noise makes fly away tells nothing
            changed = right
        J = problem.weighed(index, changed)
        moved = wrong.output - (measurement.output_values - point.simulated[index][0])
        shaken = problem.weighed(index, np.where(np.isfinite(moved), moved, 0.0))
        place = np.concatenate([q + index * n + np.arange(n), np.arange(q)])
        normal[place[:, None], place] += (J.T @ J) * np.outer(scale[place], scale[place])
        pull[place] += (J.T @ shaken) * scale[place]
    return normal, pull
