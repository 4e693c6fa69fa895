"""One reversible-jump Markov chain over the inclusions of a map.

What belongs here: the moves, and when they are accepted. What does not: the prior (``prior``), the
shape of an inclusion (``shape``), the background's covariance (``background``), and how many chains
run how long (``sampling``).

The background is integrated out, so that a state is a list of inclusions and a level of variation.
Its log density is -r'Qr / 2 and the prior's, where r is log k less that of the inclusions and Q the
level's precision. With r changed at the few sites that a move reaches, r'Qr is changed by these
alone.

P. J. Green, Reversible jump Markov chain Monte Carlo computation and Bayesian model determination,
Biometrika 82 (1995) 711.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from tissue_probe.mapping.posterior.prior import (
    ANGLE,
    CONTRAST_SCALE,
    FURTHER,
    LOG_ASPECT,
    LOG_CONTRAST,
    LOG_EXPONENT,
    LOG_RADIUS,
    MOST,
    OVERLAP,
    PARAMETERS,
    SOFT,
    X,
    Y,
    draw_contrast,
    draw_shape,
    log_prior_of_contrast,
    log_prior_of_shape,
)
from tissue_probe.mapping.posterior.shape import felt, squared_distance

#: Of all moves: birth or death, an inclusion drawn anew, the level; the rest moves an inclusion.
_JUMP, _REDRAWN, _LEVEL_MOVE = 0.25, 0.1, 0.05
#: Share of births anywhere, against those where the sites are off.
_ANYWHERE = 0.3
#: An inclusion that softens takes this much of the stiffness at most, with all others.
_LEAST_LEFT = 0.05


@njit(cache=True, nogil=True, error_model="numpy")
def _inside(px, py, x, y, reach, box):
    """Whether a place is in the box and within reach of a site: nothing is said of any other."""
    if not (box[0] <= px <= box[1] and box[2] <= py <= box[3]):
        return False
    nearest = np.inf
    for i in range(x.size):
        nearest = min(nearest, (px - x[i]) ** 2 + (py - y[i]) ** 2)
    return nearest <= reach**2


@njit(cache=True, nogil=True, error_model="numpy")
def _log_apart(rows, count, row, skipped):
    """Return the log prior of an inclusion beside the others: two that overlap are rather one."""
    total = 0.0
    for j in range(count):
        if j != skipped:
            if (
                squared_distance(rows[j], row[X], row[Y]) < 1.0
                or squared_distance(row, rows[j, X], rows[j, Y]) < 1.0
            ):
                return -np.inf
            distance = math.hypot(rows[j, X] - row[X], rows[j, Y] - row[Y])
            both = math.exp(rows[j, LOG_RADIUS]) + math.exp(row[LOG_RADIUS])
            if distance < both:
                total += OVERLAP * math.log(distance / both)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(row, x, y):
    best, at = np.inf, 0
    for i in range(x.size):
        squared = (x[i] - row[X]) ** 2 + (y[i] - row[Y]) ** 2
        if squared < best:
            best, at = squared, i
    return at


@njit(cache=True, nogil=True, error_model="numpy")
def _weights(residual, precision, out):
    """Write to ``out`` how far each site is off what all others tell of it, squared, of sum 1."""
    total = 0.0
    for i in range(out.size):
        out[i] = residual[i] ** 2 / precision[i, i] + 0.5
        total += out[i]
    for i in range(out.size):
        out[i] /= total


@njit(cache=True, nogil=True, error_model="numpy")
def _expected_contrast(row, x, y, sum_felt, residual, precision, shape):
    """Return the log contrast that explains the site nearest to a new inclusion, 0 if none."""
    i = _nearest(row, x, y)
    off = residual[i] / precision[i, i]
    excess = sum_felt[i] * (math.exp(min(off, 5.0)) - 1.0) / max(shape[i], 0.02)
    return math.log(min(max(1.0 + excess, 0.2), 12.0))


@njit(cache=True, nogil=True, error_model="numpy")
def _log_density_of_birth(row, x, y, width, area, weights, expected):
    """Return the log density with which a birth proposes place and contrast of an inclusion."""
    near = 0.0
    for i in range(x.size):
        squared = ((row[X] - x[i]) ** 2 + (row[Y] - y[i]) ** 2) / width**2
        if squared < 40.0:
            near += weights[i] * math.exp(-0.5 * squared)
    place = _ANYWHERE / area + (1.0 - _ANYWHERE) * near / (2.0 * math.pi * width**2)
    spread = 0.1 + 0.3 * abs(expected)
    explains = math.exp(-0.5 * ((row[LOG_CONTRAST] - expected) / spread) ** 2)
    explains /= spread * math.sqrt(2.0 * math.pi)
    size = abs(row[LOG_CONTRAST])
    sign = SOFT if row[LOG_CONTRAST] < 0.0 else 1.0 - SOFT
    any_size = sign * size / CONTRAST_SCALE**2 * math.exp(-size / CONTRAST_SCALE)
    return math.log(place) + math.log(0.5 * any_size + 0.5 * explains)


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_birth(row, x, y, width, box, weights, sum_felt, residual, precision, shape):
    """Draw an inclusion: its shape from the prior, its place where sites are off, or anywhere."""
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
    felt(row, x, y, shape)
    expected = _expected_contrast(row, x, y, sum_felt, residual, precision, shape)
    if np.random.random() < 0.5:
        row[LOG_CONTRAST] = draw_contrast()
    else:
        row[LOG_CONTRAST] = expected + (0.1 + 0.3 * abs(expected)) * np.random.standard_normal()
    return expected


@njit(cache=True, nogil=True, error_model="numpy")
def _changed(shape, excess, old_shape, old_excess, sum_felt, r, new_sum, change, where):
    """Write the new sum and the changes of r; return how many sites change, -1 if none is left."""
    count = 0
    for i in range(r.size):
        delta = excess * shape[i] - old_excess * old_shape[i]
        new_sum[i] = sum_felt[i] + delta
        if delta != 0.0:
            if new_sum[i] < _LEAST_LEFT:
                return -1
            change[count] = -math.log(new_sum[i] / sum_felt[i])
            where[count] = i
            count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _gain(change, where, count, residual, precision):
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
def _take(change, where, count, r, residual, precision):
    """Change r and Qr."""
    for a in range(count):
        i = where[a]
        r[i] += change[a]
        row, by = precision[i], change[a]
        for j in range(r.size):
            residual[j] += row[j] * by


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _apply(precision, r, out):
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
def _moved(row, new, kind, spacing):
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
        new[X] += 0.2 * radius * np.random.standard_normal()
        new[Y] += 0.2 * radius * np.random.standard_normal()


@njit(cache=True, nogil=True, error_model="numpy")
def run(
    seed,
    y,
    sx,
    sy,
    reach,
    spacing,
    box,
    area,
    precision,
    log_weight,
    state,
    steps,
    thin,
    rows,
    kept,
    levels,
):
    """Run a chain on, and keep every ``thin``-th state.

    Parameters
    ----------
    seed : int
        Of this stretch of the chain.
    y : array, shape (n,)
        log k less its median.
    sx, sy : array, shape (n,)
        Places of the sites [mm].
    reach, spacing, area : float
        How far from a site an inclusion may lie, the sites' distance [mm], and the area so
        reached [mm^2].
    precision, log_weight : array
        As in ``Background``.
    state : array, shape (MOST + 1, PARAMETERS)
        The inclusions, and in the last row their number and the level; left as the chain ends.
    steps, thin : int
        Moves of the stretch.
    rows, kept, levels : array, shapes (s, MOST, PARAMETERS), (s,) and (s,)
        Written: inclusions, their number, and the level of each kept state.
    """
    np.random.seed(seed)
    n = y.size
    width = 0.5 * spacing
    inclusions = state[:MOST]
    count, level = int(state[MOST, 0]), int(state[MOST, 1])
    kinds = log_weight.size
    shapes, excesses = np.zeros((MOST, n)), np.zeros(MOST)
    sum_felt = np.ones(n)
    for j in range(count):
        felt(inclusions[j], sx, sy, shapes[j])
        excesses[j] = math.exp(inclusions[j, LOG_CONTRAST]) - 1.0
        sum_felt += excesses[j] * shapes[j]
    r = y - np.log(sum_felt)
    residual, other_residual = np.empty(n), np.empty(n)
    quadratic = _apply(precision[level], r, residual)
    new, shape, nothing = np.empty(PARAMETERS), np.empty(n), np.zeros(n)
    new_sum, change, where = np.empty(n), np.empty(n), np.empty(n, np.int64)
    without_sum, without_r, weights = np.empty(n), np.empty(n), np.empty(n)
    written = 0
    for step in range(steps):
        Q = precision[level]
        choice = np.random.random()
        if choice < _JUMP:
            if np.random.random() < 0.5:
                if count < MOST:
                    _weights(residual, Q, weights)
                    expected = _draw_birth(
                        new, sx, sy, width, box, weights, sum_felt, residual, Q, shape
                    )
                    prior = log_prior_of_shape(new) + log_prior_of_contrast(new[LOG_CONTRAST])
                    if prior > -np.inf and _inside(new[X], new[Y], sx, sy, reach, box):
                        apart = _log_apart(inclusions, count, new, -1)
                        excess = math.exp(new[LOG_CONTRAST]) - 1.0
                        changed = _changed(
                            shape, excess, nothing, 0.0, sum_felt, r, new_sum, change, where
                        )
                        if changed >= 0:
                            log_ratio = (
                                _gain(change, where, changed, residual, Q)
                                + math.log(FURTHER)
                                + apart
                                - math.log(area)
                                + log_prior_of_contrast(new[LOG_CONTRAST])
                                - _log_density_of_birth(
                                    new,
                                    sx,
                                    sy,
                                    width,
                                    (box[1] - box[0]) * (box[3] - box[2]),
                                    weights,
                                    expected,
                                )
                            )
                            if math.log(np.random.random()) < log_ratio:
                                inclusions[count], shapes[count] = new, shape
                                excesses[count] = excess
                                count += 1
                                sum_felt[:] = new_sum
                                _take(change, where, changed, r, residual, Q)
            elif count > 0:
                j = np.random.randint(count)
                changed = _changed(
                    nothing, 0.0, shapes[j], excesses[j], sum_felt, r, new_sum, change, where
                )
                if changed >= 0:
                    gain = _gain(change, where, changed, residual, Q)
                    without_r[:], other_residual[:] = r, residual
                    _take(change, where, changed, without_r, other_residual, Q)
                    _weights(other_residual, Q, weights)
                    expected = _expected_contrast(
                        inclusions[j], sx, sy, new_sum, other_residual, Q, shapes[j]
                    )
                    log_ratio = (
                        gain
                        - math.log(FURTHER)
                        - _log_apart(inclusions, count, inclusions[j], j)
                        + math.log(area)
                        - log_prior_of_contrast(inclusions[j, LOG_CONTRAST])
                        + _log_density_of_birth(
                            inclusions[j],
                            sx,
                            sy,
                            width,
                            (box[1] - box[0]) * (box[3] - box[2]),
                            weights,
                            expected,
                        )
                    )
                    if math.log(np.random.random()) < log_ratio:
                        count -= 1
                        inclusions[j], shapes[j] = inclusions[count], shapes[count]
                        excesses[j] = excesses[count]
                        sum_felt[:], r[:], residual[:] = new_sum, without_r, other_residual
        elif choice < _JUMP + _REDRAWN:
            if count > 0:
                j = np.random.randint(count)
                changed = _changed(
                    nothing, 0.0, shapes[j], excesses[j], sum_felt, r, without_sum, change, where
                )
                if changed >= 0:
                    gain = _gain(change, where, changed, residual, Q)
                    without_r[:], other_residual[:] = r, residual
                    _take(change, where, changed, without_r, other_residual, Q)
                    _weights(other_residual, Q, weights)
                    box_area = (box[1] - box[0]) * (box[3] - box[2])
                    expected = _expected_contrast(
                        inclusions[j], sx, sy, without_sum, other_residual, Q, shapes[j]
                    )
                    log_ratio = (
                        gain
                        + _log_density_of_birth(
                            inclusions[j], sx, sy, width, box_area, weights, expected
                        )
                        - log_prior_of_contrast(inclusions[j, LOG_CONTRAST])
                    )
                    expected = _draw_birth(
                        new, sx, sy, width, box, weights, without_sum, other_residual, Q, shape
                    )
                    prior = log_prior_of_shape(new) + log_prior_of_contrast(new[LOG_CONTRAST])
                    if prior > -np.inf and _inside(new[X], new[Y], sx, sy, reach, box):
                        log_ratio += _log_apart(inclusions, count, new, j)
                        log_ratio -= _log_apart(inclusions, count, inclusions[j], j)
                        excess = math.exp(new[LOG_CONTRAST]) - 1.0
                        changed = _changed(
                            shape,
                            excess,
                            nothing,
                            0.0,
                            without_sum,
                            without_r,
                            new_sum,
                            change,
                            where,
                        )
                        if changed >= 0:
                            log_ratio += (
                                _gain(change, where, changed, other_residual, Q)
                                + log_prior_of_contrast(new[LOG_CONTRAST])
                                - _log_density_of_birth(
                                    new, sx, sy, width, box_area, weights, expected
                                )
                            )
                            if math.log(np.random.random()) < log_ratio:
                                _take(change, where, changed, without_r, other_residual, Q)
                                inclusions[j], shapes[j], excesses[j] = new, shape, excess
                                sum_felt[:], r[:] = new_sum, without_r
                                residual[:] = other_residual
        elif choice < _JUMP + _REDRAWN + _LEVEL_MOVE:
            other = np.random.randint(kinds)
            if np.random.random() < 0.7:
                other = level + (1 if np.random.random() < 0.5 else -1)
            if 0 <= other < kinds and other != level:
                new_quadratic = _apply(precision[other], r, other_residual)
                quadratic = 0.0
                for i in range(n):
                    quadratic += r[i] * residual[i]
                log_ratio = (
                    log_weight[other] - log_weight[level] - 0.5 * (new_quadratic - quadratic)
                )
                if math.log(np.random.random()) < log_ratio:
                    level = other
                    residual[:] = other_residual
        elif count > 0:
            j, kind = np.random.randint(count), np.random.randint(6)
            _moved(inclusions[j], new, kind, spacing)
            prior = (
                log_prior_of_shape(new)
                + log_prior_of_contrast(new[LOG_CONTRAST])
                - log_prior_of_shape(inclusions[j])
                - log_prior_of_contrast(inclusions[j, LOG_CONTRAST])
            )
            if prior > -np.inf and _inside(new[X], new[Y], sx, sy, reach, box):
                prior += _log_apart(inclusions, count, new, j)
                prior -= _log_apart(inclusions, count, inclusions[j], j)
                felt(new, sx, sy, shape)
                excess = math.exp(new[LOG_CONTRAST]) - 1.0
                jacobian, possible = 0.0, True
                if kind >= 3:
                    # The site nearest to it feels what it felt: a change of shape alone.
                    i = _nearest(inclusions[j], sx, sy)
                    possible = i == _nearest(new, sx, sy)
                    possible &= shape[i] > 1e-3 and shapes[j, i] > 1e-3
                    if possible:
                        excess = excesses[j] * shapes[j, i] / shape[i]
                        possible = excess > -0.95
                    if possible:
                        new[LOG_CONTRAST] = math.log(1.0 + excess)
                        jacobian = (
                            math.log(shapes[j, i] / shape[i])
                            + inclusions[j, LOG_CONTRAST]
                            - new[LOG_CONTRAST]
                        )
                        prior += log_prior_of_contrast(new[LOG_CONTRAST]) - log_prior_of_contrast(
                            inclusions[j, LOG_CONTRAST]
                        )
                if possible:
                    changed = _changed(
                        shape, excess, shapes[j], excesses[j], sum_felt, r, new_sum, change, where
                    )
                    if changed >= 0:
                        gain = _gain(change, where, changed, residual, Q)
                        if math.log(np.random.random()) < gain + prior + jacobian:
                            inclusions[j], shapes[j], excesses[j] = new, shape, excess
                            sum_felt[:] = new_sum
                            _take(change, where, changed, r, residual, Q)
        if (step + 1) % thin == 0:
            rows[written, :count] = inclusions[:count]
            kept[written], levels[written] = count, level
            written += 1
    state[MOST, 0], state[MOST, 1] = count, level
