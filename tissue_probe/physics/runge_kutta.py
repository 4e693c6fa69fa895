"""A composed model integrated over a recording by Runge and Kutta's rule, with its tangents.

Contents: the steps, and switches found within a step, in Numba's Python.

Imported only where machine code of a model has to be made: that takes seconds.
"""

from __future__ import annotations

import math

from numba import cfunc

from tissue_probe.physics.coil_course import coil_course
from tissue_probe.physics.model_functions import LINKED, output, rate, switch  # noqa: F401
from tissue_probe.physics.pointers import RUN_TYPE, Pointer, compile_fused, compile_inner, further

# The fastest eigenvalue times a part's length stays below LONGEST_PART: a step is divided. A branch
# that relaxes follows the tip's speed, which is smooth; its rate times the length is below
# SMOOTHLY.
LONGEST_PART, SMOOTHLY = 0.8, 1.6
FEWEST_PARTS, MOST_PARTS = 1, 64
# Friction is stiff at rest, yielding at speed: a step is divided by the number found in its range
# of the tip's speed. The ranges are those up to SLOWEST_TIP [m/s], twice that and so on.
SLOWEST_TIP = 1e-5
# A range is looked at when it is met the first time, so many times later, and ever more rarely.
AGAIN = 16.0
# Switches within one part beyond this many are left to the next one (chatter).
EVENTS = 6
# Steps of regula falsi at the most; a condition of two parts may have a kink at the switch.
LOCATING = 30
# A tangent of which less is left is forgotten: processors take a hundred times as long to compute
# with numbers as small as decay ends in (subnormal ones).
FORGOTTEN = 1e-100
# A matrix is squared so many times: the norm's root is then its fastest eigenvalue, or a little
# more.
SQUARINGS = 7


@compile_fused
def _to_stage(
    count: int,
    z: Pointer[float],
    part: float,
    f: Pointer[float],
    weight: float,
    total: Pointer[float],
    z1: Pointer[float],
) -> None:
    """Go on by a part of the step; add the rates to their total, which begins with weight 1."""
    if weight == 1.0:
        for j in range(count):
            total[j] = f[j]
            z1[j] = z[j] + part * f[j]
    else:
        for j in range(count):
            total[j] += weight * f[j]
            z1[j] = z[j] + part * f[j]


@compile_fused
def _to_end(
    count: int,
    z: Pointer[float],
    h: float,
    total: Pointer[float],
    f: Pointer[float],
    z1: Pointer[float],
) -> None:
    """Go on to the end of the step; ``f`` are the rates there."""
    for j in range(count):
        z1[j] = z[j] + h / 6.0 * (total[j] + f[j])


@compile_inner
def _forget(count: int, T: Pointer[float]) -> None:
    for j in range(count):
        T[j] = 0.0 if abs(T[j]) < FORGOTTEN else T[j]


@compile_inner
def _copy(count: int, z: Pointer[float], z1: Pointer[float]) -> None:
    for j in range(count):
        z1[j] = z[j]


@compile_inner
def _advance(
    n: int,
    q: int,
    t: float,
    p: Pointer[float],
    z: Pointer[float],
    T: Pointer[float],
    pieces: Pointer[float],
    changes: Pointer[float],
    columns: Pointer[int],
    r: int,
    order: int,
    w: int,
    count: int,
    sample: int,
    since: float,
    h: float,
    mode: Pointer[float],
    u: Pointer[float],
    dU: Pointer[float],
    first: Pointer[float],
    f: Pointer[float],
    slope: Pointer[float],
    total: Pointer[float],
    totals: Pointer[float],
    z1: Pointer[float],
    T1: Pointer[float],
) -> None:
    """Advance states and tangents by ``h``, from ``since`` after the sample, into z1 and T1.

    ``first`` and ``f`` are then the rates at the beginning and at the end.
    """
    coil_course(pieces, changes, columns, r, order, w, count, q, sample, since, u, dU)
    rate(t + since, z, p, u, mode, T, dU, f, slope)
    _copy(n, f, first)
    for stage in range(1, 4):
        part, weight = (h if stage == 3 else 0.5 * h), (1.0 if stage == 1 else 2.0)
        _to_stage(n, z, part, f, weight, total, z1)
        _to_stage(n * q, T, part, slope, weight, totals, T1)
        if stage != 2:
            coil_course(
                pieces, changes, columns, r, order, w, count, q, sample, since + part, u, dU
            )
        rate(t + since + part, z1, p, u, mode, T1, dU, f, slope)
    _to_end(n, z, h, total, f, z1)
    _to_end(n * q, T, h, totals, slope, T1)


@compile_inner
def _fastest_branch(A: Pointer[float], n: int, tip: int) -> float:
    """Return the fastest rate at which a state forgets that only the tip's speed moves.

    It is taken out of the matrix: without it a branch is the spring that it is at once.
    """
    fastest = 0.0
    for i in range(n):
        rate_of_it, alone = -A[i * n + i], i != tip
        for j in range(n):
            alone &= j in (i, tip) or A[i * n + j] == 0.0
        if alone and rate_of_it > 0.0:
            A[i * n + i] = 0.0
            fastest = max(fastest, rate_of_it)
    return fastest


