"""The moves of a chain: an inclusion is born, dies, is drawn anew, or changes; the level changes.

Contents: what a move proposes, and when it is accepted.

The background is integrated out, so that a state is a list of inclusions, a level of variation, and
which sites are outliers. Its log density is the prior's and beta times what the data say: the
level's weight less r'Qr / 2, where r is log k less that of the inclusions and Q the level's
precision, outliers counted. beta is 1 for the posterior, and less for a chain that goes farther
(``chain``). With r changed at the few sites that a move reaches, r'Qr is changed by these alone.

P. J. Green, Reversible jump Markov chain Monte Carlo computation and Bayesian model determination,
Biometrika 82 (1995) 711.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from tissue_probe.mapping.posterior.outliers import ErrorKinds, with_outliers
from tissue_probe.mapping.posterior.prior import (
    ANGLE,
    FURTHER,
    LEAST_LEFT,
    LOG_ASPECT,
    LOG_CONTRAST,
    LOG_EXPONENT,
    LOG_RADIUS,
    MOST_INCLUSIONS,
    OVERLAP_POWER,
    PARAMETERS,
    X,
    Y,
    draw_contrast,
    draw_shape,
    log_normal,
    log_prior_of_contrast,
    log_prior_of_shape,
)
from tissue_probe.mapping.posterior.shape import measure_distance, write_shape
from tissue_probe.signals import FloatArray, IntArray

#: Share of births anywhere, against those where the sites are off; of contrasts from the prior,
#: against those that explain the nearest site.
_ANYWHERE, _ANY_CONTRAST = 0.3, 0.5
#: Kinds of change of an inclusion, and from which on the contrast follows the form.
KINDS, _RESHAPES = 6, 3


class SitesRegion(NamedTuple):
    """Where sites and inclusions may be [mm].

    ``sx``, ``sy`` are the sites, ``spacing`` their distance, ``box`` a rectangle around all (least
    and largest x, y). A middle lies in the ``hull``: a x + b y + c <= 0 for each of its rows
    a, b, c. ``area`` is the hull's.
    """

    sx: FloatArray
    sy: FloatArray
    spacing: float
    box: FloatArray
    hull: FloatArray
    area: float


class ChainState(NamedTuple):
    """Inclusions, shape (MOST, PARAMETERS), and what follows from them at the sites.

    ``shapes`` and ``excesses`` are g and e of each inclusion, ``sum_felt`` is 1 + sum e g, ``r``
    log k less its log, ``residual`` Qr. ``kinds`` says how each site errs, ``precision`` is Q with
    that, and ``log_det``, of one element, what that adds to half its log determinant.
    """

    inclusions: FloatArray
    shapes: FloatArray
    excesses: FloatArray
    sum_felt: FloatArray
    r: FloatArray
    residual: FloatArray
    kinds: ErrorKinds
    precision: FloatArray
    log_det: FloatArray


class Scratch(NamedTuple):
    """Arrays that moves write to: a new inclusion, its shape and sum; the state without one.

    ``precision`` is that of another level.
    """

    new: FloatArray
    shape: FloatArray
    nothing: FloatArray
    sum_felt: FloatArray
    change: FloatArray
    where: IntArray
    weights: FloatArray
    without_sum: FloatArray
    without_r: FloatArray
    without_residual: FloatArray
    precision: FloatArray


@njit(cache=True, nogil=True, error_model="numpy")
def _inside(px: float, py: float, hull: FloatArray) -> bool:
    """Whether a middle is in the hull: an inclusion may not lie elsewhere."""
    outermost = -np.inf
    for k in range(hull.shape[0]):
        outermost = max(outermost, hull[k, 0] * px + hull[k, 1] * py + hull[k, 2])
    return outermost <= 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def log_apart(rows: FloatArray, count: int, row: FloatArray, skipped: int) -> float:
    """Return the log prior of an inclusion beside the others: two that overlap are rather one."""
    total = 0.0
    for j in range(count):
        if j != skipped:
            if (
                measure_distance(rows[j], row[X], row[Y]) < 1.0
                or measure_distance(row, rows[j, X], rows[j, Y]) < 1.0
            ):
                return -np.inf
            distance = math.hypot(rows[j, X] - row[X], rows[j, Y] - row[Y])
            both = math.exp(rows[j, LOG_RADIUS]) + math.exp(row[LOG_RADIUS])
            if distance < both:
                total += OVERLAP_POWER * math.log(distance / both)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(row: FloatArray, x: FloatArray, y: FloatArray) -> int:
    best, at = np.inf, 0
    for i in range(x.size):
        squared = (x[i] - row[X]) ** 2 + (y[i] - row[Y]) ** 2
        if squared < best:
            best, at = squared, i
    return at


@njit(cache=True, nogil=True, error_model="numpy")
def _weights(residual: FloatArray, precision: FloatArray, out: FloatArray) -> None:
    """Write to ``out`` how far each site is off what all others tell of it, squared, of sum 1."""
    total = 0.0
    for i in range(out.size):
        out[i] = residual[i] ** 2 / precision[i, i] + 0.5
        total += out[i]
    for i in range(out.size):
        out[i] /= total


@njit(cache=True, nogil=True, error_model="numpy")
def _expected_contrast(
    row: FloatArray,
    x: FloatArray,
    y: FloatArray,
    sum_felt: FloatArray,
    residual: FloatArray,
    precision: FloatArray,
    shape: FloatArray,
) -> float:
    """Return the log contrast that explains the site nearest to a new inclusion, 0 if none."""
    i = _nearest(row, x, y)
    off = residual[i] / precision[i, i]
    excess = sum_felt[i] * (math.exp(min(off, 5.0)) - 1.0) / max(shape[i], 0.02)
    return math.log(min(max(1.0 + excess, 0.2), 12.0))


@njit(cache=True, nogil=True, error_model="numpy")
def _birth_width(region: SitesRegion) -> float:
    """Return the standard deviation of a birth's place about a site [mm]."""
    return 0.5 * region.spacing


