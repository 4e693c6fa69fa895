"""Kalman's filter for samples with a chain of errors and a memory of them, compiled.

Contents: two loops over the samples.

The state is the errors from some samples ahead to as many behind, then their effect on the last few
samples, the latest first.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy")
def gains(chain, taps, memory, variance, beside, used):  # type: ignore[no-untyped-def]
    """Return Kalman's gains and the innovations' deviations, of samples that feel a chain.

    The last of each row of gains is that of the effect on the sample itself. See ``Shaken``.
    """
    n, size, kept = chain.shape[0], taps.size, memory.size
    near, whole = size // 2, size + kept
    felt = np.concatenate((taps, memory))
    covariance = np.zeros((whole, whole))
    gains, deviations = np.zeros((n, whole + 1)), np.full(n, np.inf)
    for t in range(-near, n):
        covariance = _onward(covariance, chain, t + near, size)
        if t < 0:
            continue
        seen = covariance @ felt
        own = felt @ seen + beside
        left = 1.0
        if used[t]:
            spread = own + variance
            gains[t, :whole] = seen / spread
            gains[t, whole] = own / spread
            deviations[t] = np.sqrt(spread)
            left = variance / spread
            covariance -= np.outer(gains[t, :whole], seen)
        if kept:
            covariance = _remember_sample(covariance, seen * left, own * left, size)
    return gains, deviations


@njit(cache=True, nogil=True, error_model="numpy")
def _onward(covariance, chain, to, size):  # type: ignore[no-untyped-def]
    """Return the covariance one sample later; behind the last sample nothing new is known."""
    moved = covariance.copy()
    moved[1:size, 1:size] = covariance[: size - 1, : size - 1]
    moved[1:size, size:] = covariance[: size - 1, size:]
    moved[size:, 1:size] = covariance[size:, : size - 1]
    moved[0, :] = 0.0
    moved[:, 0] = 0.0
    if to < chain.shape[0]:
        weights = np.zeros(covariance.shape[0])
        weights[:3] = chain[to, :3]
        with_before = covariance @ weights
        moved[0, 1:size] = with_before[: size - 1]
        moved[1:size, 0] = with_before[: size - 1]
        moved[0, size:] = with_before[size:]
        moved[size:, 0] = with_before[size:]
        moved[0, 0] = weights @ with_before + chain[to, 3] ** 2
    return moved


@njit(cache=True, nogil=True, error_model="numpy")
def _remember_sample(covariance, with_felt, felt, size):  # type: ignore[no-untyped-def]
    """Return the covariance with a sample's own effect as the latest that is remembered."""
    moved = covariance.copy()
    moved[size + 1 :, size + 1 :] = covariance[size:-1, size:-1]
    moved[:size, size + 1 :] = covariance[:size, size:-1]
    moved[size + 1 :, :size] = covariance[size:-1, :size]
    moved[size, :size] = with_felt[:size]
    moved[:size, size] = with_felt[:size]
    moved[size, size + 1 :] = with_felt[size:-1]
    moved[size + 1 :, size] = with_felt[size:-1]
    moved[size, size] = felt
    return moved


@njit(cache=True, nogil=True, error_model="numpy")
def white(chain, taps, memory, gains, deviations, columns):  # type: ignore[no-untyped-def]
    """Return each sample of each column less its prediction from those before."""
    n, size, kept = chain.shape[0], taps.size, memory.size
    near, whole = size // 2, size + kept
    new = np.zeros_like(columns)
    state = np.zeros(whole)
    # Loops over numbers: slices of arrays would be made anew for each sample of each column.
    for column in range(columns.shape[1]):
        state[:] = 0.0
        for t in range(-near, n):
            for i in range(size - 1, 0, -1):
                state[i] = state[i - 1]
            to = t + near
            state[0] = 0.0
            if to < n:
                state[0] = (
                    chain[to, 0] * state[1] + chain[to, 1] * state[2] + chain[to, 2] * state[3]
                )
            if t < 0:
                continue
            felt = 0.0
            for i in range(size):
                felt += taps[i] * state[i]
            for i in range(kept):
                felt += memory[i] * state[size + i]
            if np.isfinite(deviations[t]):
                rest = columns[t, column] - felt
                new[t, column] = rest / deviations[t]
                for i in range(whole):
                    state[i] += gains[t, i] * rest
                felt += gains[t, whole] * rest
            if kept:
                for i in range(whole - 1, size, -1):
                    state[i] = state[i - 1]
                state[size] = felt
    return new
