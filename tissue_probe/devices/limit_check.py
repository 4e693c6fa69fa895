"""The check of samples against limits, compiled: the driver makes it for every block."""

from __future__ import annotations

import math

import numba

from tissue_probe.devices.limit_codes import (
    COMMAND,
    CURRENT,
    FORCE,
    HEAT,
    HEATING,
    HIGH,
    LAST_FORCE,
    LOW,
    NONE,
    POSITION,
    RATE,
    SATURATION,
    SINCE_KNOWN,
    STUCK,
    TRAVEL,
    UNKNOWN,
)
from tissue_probe.signals import FloatArray


@numba.njit(cache=True)
def first_passed(
    position: FloatArray,
    force: FloatArray,
    command: FloatArray,
    state: FloatArray,
    bounds: tuple[float, ...],
) -> tuple[int, float]:
    """Return which limit a sample passed first, NONE if none did, and by which value.

    ``state`` is carried from block to block: force and position of the last sample, least and
    largest command since the position changed, mean square of the current, samples unknown.
    """
    (
        low,
        high,
        force_limit,
        step_limit,
        travel,
        voltage,
        current,
        square,
        stuck,
        stale,
        gain,
        keep,
    ) = bounds
    for n in range(force.size):
        if force[n] <= low or force[n] >= high:
            return SATURATION, force[n]
        if abs(force[n]) > force_limit:
            return FORCE, force[n]
        step = force[n] - state[LAST_FORCE]
        if abs(step) > step_limit:
            return RATE, step
        state[LAST_FORCE] = force[n]
        if abs(position[n]) > travel:
            return TRAVEL, position[n]
        if abs(command[n]) > voltage:
            return COMMAND, command[n]
        if abs(gain * command[n]) > current:
            return CURRENT, gain * command[n]
        # The coil warms up and cools down with one time constant.
        state[HEAT] = keep * state[HEAT] + (1.0 - keep) * (gain * command[n]) ** 2
        if state[HEAT] > square:
            return HEATING, math.sqrt(state[HEAT])
        if position[n] != state[POSITION]:  # NaN, too, is no standstill
            state[POSITION] = position[n]
            state[LOW] = state[HIGH] = command[n]
        state[LOW] = min(state[LOW], command[n])
        state[HIGH] = max(state[HIGH], command[n])
        if state[HIGH] - state[LOW] > stuck:
            return STUCK, state[HIGH] - state[LOW]
        known = math.isfinite(force[n]) and math.isfinite(position[n])
        state[SINCE_KNOWN] = 0.0 if known else state[SINCE_KNOWN] + 1.0
        if state[SINCE_KNOWN] > stale * (1.0 + 1e-9):
            return UNKNOWN, state[SINCE_KNOWN]
    return NONE, 0.0