@njit(cache=True, nogil=True, error_model="numpy")
def _birth_spread(expected: float) -> float:
    """Return the standard deviation of a birth's log contrast about that expected."""
    return 0.1 + 0.3 * abs(expected)


@njit(cache=True, nogil=True, error_model="numpy")
def _log_density_of_birth(
    row: FloatArray, region: SitesRegion, weights: FloatArray, expected: float
) -> float:
    """Return the log density with which a birth proposes place and contrast of an inclusion."""
    width, box, near = _birth_width(region), region.box, 0.0
    for i in range(region.sx.size):
        squared = ((row[X] - region.sx[i]) ** 2 + (row[Y] - region.sy[i]) ** 2) / width**2
        if squared < 40.0:
            near += weights[i] * math.exp(-0.5 * squared)
    place = _ANYWHERE / ((box[1] - box[0]) * (box[3] - box[2]))
    place += (1.0 - _ANYWHERE) * near / (2.0 * math.pi * width**2)
    explains = math.exp(log_normal(row[LOG_CONTRAST], expected, _birth_spread(expected)))
    contrast = (1.0 - _ANY_CONTRAST) * explains / math.sqrt(2.0 * math.pi)
    contrast += _ANY_CONTRAST * math.exp(log_prior_of_contrast(row[LOG_CONTRAST]))
    return math.log(place) + math.log(contrast)


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_birth(
    row: FloatArray,
    region: SitesRegion,
    weights: FloatArray,
    sum_felt: FloatArray,
    residual: FloatArray,
    precision: FloatArray,
    shape: FloatArray,
) -> float:
    """Draw an inclusion: its shape from the prior, its place where sites are off, or anywhere."""
    x, y, box, width = region.sx, region.sy, region.box, _birth_width(region)
    draw_shape(row)
    if np.random.random() < _ANYWHERE:
        row[X] = box[0] + (box[1] - box[0]) * np.random.random()
        row[Y] = box[2] + (box[3] - box[2]) * np.random.random()
    else:
        left, i = np.random.random(), 0
        while i < x.size - 1 and left > weights[i]:
            left -= weights[i]
            i += 1
        row[X] = x[i] + width * np.random.standard_normal()
        row[Y] = y[i] + width * np.random.standard_normal()
    write_shape(row, x, y, shape)
    expected = _expected_contrast(row, x, y, sum_felt, residual, precision, shape)
    if np.random.random() < _ANY_CONTRAST:
        row[LOG_CONTRAST] = draw_contrast()
    else:
        row[LOG_CONTRAST] = expected + _birth_spread(expected) * np.random.standard_normal()
    return expected


