"""Integration of the tip's motion: classical Runge-Kutta, with every change of mode located in time.

What belongs here: steps and events. What does not: the equations (``tip``, ``tissue``).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.tip import (
    BRANCHES,
    ENGAGED,
    POSITION,
    SLIDING,
    TOUCHING,
    cell_force,
    ended,
    rates,
    switch,
)
from tissue_probe.challenge.trajectory import Trajectory
from tissue_probe.signals import FloatArray

RATE = 40_000  # Hz
SAMPLE_RATE = 2_000  # Hz
BISECTIONS = 30  # of a step of 25 us: events are located to 2e-14 s
EVENTS = 20  # at most in one step, should a mode chatter


def move(specimen: Specimen, trajectory: Trajectory, rate: int = RATE) -> FloatArray:
    """Return the force of the load cell's spring [N] at ``rate``, what was before the record included.

    F = k0 (u - x), positive in compression; none where the coil is in the gap of the play. Motion
    begins with tissue and tip at rest, ``lead`` before the first sample.

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
    """
    before = round(trajectory.lead * rate)
    steps = before + round(trajectory.duration * rate)
    half_steps = (np.arange(2 * steps + 1) - 2 * before) / (2.0 * rate)
    u, u_rate = trajectory(half_steps)
    return _integrate(specimen.record(), half_steps[0], 1.0 / rate, u, u_rate)


@njit(cache=True, nogil=True, error_model="numpy")
def _integrate(p, start, period, u, u_rate):
    steps = (u.size - 1) // 2
    force = np.empty(steps)
    state = np.zeros(BRANCHES + p.branches)
    modes = np.zeros(3, np.int64)
    modes[TOUCHING] = 1
    modes[ENGAGED] = 0 if p.play != 0.0 else 1
    trial, stage = np.empty_like(state), np.empty_like(state)
    slopes = np.empty((4, state.size))
    for step in range(steps):
        n = 2 * step
        stretch = u[n] - state[POSITION] - modes[ENGAGED] * p.play
        force[step] = p.load_cell_stiffness * stretch if modes[ENGAGED] else 0.0
        time, coil, coil_rate = start + step * period, u[n : n + 3], u_rate[n : n + 3]
        _advance(p, time, period, coil, coil_rate, state, modes, trial, stage, slopes)
    return force


@njit(cache=True, nogil=True, error_model="numpy")
def _advance(p, time, period, u, u_rate, state, modes, trial, stage, slopes):
    """Advance all states by one period, stopping at every event."""
    done = 0.0
    for _ in range(EVENTS):
        left = 1.0 - done
        mode = _try(p, time, period, done, left, u, u_rate, state, modes, trial, stage, slopes)
        if mode < 0:
            break
        low, high = 0.0, left
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            found = _try(
                p, time, period, done, middle, u, u_rate, state, modes, trial, stage, slopes
            )
            if found < 0:
                low = middle
            else:
                high, mode = middle, found
        _try(p, time, period, done, high, u, u_rate, state, modes, trial, stage, slopes)
        state[:] = trial
        done += high
        switch(p, time + done * period, _at(u, done), _at(u_rate, done), state, modes, mode)
    else:
        _try(p, time, period, done, 1.0 - done, u, u_rate, state, modes, trial, stage, slopes)
    state[:] = trial


@njit(cache=True, nogil=True, error_model="numpy")
def _try(p, time, period, done, share, u, u_rate, state, modes, trial, stage, slopes):
    """Step by a share of the period from ``done`` on into ``trial``; return the mode that ended."""
    h = share * period
    for s in range(4):
        part = 0.0 if s == 0 else (1.0 if s == 3 else 0.5)
        if s == 0:
            stage[:] = state
        else:
            for n in range(state.size):
                stage[n] = state[n] + part * h * slopes[s - 1, n]
        at = done + part * share
        rates(p, time + at * period, _at(u, at), _at(u_rate, at), stage, modes, slopes[s])
    for n in range(state.size):
        total = slopes[0, n] + 2.0 * (slopes[1, n] + slopes[2, n]) + slopes[3, n]
        trial[n] = state[n] + h / 6.0 * total
    end = done + share
    return ended(p, time + end * period, _at(u, end), _at(u_rate, end), trial, modes)


@njit(cache=True, nogil=True, error_model="numpy")
def _at(values, share):
    """Parabola through a step's start, middle and end; exact at these, where most calls are."""
    if share == 0.0:
        return values[0]
    if share == 0.5:
        return values[1]
    if share == 1.0:
        return values[2]
    return (
        values[0] * (1.0 - share) * (1.0 - 2.0 * share)
        + values[1] * 4.0 * share * (1.0 - share)
        + values[2] * share * (2.0 * share - 1.0)
    )
