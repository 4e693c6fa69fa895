"""The fit at the end of a search, with its covariance, its residual and its held-out error.

Contents: the numbers computed once, from the normal equations at the end.
"""

from __future__ import annotations

import numpy as np
from scipy.fft import idct
from scipy.linalg import eigh

from tissue_probe.diagnosis.fitting.covariance import covariance, free
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.point import SearchPoint, scale_of
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.residuals.whiteness import colour, unevenness
from tissue_probe.physics.rounding import COARSE_STEP, smooth_rounding
from tissue_probe.signals import BoolArray, FloatArray

#: Parts of a record that are left out of the fit in turn.
HELD_OUT_PARTS = 8
#: Share of the information on a value that the other blocks are credited with at least. A value
#: that one block alone tells so stays within ten of its deviations when that block is left out.
REASON = 1e-2


def finish_fit(problem: Problem, point: SearchPoint, converged: bool) -> Fit:
    """Return the fit at a point: covariance, residual, and its statements on noise and rig."""
    q = problem.count
    told, inverse = free(problem, point), covariance(problem, point)
    found, own = np.zeros((q, q)), told < q
    scale = scale_of(problem, point.values)[told[own]]
    found[np.ix_(told[own], told[own])] = inverse[np.ix_(own, own)] * np.outer(scale, scale)
    samples = sum(int(np.sum(measurement.used)) for measurement in problem.measurements)
    excess = max(1.0, point.cost / samples)
    cosines = [problem.cosines(index, each) for index, (each, _) in enumerate(point.simulated)]
    left, alone = _left_out(problem, point)
    # The noise counted for a noisy position is too large where the motion is smoother than its jerk
    # lets expect: a residual without fast noise does not count against a model.
    least = 1.0 if any(each.noise.is_upper_limit for each in problem.measurements) else 0.0
    return Fit(
        composition=problem.composition,
        measurements=problem.measurements,
        entries=problem.runs.entries,
        values=point.values,
        starts=tuple(point.starts),
        covariance=found * excess,
        residuals=tuple(residual for residual, _ in point.simulated),
        evened=tuple(
            m.noise.own * idct(each, norm="ortho")
            for m, each in zip(problem.measurements, cosines, strict=True)
        ),
        heldout=tuple(left),
        misfits=tuple(point.misfits),
        cost=point.cost,
        unknowns=problem.unknowns,
        start_penalty=_start_penalty(problem, point),
        converged=converged,
        rounding=_estimate_rounding(problem, point),
        colour=colour(cosines, least),
        unevenness=unevenness(cosines, least),
        strain=point.cost - sum(point.misfits),
        exhausted=_name_exhausted(problem, point.values),
        alone=alone,
    )


def _name_exhausted(problem: Problem, values: FloatArray) -> tuple[str, ...]:
    """Name the values that a fit has moved as far as the search of them goes."""
    ended = _at_end(problem, values) & problem.free
    return tuple(problem.runs.names[index] for index in np.flatnonzero(ended))


def _at_end(problem: Problem, values: FloatArray) -> BoolArray:
    rounding = 1e-9 * np.maximum(np.abs(values), np.abs(problem.nominal))
    found: BoolArray = (values <= problem.lower + rounding) | (values >= problem.upper - rounding)
    return found


def _estimate_rounding(problem: Problem, point: SearchPoint) -> float:
    """Simulate an error that rounding of the position may have left; rms of the force [N].

    It counts where a model smooths coarse steps, and where it undoes an error of a fine encoder:
    that makes the rounding larger wherever two positions read nearly alike. Coarse steps that a
    model does not smooth are no noise to be counted, but something that it lacks.
    """
    kernel, values = problem.kernel, point.values.copy()
    smooths = kernel.rounded >= 0 and values[kernel.rounded] > 0
    coarse = COARSE_STEP * problem.composition.scale.length
    fine = all(measurement.extent.step <= coarse for measurement in problem.measurements)
    if not smooths and not (kernel.moves_position and fine):
        return 0.0
    step = values[kernel.rounded] if smooths else 0.0
    if smooths:
        values[kernel.rounded] = 0.0  # the motion below is smoothed already
    changes = []
    for index, (m, start) in enumerate(zip(problem.measurements, point.starts, strict=True)):
        right, wrong = (problem.response(index, u, values, start).output for u in _as_read(m, step))
        changes.append((wrong - right)[m.used])
    return float(np.sqrt(np.mean(np.concatenate(changes) ** 2)))