@njit(cache=True, nogil=True, error_model="numpy")
def _write_changes(
    shape: FloatArray,
    excess: float,
    old_shape: FloatArray,
    old_excess: float,
    sum_felt: FloatArray,
    r: FloatArray,
    new_sum: FloatArray,
    change: FloatArray,
    where: IntArray,
) -> int:
    """Write the new sum and the changes of r; return how many sites change, -1 if none is left."""
    count = 0
    for i in range(r.size):
        delta = excess * shape[i] - old_excess * old_shape[i]
        new_sum[i] = sum_felt[i] + delta
        if delta != 0.0:
            if new_sum[i] < LEAST_LEFT:
                return -1
            change[count] = -math.log(new_sum[i] / sum_felt[i])
            where[count] = i
            count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _gain(
    change: FloatArray, where: IntArray, count: int, residual: FloatArray, precision: FloatArray
) -> float:
    """Return how the log likelihood changes with r."""
    total = 0.0
    for a in range(count):
        i = where[a]
        row = precision[i]
        inner = 0.0
        for b in range(count):
            inner += row[where[b]] * change[b]
        total += change[a] * (residual[i] + 0.5 * inner)
    return -total


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _take(
    change: FloatArray,
    where: IntArray,
    count: int,
    r: FloatArray,
    residual: FloatArray,
    precision: FloatArray,
) -> None:
    """Change r and Qr."""
    for a in range(count):
        i = where[a]
        r[i] += change[a]
        row, by = precision[i], change[a]
        for j in range(r.size):
            residual[j] += row[j] * by


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _apply(precision: FloatArray, r: FloatArray, out: FloatArray) -> float:
    """Write Qr to ``out`` and return r'Qr."""
    total = 0.0
    for i in range(r.size):
        row, inner = precision[i], 0.0
        for j in range(r.size):
            inner += row[j] * r[j]
        out[i] = inner
        total += inner * r[i]
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _move_inclusion(row: FloatArray, new: FloatArray, kind: int, spacing: float) -> None:
    """Write to ``new`` an inclusion moved a little, or farther, in what ``kind`` says."""
    new[:] = row
    radius = math.exp(row[LOG_RADIUS])
    if kind == 0:
        new[X] += 0.15 * radius * np.random.standard_normal()
        new[Y] += 0.15 * radius * np.random.standard_normal()
    elif kind == 1:
        new[X] += 0.6 * spacing * np.random.standard_normal()
        new[Y] += 0.6 * spacing * np.random.standard_normal()
    elif kind == 2:
        new[LOG_CONTRAST] += 0.1 * np.random.standard_normal()
        new[LOG_RADIUS] += 0.1 * np.random.standard_normal()
    elif kind == 3:
        new[LOG_EXPONENT] += 0.4 * np.random.standard_normal()
        new[LOG_RADIUS] += 0.1 * np.random.standard_normal()
    elif kind == 4:
        new[LOG_ASPECT] = abs(new[LOG_ASPECT] + 0.3 * np.random.standard_normal())
        new[ANGLE] = (new[ANGLE] + 0.5 * np.random.standard_normal()) % np.pi
    else:
        new[LOG_RADIUS] += 0.25 * np.random.standard_normal()
        new[LOG_EXPONENT] += 0.4 * np.random.standard_normal()
        # The same length there and back: the geometric mean of both radii.
        both = math.exp(0.5 * (row[LOG_RADIUS] + new[LOG_RADIUS]))
        new[X] += 0.2 * both * np.random.standard_normal()
        new[Y] += 0.2 * both * np.random.standard_normal()