@compile_inner
def _parts(
    n: int,
    q: int,
    t: float,
    p: Pointer[float],
    z: Pointer[float],
    u: Pointer[float],
    mode: Pointer[float],
    dU: Pointer[float],
    tip: int,
    slope: Pointer[float],
    squared: Pointer[float],
    T: Pointer[float],
    f: Pointer[float],
    period: float,
) -> int:
    """Return into how many parts a step is divided, of the fastest eigenvalue at a state.

    ``slope``, ``squared``, ``T`` and ``f`` are overwritten.
    """
    if n == 0:
        return 1
    for j in range(n * q):
        T[j] = 0.0
    for i in range(n):
        T[i * q + i] = 1.0
    rate(t, z, p, u, mode, T, dU, f, slope)
    for i in range(n):
        for j in range(n):
            T[i * n + j] = slope[i * q + j]
    relaxing = _fastest_branch(T, n, tip) * period / SMOOTHLY
    fewest = max(FEWEST_PARTS, math.ceil(min(relaxing, MOST_PARTS)))
    logarithm = 0.0
    for squaring in range(SQUARINGS + 1):
        norm = 0.0
        for j in range(n * n):
            norm += T[j] ** 2
        norm = math.sqrt(norm)
        if norm == 0.0:
            return fewest
        if not norm < math.inf:
            return MOST_PARTS
        logarithm = 2.0 * logarithm + math.log(norm)
        if squaring == SQUARINGS:
            break
        for j in range(n * n):
            squared[j] = T[j] / norm
            T[j] = 0.0
        for i in range(n):
            for k in range(n):
                factor = squared[i * n + k]
                for j in range(n):
                    T[i * n + j] += factor * squared[k * n + j]
    fastest = math.exp(logarithm / 2.0**SQUARINGS)
    if not fastest * period / LONGEST_PART < MOST_PARTS:
        return MOST_PARTS
    return max(fewest, math.ceil(fastest * period / LONGEST_PART))


@compile_inner
def _lowest(g: float, rise: float, g1: float, rise1: float) -> tuple[float, float]:
    """Return where a cubic from g to g1 of these slopes is lowest between, and how low.

    A switch may turn within a part and back again: a tip that hardly pulls itself off.
    """
    if g <= 0.0 or rise >= 0.0 or rise1 <= 0.0:
        return 1.0, g1
    square, cube = 3.0 * (g1 - g) - 2.0 * rise - rise1, 2.0 * (g - g1) + rise + rise1
    inner = square * square - 3.0 * cube * rise
    share = -rise / (square + math.sqrt(max(inner, 0.0)))
    return share, g + share * (rise + share * (square + share * cube))


