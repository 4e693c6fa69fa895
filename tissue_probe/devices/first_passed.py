"""Which limit a sample passes first, in Numba's Python.

What belongs here: the search through a block of samples.
What does not: what limits are, and what is said of one that was passed (``limits``).

Never imported: this text is the module of which ``machine_code`` makes machine code.
"""

import math

from numba import carray, cfunc

from tissue_probe.devices.limits import (
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
    VALUE,
)

_P = "CPointer(float64)"


@cfunc(f"int32({_P}, {_P}, {_P}, int32, {_P}, {_P})", error_model="numpy")
def first_passed(position, force, command, count, state, bounds):
    """Return which limit a sample passed first, NONE if none did.

    ``state`` is carried from block to block: force and position of the last sample, least and
    largest command since the position changed, mean square of the current, samples unknown; and
    where a limit was passed, by which value.
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
    ) = carray(bounds, 12)
    for n in range(count):
        if force[n] <= low or force[n] >= high:
            state[VALUE] = force[n]
            return SATURATION
        if abs(force[n]) > force_limit:
            state[VALUE] = force[n]
            return FORCE
        step = force[n] - state[LAST_FORCE]
        if abs(step) > step_limit:
            state[VALUE] = step
            return RATE
        state[LAST_FORCE] = force[n]
        if abs(position[n]) > travel:
            state[VALUE] = position[n]
            return TRAVEL
        if abs(command[n]) > voltage:
            state[VALUE] = command[n]
            return COMMAND
        if abs(gain * command[n]) > current:
            state[VALUE] = gain * command[n]
            return CURRENT
        # The coil warms up and cools down with one time constant.
        state[HEAT] = keep * state[HEAT] + (1.0 - keep) * (gain * command[n]) ** 2
        if state[HEAT] > square:
            state[VALUE] = math.sqrt(state[HEAT])
            return HEATING
        if position[n] != state[POSITION]:  # NaN, too, is no standstill
            state[POSITION] = position[n]
            state[LOW] = state[HIGH] = command[n]
        state[LOW] = min(state[LOW], command[n])
        state[HIGH] = max(state[HIGH], command[n])
        if state[HIGH] - state[LOW] > stuck:
            state[VALUE] = state[HIGH] - state[LOW]
            return STUCK
        known = math.isfinite(force[n]) and math.isfinite(position[n])
        state[SINCE_KNOWN] = 0.0 if known else state[SINCE_KNOWN] + 1.0
        if state[SINCE_KNOWN] > stale * (1.0 + 1e-9):
            state[VALUE] = state[SINCE_KNOWN]
            return UNKNOWN
    return NONE