@njit(cache=True, nogil=True, error_model="numpy")
def _is_allowed(row: FloatArray, region: SitesRegion) -> bool:
    """Whether an inclusion is one that the prior knows."""
    prior = log_prior_of_shape(row) + log_prior_of_contrast(row[LOG_CONTRAST])
    return prior > -np.inf and _inside(row[X], row[Y], region.hull)


@njit(cache=True, nogil=True, error_model="numpy")
def _propose(
    state_sum: FloatArray,
    residual: FloatArray,
    Q: FloatArray,
    region: SitesRegion,
    scratch: Scratch,
) -> float:
    """Draw an inclusion to be born, and return the log density of that."""
    expected = _draw_birth(
        scratch.new, region, scratch.weights, state_sum, residual, Q, scratch.shape
    )
    return _log_density_of_birth(scratch.new, region, scratch.weights, expected)


@njit(cache=True, nogil=True, error_model="numpy")
def _leave_out(
    state: ChainState, j: int, region: SitesRegion, scratch: Scratch
) -> tuple[float, float]:
    """Write the state without an inclusion to scratch.

    Return the gain in log likelihood and the log density with which a birth would bring it back;
    NaN if the rest is no state.
    """
    Q = state.precision
    changed = _write_changes(
        scratch.nothing, 0.0, state.shapes[j], state.excesses[j], state.sum_felt, state.r,
        scratch.without_sum, scratch.change, scratch.where,
    )  # fmt: skip
    if changed < 0:
        return np.nan, np.nan
    gain = _gain(scratch.change, scratch.where, changed, state.residual, Q)
    scratch.without_r[:] = state.r
    scratch.without_residual[:] = state.residual
    _take(scratch.change, scratch.where, changed, scratch.without_r, scratch.without_residual, Q)
    _weights(scratch.without_residual, Q, scratch.weights)
    row = state.inclusions[j]
    expected = _expected_contrast(
        row, region.sx, region.sy, scratch.without_sum, scratch.without_residual, Q,
        state.shapes[j],
    )  # fmt: skip
    return gain, _log_density_of_birth(row, region, scratch.weights, expected)


@njit(cache=True, nogil=True, error_model="numpy")
def propose_birth(
    state: ChainState, count: int, beta: float, region: SitesRegion, scratch: Scratch
) -> int:
    """Propose one more inclusion; return how many there are then."""
    if count == MOST_INCLUSIONS:
        return count
    new, shape, Q = scratch.new, scratch.shape, state.precision
    _weights(state.residual, Q, scratch.weights)
    density = _propose(state.sum_felt, state.residual, Q, region, scratch)
    if not _is_allowed(new, region):
        return count
    excess = math.exp(new[LOG_CONTRAST]) - 1.0
    changed = _write_changes(
        shape, excess, scratch.nothing, 0.0, state.sum_felt, state.r, scratch.sum_felt,
        scratch.change, scratch.where,
    )  # fmt: skip
    if changed < 0:
        return count
    log_ratio = (
        beta * _gain(scratch.change, scratch.where, changed, state.residual, Q)
        + math.log(FURTHER)
        + log_apart(state.inclusions, count, new, -1)
        - math.log(region.area)
        + log_prior_of_contrast(new[LOG_CONTRAST])
        - density
    )
    if math.log(np.random.random()) >= log_ratio:
        return count
    state.inclusions[count], state.shapes[count] = new, shape
    state.excesses[count] = excess
    state.sum_felt[:] = scratch.sum_felt
    _take(scratch.change, scratch.where, changed, state.r, state.residual, Q)
    return count + 1


