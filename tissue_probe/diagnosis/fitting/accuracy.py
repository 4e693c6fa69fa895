"""By how much a finer simulation would change a fit's values, and how fine it has to be.

What belongs here: the errors of integration and of the input's course, as errors of the values.
What does not: the steps and the courses themselves (``physics.response``).

An error d of the simulated output moves the values by (J^T J)^-1 J^T d, with the sensitivities J
over the noise: the step of Gauss and Newton to where the finer simulation fits. The error itself is
no measure: a tenth of the noise along one sensitivity moves a value by many of its deviations, as
there are thousands of samples, and no residual shows it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tissue_probe.diagnosis.fitting.covariance import covariance, free
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.point import Point, point_at, scale_of
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.physics.response import Between
from tissue_probe.signals import FloatArray

#: Standard deviations by which numbers may be wrong for the simulation: an interval that holds the
#: truth in 95 % of all records holds it in 94 % then.
UNSEEN = 0.3
#: Most parts more; where more are needed the model is not to be simulated at these values.
MOST = 32
#: Degrees of the course through smooth samples, each of which tells the error of the one before.
DEGREES = (3, 7, 9)


@dataclass(frozen=True)
class Doubt:
    """By how much values are wrong for the simulation, in their standard deviations, shape (q,).

    ``by_step`` for the steps of the integration, ``by_course`` for the input's course.
    """

    by_step: FloatArray
    by_course: FloatArray

    @property
    def step(self) -> float:
        """The largest of those for the steps."""
        return float(np.max(np.abs(self.by_step), initial=0.0))

    @property
    def course(self) -> float:
        """The largest of those for the course."""
        return float(np.max(np.abs(self.by_course), initial=0.0))


def doubt(fit: Fit, instrument: Instrument) -> Doubt:
    """Return by how much a finer simulation would change the values of a fit."""
    problem = Problem(fit.composition, fit.measurements, instrument)
    point = point_at(problem, fit.values, fit.starts)
    if point is None:
        nothing = np.zeros(len(fit.values))
        return Doubt(nothing, nothing)
    in_steps = problem.states and not problem.kernel.linear
    step = _shift(fit, problem, point, in_more_parts) if in_steps else np.zeros(len(fit.values))
    return Doubt(step, _shift(fit, problem, point, smoother))


def widened(fit: Fit, instrument: Instrument) -> Fit:
    """Return a fit whose covariance has the errors that no finer simulation takes away."""
    told = doubt(fit, instrument)
    # Of a course that is not smooth another one tells nothing.
    smooth = any(each.fineness.degree > DEGREES[0] for each in fit.measurements)
    if max(told.step, told.course if smooth else 0.0) <= UNSEEN:
        return fit
    aside = (told.by_step + (told.by_course if smooth else 0.0)) * np.sqrt(
        np.maximum(np.diag(fit.covariance), 0.0)
    )
    return replace(fit, covariance=fit.covariance + np.outer(aside, aside))


def _shift(
    fit: Fit,
    problem: Problem,
    point: Point,
    finer: Callable[[Measurement], Measurement | None],
) -> FloatArray:
    """Return by how much values move, in standard deviations, where measurements are finer."""
    q, n = problem.count, problem.states
    gradient, scale = np.zeros(len(point.gradient)), np.ones(len(point.gradient))
    scale[:q] = scale_of(problem, point.values)
    for index, measurement in enumerate(problem.measurements):
        other = finer(measurement)
        if other is None:
            continue
        found = _output(problem, index, other, point) - _output(problem, index, measurement, point)
        if not np.isfinite(found).all():
            continue
        J = problem.weighed(index, point.simulated[index][1])
        place = np.concatenate([q + index * n + np.arange(n), np.arange(q)])
        gradient[place] += (J.T @ problem.weighed(index, found)) * scale[place]
    told, inverse = free(problem, point), covariance(problem, point)
    moved = np.zeros(len(gradient))
    moved[told] = (inverse @ gradient[told]) * scale[told]
    deviations = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    return np.divide(moved[:q], deviations, out=np.zeros(q), where=deviations > 0.0)


def _output(problem: Problem, index: int, measurement: Measurement, point: Point) -> FloatArray:
    """Return the output of a model at a point, where one measurement is simulated otherwise."""
    others = [*problem.measurements]
    others[index] = measurement
    own = Problem(problem.composition, others, problem.instrument)
    return own.response(index, measurement.input_values, point.values, point.starts[index]).output


def in_more_parts(measurement: Measurement, times: int = 2) -> Measurement:
    """Return a measurement that is simulated in so many times more parts."""
    now = measurement.fineness
    return replace(measurement, fineness=replace(now, parts=min(times * now.parts, 2 * MOST)))


def smoother(measurement: Measurement) -> Measurement | None:
    """Return a measurement whose input is taken to be smoother; None where it is not to be."""
    degree = _next(measurement)
    if degree == measurement.fineness.degree:
        return None
    return replace(measurement, fineness=replace(measurement.fineness, degree=degree))


def _next(measurement: Measurement) -> int:
    """Return the degree of a course that is nearer the truth than the one that is taken.

    The same where the course has corners, or is the smoothest that the samples leave possible.
    """
    now = measurement.fineness.degree
    smooth = measurement.between in (None, Between.smooth) and measurement.motion is None
    higher = [each for each in DEGREES if each > now and measurement.force.size >= 2 * each]
    return higher[0] if smooth and higher else now