def _as_read(measurement: Measurement, step: float) -> tuple[FloatArray, FloatArray]:
    """Return the position that is taken for the true one, and one as likely; smooth for a step."""
    if step > 0.0:
        found = smooth_rounding(measurement.position, step)
        return found.course, found.course + found.error
    if measurement.misread is not None:
        return measurement.position, measurement.position + measurement.misread
    error = np.random.default_rng(0).uniform(-0.5, 0.5, measurement.position.size)
    return measurement.position, measurement.position + measurement.extent.step * error


def _start_penalty(problem: Problem, point: SearchPoint) -> float:
    """Log of how many times the samples narrow the priors of the starts.

    Summed over the states that the samples separate, and of each no more than a parameter costs:
    the BIC takes a parameter for known beforehand as well as one sample tells it.
    """
    q, n = problem.count, problem.states
    own = [
        i
        for i, spread in enumerate(problem.kernel.spreads)
        if spread in ("length", "branch") or spread in problem.kernel.values
    ]
    penalty = 0.0
    for index, begun in enumerate(point.begins if own else []):
        place = np.array([q + index * n + i for i in own])
        scale = np.outer(begun.deviation[own], begun.deviation[own])
        after = point.normal[np.ix_(place, place)] * scale
        narrower = eigh(after, begun.precision[np.ix_(own, own)] * scale, eigvals_only=True)
        costs = np.log(np.maximum(narrower, 1.0))
        samples = np.sum(problem.measurements[index].used)
        penalty += float(np.sum(np.minimum(costs, np.log(samples))))
    return penalty


def _left_out(problem: Problem, point: SearchPoint) -> tuple[list[FloatArray], tuple[str, ...]]:
    """Return each block's residual with the values fitted to the others only; and values.

    With J the sensitivities of block B and A the normal matrix, leaving B out changes its residual
    to r + J (A - J^T J)^-1 J^T r, exactly so for a model linear in its values; J^T J and J^T r over
    the noise, of which flicker noise is left aside. The values named are those that one block
    tells, and all the others hardly. A value at a bound stays there: an effect whose strength is
    fitted as zero leaves the same residual as the model without it.
    """
    q, n = problem.count, problem.states
    told = problem.free & (np.diag(point.normal)[:q] > 0) & ~_at_end(problem, point.values)
    own = np.flatnonzero(told)
    scale = scale_of(problem, point.values)[own]
    by_value = [sensitivity[:, n:][:, own] * scale for _, sensitivity in point.simulated]
    pairs = zip(problem.measurements, by_value, strict=True)
    over_noise = [measurement.over_noise(each) for measurement, each in pairs]
    whole = np.diag((scale / problem.deviation[own]) ** 2) + sum(J.T @ J for J in over_noise)
    root = np.sqrt(np.diag(whole))
    left, alone = [], np.zeros(own.size, dtype=bool)
    for index, J in enumerate(over_noise):
        residual = point.simulated[index][0]
        r = problem.measurements[index].over_noise(residual)
        out = residual.copy()
        for block in np.array_split(np.arange(residual.size), HELD_OUT_PARTS):
            rest = (whole - J[block].T @ J[block]) / np.outer(root, root)
            alone |= np.diag(rest) < REASON
            # A value that only this block determines would be unknown without it; it stays within
            # reason.
            rest[np.diag_indices(own.size)] += REASON
            out[block] += by_value[index][block] @ (
                np.linalg.solve(rest, J[block].T @ r[block] / root) / root
            )
        left.append(out)
    return left, tuple(problem.runs.names[index] for index in own[alone])