@njit(cache=True, nogil=True, error_model="numpy")
def propose_death(
    state: ChainState, count: int, beta: float, region: SitesRegion, scratch: Scratch
) -> int:
    """Propose one inclusion fewer; return how many there are then."""
    if count == 0:
        return count
    j = np.random.randint(count)
    gain, density = _leave_out(state, j, region, scratch)
    log_ratio = (
        beta * gain
        - math.log(FURTHER)
        - log_apart(state.inclusions, count, state.inclusions[j], j)
        + math.log(region.area)
        - log_prior_of_contrast(state.inclusions[j, LOG_CONTRAST])
        + density
    )
    if not math.log(np.random.random()) < log_ratio:
        return count
    last = count - 1
    state.inclusions[j], state.shapes[j] = state.inclusions[last], state.shapes[last]
    state.excesses[j] = state.excesses[last]
    state.sum_felt[:] = scratch.without_sum
    state.r[:], state.residual[:] = scratch.without_r, scratch.without_residual
    return last


@njit(cache=True, nogil=True, error_model="numpy")
def propose_redraw(
    state: ChainState, count: int, beta: float, region: SitesRegion, scratch: Scratch
) -> None:
    """Propose another inclusion instead of one, as if that had died and this were born."""
    if count == 0:
        return
    j, new, shape = np.random.randint(count), scratch.new, scratch.shape
    Q = state.precision
    gain, density = _leave_out(state, j, region, scratch)
    if gain != gain:
        return
    log_ratio = beta * gain + density - log_prior_of_contrast(state.inclusions[j, LOG_CONTRAST])
    log_ratio -= log_apart(state.inclusions, count, state.inclusions[j], j)
    log_ratio -= _propose(scratch.without_sum, scratch.without_residual, Q, region, scratch)
    if not _is_allowed(new, region):
        return
    excess = math.exp(new[LOG_CONTRAST]) - 1.0
    changed = _write_changes(
        shape, excess, scratch.nothing, 0.0, scratch.without_sum, scratch.without_r,
        scratch.sum_felt, scratch.change, scratch.where,
    )  # fmt: skip
    if changed < 0:
        return
    log_ratio += beta * _gain(scratch.change, scratch.where, changed, scratch.without_residual, Q)
    log_ratio += log_apart(state.inclusions, count, new, j)
    log_ratio += log_prior_of_contrast(new[LOG_CONTRAST])
    if math.log(np.random.random()) < log_ratio:
        _take(
            scratch.change, scratch.where, changed, scratch.without_r, scratch.without_residual, Q
        )
        state.inclusions[j], state.shapes[j], state.excesses[j] = new, shape, excess
        state.sum_felt[:], state.r[:] = scratch.sum_felt, scratch.without_r
        state.residual[:] = scratch.without_residual


@njit(cache=True, nogil=True, error_model="numpy")
def propose_level(
    state: ChainState,
    level: int,
    beta: float,
    precision: FloatArray,
    log_weight: FloatArray,
    scratch: Scratch,
) -> int:
    """Propose another level of variation, a neighbour mostly; return the level then."""
    other = np.random.randint(log_weight.size)
    if np.random.random() < 0.7:
        other = level + (1 if np.random.random() < 0.5 else -1)
    if other == level or not 0 <= other < log_weight.size:
        return level
    log_det = with_outliers(precision[other], state.kinds, scratch.precision)
    new_quadratic = _apply(scratch.precision, state.r, scratch.without_residual)
    log_ratio = log_weight[other] + log_det - log_weight[level] - state.log_det[0]
    log_ratio -= 0.5 * (new_quadratic - np.dot(state.r, state.residual))
    if math.log(np.random.random()) >= beta * log_ratio:
        return level
    state.residual[:] = scratch.without_residual
    state.precision[:], state.log_det[0] = scratch.precision, log_det
    return other


@njit(cache=True, nogil=True, error_model="numpy")
def weigh_told(state: ChainState, level: int, log_weight: FloatArray) -> float:
    """Return what the data say of a state: its log density at a beta of 1, less the prior's."""
    return float(log_weight[level] + state.log_det[0] - 0.5 * np.dot(state.r, state.residual))


