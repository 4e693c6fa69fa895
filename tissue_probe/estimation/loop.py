# ruff: noqa: F821
"""The loop around every Kalman filter: input history, missing samples, bounds, status.

This text becomes part of each generated kernel module, which supplies ``start``, ``reopen``,
``predict``, ``output``, ``update`` and ``cap``, all from symbols, and the names in capitals: places
in ``constants`` and in ``memory``. All that a filter knows is in ``memory``, so that cutting
the stream into blocks of any size cannot change a bit of the estimates.
"""

import math

from numba import njit


@njit(cache=True, nogil=True)
def run(constants, memory, position, force, estimates):
    """Filter consecutive samples; fill ``estimates`` (11, n); return how many were missing."""
    missing = 0
    for sample in range(position.size):
        innovation = normalized = math.nan
        if math.isfinite(position[sample]):
            advance(constants, memory, position[sample])
            predicted, variance = output(constants, memory)
            memory[PREDICTED] = predicted
            innovation = force[sample] - predicted
            normalized = innovation * innovation / variance
        elif memory[PRIMED] > 0.0:
            reopen(constants, memory)
        if math.isfinite(normalized):
            update(constants, memory, innovation, variance)
            keep_sound(constants, memory)
        else:
            innovation = normalized = math.nan
            missing += 1
        record(constants, memory, estimates, sample)
        estimates[8, sample] = innovation
        estimates[9, sample] = normalized
    return missing


@njit(cache=True, nogil=True)
def advance(constants, memory, position):
    """Take in the coil's position and, from the second sample on, predict.

    The cubic of the exact step needs u[t-3..t]. After a start it has fewer points, and the missing
    ones are extrapolated by the straight line, then the parabola through those there are.
    """
    history = memory[HISTORY : HISTORY + 4]
    history[1:] = history[:3].copy()
    history[0] = position
    primed = memory[PRIMED]
    memory[PRIMED] = min(primed + 1.0, 4.0)
    if primed == 0.0:
        memory[PREDICTED] = 0.0
        return
    if primed == 1.0:
        history[2] = 2.0 * history[1] - history[0]
    if primed <= 2.0:
        history[3] = 3.0 * history[2] - 3.0 * history[1] + history[0]
    predict(constants, memory)
    keep_sound(constants, memory)


@njit(cache=True, nogil=True)
def keep_sound(constants, memory):
    """Hold estimates within their bounds and variances between their floor and their prior.

    Without a cap the covariance of a fading filter grows for ever in a direction that is not
    excited. Where numbers overflowed nothing learnt is left to keep: the filter starts again.
    """
    total = 0.0
    for index in range(HISTORY):
        total += memory[index]
    if not math.isfinite(total):
        start(constants, memory)
        return
    exceeds = False
    for state in range(STATES):
        memory[state] = min(max(memory[state], constants[LOWER + state]), constants[UPPER + state])
        prior = constants[PRIOR_VARIANCE + state]
        variance = memory[DIAGONAL[state]]
        if variance < FLOOR * prior:
            memory[DIAGONAL[state]] = FLOOR * prior
        exceeds |= variance > prior
    if exceeds:
        cap(constants, memory)


@njit(cache=True, nogil=True)
def record(constants, memory, estimates, sample):
    """Write down what is known after a sample."""
    stiffness = memory[STIFFNESS]
    damping = memory[DAMPING]
    stiffness_variance = memory[DIAGONAL[STIFFNESS]]
    damping_variance = memory[DIAGONAL[DAMPING]]
    trace = 0.0
    for state in range(STATES):
        trace += memory[DIAGONAL[state]]
    estimates[0, sample] = stiffness
    estimates[1, sample] = damping
    estimates[2, sample] = trace
    estimates[3, sample] = stiffness_variance
    estimates[4, sample] = damping_variance
    estimates[5, sample] = memory[STIFFNESS_DAMPING]
    estimates[6, sample] = memory[OFFSET] if OFFSET >= 0 else 0.0
    estimates[7, sample] = memory[PREDICTED]
    estimates[10, sample] = status(
        constants, stiffness, damping, stiffness_variance, damping_variance
    )


@njit(cache=True, nogil=True)
def status(constants, stiffness, damping, stiffness_variance, damping_variance):
    """Return 2 (NO_CONTACT) or 1 (CONVERGED), each only where two standard deviations prove it."""
    sd = math.sqrt(stiffness_variance)
    if stiffness + 2.0 * sd < constants[CONTACT_STIFFNESS]:
        return 2.0
    known = 2.0 * sd <= 0.05 * abs(stiffness)
    known &= 2.0 * math.sqrt(damping_variance) <= 0.05 * abs(damping)
    return 1.0 if known else 0.0
