"""Kalman's filter for samples that feel a few neighbours of a chain of errors, compiled.

What belongs here: two loops over the samples. What does not: the chain and the taps (``shaken``).
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy")
def gains(chain, taps, variance, used):  # type: ignore[no-untyped-def]
    """Return Kalman's gains and the deviations of what is new, of samples that feel a chain.

    The state is the errors from some samples ahead to as many behind. See ``Shaken``.
    """
    n, size = chain.shape[0], taps.size
    near = size // 2
    covariance = np.zeros((size, size))
    gains, deviations = np.zeros((n, size)), np.full(n, np.inf)
    for t in range(-near, n):
        covariance = _onward(covariance, chain, t + near)
        if t < 0 or not used[t]:
            continue
        seen = covariance @ taps
        spread = taps @ seen + variance
        gains[t] = seen / spread
        deviations[t] = np.sqrt(spread)
        covariance -= np.outer(gains[t], seen)
    return gains, deviations


@njit(cache=True, nogil=True, error_model="numpy")
def _onward(covariance, chain, to):  # type: ignore[no-untyped-def]
    """Return the covariance one sample later; behind the last sample nothing new is known."""
    size = covariance.shape[0]
    moved = np.zeros((size, size))
    moved[1:, 1:] = covariance[:-1, :-1]
    if to < chain.shape[0]:
        weights = np.zeros(size)
        weights[:3] = chain[to, :3]
        with_before = covariance @ weights
        moved[0, 1:] = with_before[:-1]
        moved[1:, 0] = with_before[:-1]
        moved[0, 0] = weights @ with_before + chain[to, 3] ** 2
    return moved


@njit(cache=True, nogil=True, error_model="numpy")
def white(chain, taps, gains, deviations, columns):  # type: ignore[no-untyped-def]
    """Return what each sample of each column has beside what those before tell."""
    n, size = gains.shape
    near = size // 2
    new = np.zeros_like(columns)
    for column in range(columns.shape[1]):
        state = np.zeros(size)
        for t in range(-near, n):
            state[1:] = state[:-1].copy()
            to = t + near
            state[0] = 0.0
            if to < n:
                state[0] = (
                    chain[to, 0] * state[1] + chain[to, 1] * state[2] + chain[to, 2] * state[3]
                )
            if t < 0 or not np.isfinite(deviations[t]):
                continue
            rest = columns[t, column] - taps @ state
            new[t, column] = rest / deviations[t]
            state += gains[t] * rest
    return new