@cfunc(RUN_TYPE, error_model="numpy")
def run(arrays: Pointer[Pointer[float]], sizes: Pointer[int], period: float, begins: float) -> None:
    """Integrate.

    ``sizes`` are n, q, len p, s, r, samples, tip, ranges of the tip's speed, coefficients of a
    piece, how many times more parts a step is divided into than needed at least, rows of pieces of
    the second input, and the numbers of the r columns that move with the coil. ``arrays`` are p, z,
    mode, pieces, changes, coil, those of ``response._in_steps``, answer and sensitivity.
    """
    n, q, s, r, samples = sizes[0], sizes[1], sizes[3], sizes[4], sizes[5]
    tip, ranges, order, finer, w = sizes[6], sizes[7], sizes[8], sizes[9], sizes[10]
    columns, count = further(sizes, 11), samples - 1
    p, z, mode, pieces, changes = arrays[0], arrays[1], arrays[2], arrays[3], arrays[4]
    u, answer, sensitivity = arrays[5], arrays[11], arrays[12]
    dU = further(u, 4)
    first, f, total = arrays[6], further(arrays[6], n), further(arrays[6], 2 * n)
    z1, after = further(arrays[6], 3 * n), further(arrays[6], 4 * n)
    T, slope = arrays[7], further(arrays[7], n * q)
    totals, T1 = further(arrays[7], 2 * n * q), further(arrays[7], 3 * n * q)
    g, g1 = arrays[8], further(arrays[8], s)
    dg, dg1 = further(arrays[8], 2 * s), further(arrays[8], 3 * s)
    G, later = arrays[9], further(arrays[9], s * q)
    met, due, found = arrays[10], further(arrays[10], ranges), further(arrays[10], 2 * ranges)
    for i in range(n):
        T[i * q + i] = 1.0
    coil_course(pieces, changes, columns, r, order, w, count, q, 0, 0.0, u, dU)
    for _ in range(2):
        rate(begins, z, p, u, mode, T, dU, after, slope)
        switch(begins, z, p, u, mode, T, dU, after, g, dg, G)
        for k in range(s):
            if g[k] < 0.0:
                mode[k] = 1.0 - mode[k]
    before = math.nan
    for sample in range(samples):
        last = sample == count
        piece = sample - 1 if last else sample
        t = begins + piece * period
        since = period if last else 0.0
        coil_course(pieces, changes, columns, r, order, w, count, q, piece, since, u, dU)
        answer[sample] = output(
            begins + sample * period, z, p, u, mode, T, dU, further(sensitivity, sample * q)
        )
        if last:
            break
        speed = z[tip] if tip >= 0 else u[1]
        ahead = 2.0 * speed - before if before == before else 0.0
        before = speed
        parts = 1
        for at in (speed, 0.0 if ahead * speed <= 0.0 else ahead):
            pace = min(int(math.log2(max(abs(at) / SLOWEST_TIP, 1.0))), ranges - 1)
            met[pace] += 1
            if met[pace] == due[pace]:
                due[pace] = max(2.0 * due[pace], AGAIN)
                _copy(n, z, z1)
                if tip >= 0:
                    z1[tip] = at
                else:
                    u[1] = at
                found[pace] = max(
                    found[pace],
                    _parts(n, q, t, p, z1, u, mode, dU, tip, slope, totals, T1, total, period),
                )
            parts = max(parts, int(found[pace]))
        parts *= finer
        for part in range(parts):
            since, end, events = part * period / parts, (part + 1) * period / parts, 0
            between = True  # whether a switch may turn, and back, between the two ends
            while True:
                h = end - since
                _advance(
                    n, q, t, p, z, T, pieces, changes, columns, r, order, w, count, sample, since,
                    h, mode, u, dU, first, f, slope, total, totals, z1, T1,
                )  # fmt: skip
                if s == 0 or events == EVENTS:
                    break
                coil_course(pieces, changes, columns, r, order, w, count, q, sample, since, u, dU)
                switch(t + since, z, p, u, mode, T, dU, first, g, dg, G)
                coil_course(pieces, changes, columns, r, order, w, count, q, sample, end, u, dU)
                switch(t + end, z1, p, u, mode, T1, dU, f, g1, dg1, G)
                turning, share, high, at_high = -1, 1.0, 1.0, 0.0
                for k in range(s):
                    end_of, at_end = 1.0, g1[k]
                    if between and at_end >= 0.0:
                        end_of, at_end = _lowest(g[k], h * dg[k], g1[k], h * dg1[k])
                    if at_end < 0.0:
                        here = end_of * max(g[k], 0.0) / max(g[k] - at_end, 1e-300)
                        if g[k] <= 0.0:
                            here = 0.0
                        if turning < 0 or here < share:
                            turning, share, high, at_high = k, here, end_of, at_end
                if turning < 0:
                    break
                # Regula falsi (Illinois) for the share of the part at which the switch turns.
                low, at_low = 0.0, max(g[turning], 0.0)
                between = high == 1.0
                if not between:  # the cubic is a guess: it is looked whether the switch turns there
                    share = high
                for _ in range(LOCATING):
                    _advance(
                        n, q, t, p, z, T, pieces, changes, columns, r, order, w, count, sample,
                        since, share * h, mode, u, dU, first, f, slope, total, totals, z1, T1,
                    )  # fmt: skip
                    turns = since + share * h
                    coil_course(
                        pieces, changes, columns, r, order, w, count, q, sample, turns, u, dU
                    )
                    rate(t + turns, z1, p, u, mode, T1, dU, after, slope)
                    switch(t + turns, z1, p, u, mode, T1, dU, after, g1, dg1, G)
                    if not between:
                        if g1[turning] >= 0.0:
                            break
                        between = True
                    if abs(g1[turning]) <= 1e-9 * abs(dg1[turning]) * h or at_low <= 0.0:
                        break
                    if g1[turning] < 0.0:
                        high, at_high, at_low = share, g1[turning], 0.5 * at_low
                    else:
                        low, at_low, at_high = share, g1[turning], 0.5 * at_high
                    share = low + (high - low) * at_low / (at_low - at_high)
                if not between:
                    continue
                mode[turning] = 1.0 - mode[turning]
                rate(t + since + share * h, z1, p, u, mode, T1, dU, f, slope)
                # A switch that another has turned turns when that does: a tip that goes back at
                # once.
                if g[turning] >= 0.0:
                    speed = dg1[turning]
                    for j in range(q):
                        later[j] = G[turning * q + j] / speed if abs(speed) > 1e-300 else 0.0
                for i in range(n):
                    z[i] = z1[i]
                    for j in range(q):
                        T[i * q + j] = T1[i * q + j] + (f[i] - after[i]) * later[j]
                since += share * h
                events += 1
                if end - since <= 1e-12 * period:
                    _copy(n, z, z1)
                    _copy(n * q, T, T1)
                    break
            z, z1 = z1, z
            T, T1 = T1, T
        _forget(n * q, T)
        for i in range(n):
            if not abs(z[i]) < 1e6:
                for j in range(sample + 1, samples):
                    answer[j] = math.nan
                for j in range((sample + 1) * q, samples * q):
                    sensitivity[j] = math.nan
                return