@njit(cache=True, nogil=True, error_model="numpy")
def _same_at_nearest(
    state: ChainState, j: int, region: SitesRegion, scratch: Scratch
) -> tuple[float, float]:
    """Give a reshaped inclusion the contrast that its nearest site feels as before.

    Return its excess and the log Jacobian; NaN if that site is another, or there is none such.
    """
    new, shape = scratch.new, scratch.shape
    i = _nearest(state.inclusions[j], region.sx, region.sy)
    if i != _nearest(new, region.sx, region.sy):
        return np.nan, np.nan
    if shape[i] <= 1e-3 or state.shapes[j, i] <= 1e-3:
        return np.nan, np.nan
    excess = state.excesses[j] * state.shapes[j, i] / shape[i]
    if excess <= -1.0:
        return np.nan, np.nan
    new[LOG_CONTRAST] = math.log(1.0 + excess)
    jacobian = math.log(state.shapes[j, i] / shape[i])
    return excess, jacobian + state.inclusions[j, LOG_CONTRAST] - new[LOG_CONTRAST]


@njit(cache=True, nogil=True, error_model="numpy")
def propose_change(
    state: ChainState, count: int, kind: int, beta: float, region: SitesRegion, scratch: Scratch
) -> None:
    """Propose another place, extent, contrast or shape of an inclusion: ``kind`` of ``KINDS``."""
    if count == 0:
        return
    j = np.random.randint(count)
    old, new, shape = state.inclusions[j], scratch.new, scratch.shape
    Q = state.precision
    _move_inclusion(old, new, kind, region.spacing)
    if not _is_allowed(new, region):
        return
    write_shape(new, region.sx, region.sy, shape)
    excess, jacobian = math.exp(new[LOG_CONTRAST]) - 1.0, 0.0
    if kind >= _RESHAPES:
        excess, jacobian = _same_at_nearest(state, j, region, scratch)
        if excess != excess:
            return
    changed = _write_changes(
        shape, excess, state.shapes[j], state.excesses[j], state.sum_felt, state.r,
        scratch.sum_felt, scratch.change, scratch.where,
    )  # fmt: skip
    if changed < 0:
        return
    log_ratio = (
        beta * _gain(scratch.change, scratch.where, changed, state.residual, Q)
        + jacobian
        + log_prior_of_shape(new)
        - log_prior_of_shape(old)
        + log_prior_of_contrast(new[LOG_CONTRAST])
        - log_prior_of_contrast(old[LOG_CONTRAST])
        + log_apart(state.inclusions, count, new, j)
        - log_apart(state.inclusions, count, old, j)
    )
    if math.log(np.random.random()) < log_ratio:
        state.inclusions[j], state.shapes[j], state.excesses[j] = new, shape, excess
        state.sum_felt[:] = scratch.sum_felt
        _take(scratch.change, scratch.where, changed, state.r, state.residual, Q)


@njit(cache=True, nogil=True, error_model="numpy")
def begin_state(
    inclusions: FloatArray,
    count: int,
    kinds: ErrorKinds,
    Q: FloatArray,
    y: FloatArray,
    region: SitesRegion,
) -> ChainState:
    """Return the state of inclusions and of the kinds of errors of sites."""
    n = y.size
    state = ChainState(
        inclusions, np.zeros((MOST_INCLUSIONS, n)), np.zeros(MOST_INCLUSIONS),
        np.ones(n), np.empty(n), np.empty(n), kinds, np.empty((n, n)), np.empty(1),
    )  # fmt: skip
    state.log_det[0] = with_outliers(Q, kinds, state.precision)
    for j in range(count):
        write_shape(inclusions[j], region.sx, region.sy, state.shapes[j])
        state.excesses[j] = math.exp(inclusions[j, LOG_CONTRAST]) - 1.0
        state.sum_felt[:] += state.excesses[j] * state.shapes[j]
    state.r[:] = y - np.log(state.sum_felt)
    _apply(state.precision, state.r, state.residual)
    return state


@njit(cache=True, nogil=True, error_model="numpy")
def make_scratch(n: int) -> Scratch:
    """Return scratch for the moves of states of n sites."""
    return Scratch(
        np.empty(PARAMETERS), np.empty(n), np.zeros(n), np.empty(n), np.empty(n),
        np.empty(n, np.int64), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty((n, n)),
    )  # fmt: skip
