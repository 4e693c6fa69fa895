"""By how much a finer simulation would change a fit's values, and how fine it has to be.

Contents: the errors of integration and of the input's course, as errors of the values.

An error d of the simulated output moves the values by (J^T J)^-1 J^T d, with the sensitivities J
over the noise: the step of Gauss and Newton to where the finer simulation fits. The error itself is
no measure: a tenth of the noise along one sensitivity moves a value by many of its deviations, as
there are thousands of samples, and no residual shows it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tissue_probe.diagnosis.fitting.covariance import covariance, free
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.point import SearchPoint, point_at, scale_of
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.response import Between
from tissue_probe.signals import FloatArray

#: Standard deviations by which numbers may be wrong for the simulation: an interval that holds the
#: truth in 95 % of all records holds it in 94 % then.
UNSEEN = 0.3
#: Most parts more: they divide the error by a million. Where that is not enough, the model cannot
#: be simulated at these values.
MOST_FINER_PARTS = 32
#: Degrees of the course through smooth samples, each of which tells the error of the one before.
DEGREES = (3, 7, 9)


@dataclass(frozen=True)
class SimulationDoubt:
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


def doubt(fit: Fit, instrument: Instrument) -> SimulationDoubt:
    """Return by how much a finer simulation would change the values of a fit."""
    problem = Problem(fit.composition, fit.measurements, instrument)
    point = point_at(problem, fit.values, fit.starts)
    if point is None:
        nothing = np.zeros(len(fit.values))
        return SimulationDoubt(nothing, nothing)
    known = covariance(problem, point)
    step = course = np.zeros(len(fit.values))
    if problem.states and not problem.kernel.linear:
        step = _shift(fit, problem, point, known, [*map(in_more_parts, problem.measurements)])
    along = [smoother(each) or each for each in problem.measurements]
    if any(new is not old for new, old in zip(along, problem.measurements, strict=True)):
        course = _shift(fit, problem, point, known, along)
    return SimulationDoubt(step, course)


def widen_covariance(fit: Fit, instrument: Instrument) -> Fit:
    """Return a fit whose covariance has the errors that no finer simulation takes away."""
    told = doubt(fit, instrument)
    # Of a course that is not smooth another one tells nothing.
    if all(each.fineness.degree == DEGREES[0] for each in fit.measurements):
        told = replace(told, by_course=np.zeros(len(fit.values)))
    if max(told.step, told.course) <= UNSEEN:
        return fit
    deviations = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    aside = (told.by_step + told.by_course) * deviations
    return replace(fit, covariance=fit.covariance + np.outer(aside, aside))


def _shift(
    fit: Fit,
    problem: Problem,
    point: SearchPoint,
    known: FloatArray,
    finer: Sequence[Measurement],
) -> FloatArray:
    """Return by how much values move, in standard deviations, where measurements are finer.

    ``known`` is the covariance of the unknowns at the point, by the samples' noise alone.
    """
    q, n = problem.count, problem.states
    finely = Problem(problem.composition, finer, problem.instrument)
    gradient, scale = np.zeros(len(point.gradient)), np.ones(len(point.gradient))
    scale[:q] = scale_of(problem, point.values)
    for index, measurement in enumerate(finer):
        residual, sensitivity = point.simulated[index]
        driven, start = measurement.input_values, point.starts[index]
        output = finely.response(index, driven, point.values, start).output
        moved = output - (measurement.output_values - residual)
        if not np.isfinite(moved).all():
            continue
        J = problem.weighed(index, sensitivity)
        place = np.concatenate([q + index * n + np.arange(n), np.arange(q)])
        gradient[place] += (J.T @ problem.weighed(index, moved)) * scale[place]
    told, shift = free(problem, point), np.zeros(len(gradient))
    shift[told] = (known @ gradient[told]) * scale[told]
    deviations = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    return np.divide(shift[:q], deviations, out=np.zeros(q), where=deviations > 0.0)


def in_more_parts(measurement: Measurement, times: int = 2) -> Measurement:
    """Return a measurement that is simulated in so many times more parts.

    Up to one halving beyond ``MOST_FINER_PARTS``, which tells the error that is left there.
    """
    now = measurement.fineness
    return replace(
        measurement, fineness=replace(now, parts=min(times * now.parts, 2 * MOST_FINER_PARTS))
    )


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
