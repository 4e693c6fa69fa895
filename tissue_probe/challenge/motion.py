"""Integration of the tip's motion: classical Runge-Kutta, every change of mode located in time.

Contents: steps and events.
"""

from __future__ import annotations

from functools import lru_cache
from typing import cast

import numpy as np
from numba import njit

from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.tip import (
    BRANCHES,
    ENGAGED,
    POSITION,
    TOUCHING,
    find_ended_mode,
    rates,
    remember,
    switch,
)
from tissue_probe.challenge.trajectory import Trajectory
from tissue_probe.signals import FloatArray, IntArray

MOTION_RATE = 40_000
"""Steps of the integration a second [Hz]."""

BISECTIONS = 30  # of a step of 25 us: events are located to 2e-14 s
SWITCHES_IN_STEP = 20  # at most in one step, should a mode chatter
TRIAL, STAGE, SLOPES = 0, 1, 2  # rows of the working memory


@lru_cache(maxsize=4)
def move(specimen: Specimen, trajectory: Trajectory, rate: int = MOTION_RATE) -> FloatArray:
    """Return the force of the load cell's spring [N] at ``rate``, the lead included.

    F = k0 (u - x), positive in compression; none where the coil is in the gap of the play. Motion
    begins with tissue and tip at rest, ``trajectory.lead`` before the first sample.

    Parameters
    ----------
    specimen : Specimen
        Rig, tissue and effects.
    trajectory : Trajectory
        What the coil does, evaluated at every stage of the integration.
    rate : int
        Steps a second [Hz].

    Returns
    -------
    array, shape ((lead + duration) * rate,)
        Read-only. The last few are remembered.
    """
    u, u_rate = trajectory.sample_motion(2 * rate)
    start = -trajectory.before(2 * rate) / (2.0 * rate)
    # Compiled code takes the record by reference: it has the fields of a specimen.
    record = cast(Specimen, specimen.record())
    force = _integrate(record, start, 1.0 / rate, u, u_rate)
    force.flags.writeable = False
    return force


@njit(cache=True, nogil=True, error_model="numpy")
def _integrate(
    p: Specimen, start: float, period: float, u: FloatArray, u_rate: FloatArray
) -> FloatArray:
    steps = u.size // 2
    force = np.empty(steps)
    state = np.zeros(BRANCHES + p.branches + p.sliders)
    work = np.empty((SLOPES + 4, state.size))
    modes = np.zeros(3, np.int64)
    modes[TOUCHING] = 1
    modes[ENGAGED] = 0 if p.play != 0.0 else 1
    for step in range(steps):
        stretch = u[2 * step] - state[POSITION] - modes[ENGAGED] * p.play
        force[step] = p.load_cell_stiffness * stretch if modes[ENGAGED] else 0.0
        _advance(p, start, period, step, u, u_rate, state, modes, work)
        remember(p, start + (step + 1) * period, state)
    return force


@njit(cache=True, nogil=True, error_model="numpy")
def _advance(
    p: Specimen,
    start: float,
    period: float,
    step: int,
    u: FloatArray,
    u_rate: FloatArray,
    state: FloatArray,
    modes: IntArray,
    work: FloatArray,
) -> None:
    """Advance all states by one period, stopping at every event."""
    done = 0.0
    for _ in range(SWITCHES_IN_STEP):
        mode = _try(p, start, period, step, done, 1.0 - done, u, u_rate, state, modes, work)
        if mode < 0:
            break
        low, high = 0.0, 1.0 - done
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            found = _try(p, start, period, step, done, middle, u, u_rate, state, modes, work)
            if found < 0:
                low = middle
            else:
                high, mode = middle, found
        _try(p, start, period, step, done, high, u, u_rate, state, modes, work)
        state[:] = work[TRIAL]
        done += high
        coil, coil_rate = _at(u, step, done), _at(u_rate, step, done)
        switch(p, start + (step + done) * period, coil, coil_rate, state, modes, mode)
    else:
        _try(p, start, period, step, done, 1.0 - done, u, u_rate, state, modes, work)
    state[:] = work[TRIAL]


@njit(cache=True, nogil=True, error_model="numpy")
def _try(
    p: Specimen,
    start: float,
    period: float,
    step: int,
    done: float,
    share: float,
    u: FloatArray,
    u_rate: FloatArray,
    state: FloatArray,
    modes: IntArray,
    work: FloatArray,
) -> int:
    """Go on from ``done`` by a share of the period into ``work[TRIAL]``; return the mode ended."""
    h = share * period
    for s in range(4):
        part = 0.5 * ((s + 1) // 2)  # 0, 1/2, 1/2, 1
        for i in range(state.size):
            slope = work[SLOPES + s - 1, i] if s > 0 else 0.0
            work[STAGE, i] = state[i] + part * h * slope
        at = done + part * share
        coil, coil_rate = _at(u, step, at), _at(u_rate, step, at)
        time = start + (step + at) * period
        rates(p, time, coil, coil_rate, work[STAGE], modes, work[SLOPES + s])
    for i in range(state.size):
        total = work[SLOPES, i] + 2.0 * (work[SLOPES + 1, i] + work[SLOPES + 2, i])
        work[TRIAL, i] = state[i] + h / 6.0 * (total + work[SLOPES + 3, i])
    at = done + share
    coil, coil_rate = _at(u, step, at), _at(u_rate, step, at)
    return find_ended_mode(p, start + (step + at) * period, coil, coil_rate, work[TRIAL], modes)


@njit(cache=True, nogil=True, error_model="numpy")
def _at(values: FloatArray, step: int, share: float) -> float:
    """Parabola through a step's start, middle and end; exact at these, where most calls are."""
    first, middle, last = values[2 * step], values[2 * step + 1], values[2 * step + 2]
    if share == 0.0:
        return float(first)
    if share == 0.5:
        return float(middle)
    if share == 1.0:
        return float(last)
    return float(
        first * (1.0 - share) * (1.0 - 2.0 * share)
        + middle * 4.0 * share * (1.0 - share)
        + last * share * (2.0 * share - 1.0)
    )
