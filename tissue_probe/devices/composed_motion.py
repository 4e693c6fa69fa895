"""Coil, stage and a composed model integrated together, in Numba's Python.

What belongs here: the classical Runge-Kutta scheme in short steps, each divided where a switch
turns. What does not: the model's own equations, which are linked in (``physics.plant_code``);
calling it (``composed``).

Imported only where machine code of it has to be made: that takes seconds.
"""

import ctypes

import llvmlite.binding as llvm
from numba import carray, cfunc, njit, types

from tissue_probe.devices.composed import COIL, CURRENT, DEPTH, FIRST, SPEED

#: Switches within one step beyond this many are left to the next one.
EVENTS = 6
#: What is linked later, with a model's functions.
LINKED = ("rate", "switch", "output", "reaction", "begin")
# Numba links at once what it compiles; there they only have to be found.
for _name in LINKED:
    llvm.add_symbol(_name, ctypes.cast(ctypes.pythonapi.Py_FatalError, ctypes.c_void_p).value)

_F8, _P = types.float64, types.CPointer(types.float64)
_AT = (_F8, _P, _P, _F8, _F8, _P)
_rate = types.ExternalFunction("rate", types.void(*_AT, _P))
_switch = types.ExternalFunction("switch", types.void(*_AT, _P))
_output = types.ExternalFunction("output", types.float64(*_AT))
_reaction = types.ExternalFunction("reaction", types.float64(*_AT))
_begin = types.ExternalFunction("begin", types.void(_P, _F8, _F8, _P))


@njit(error_model="numpy")
def _derivative(t, y, mode, p, coil, voltage, target, filled):
    """Fill the rates of i, u, u', d and of the model's states."""
    inductance, resistance, force_constant, mass, c, s, stage_time, _ = coil
    i, u, v, d = y[CURRENT], y[COIL], y[SPEED], y[DEPTH]
    p[-3] = d
    p[-2] = (target - d) / stage_time
    filled[CURRENT] = (voltage - resistance * i - force_constant * v) / inductance
    filled[COIL] = v
    cell = _reaction(t, y[FIRST:].ctypes, p.ctypes, u, v, mode.ctypes)
    filled[SPEED] = (force_constant * i - c * v - s * u - cell) / mass
    filled[DEPTH] = p[-2]
    _rate(t, y[FIRST:].ctypes, p.ctypes, u, v, mode.ctypes, filled[FIRST:].ctypes)


@njit(error_model="numpy")
def _step(t, y, mode, p, coil, voltage, target, h, slopes, after):
    """One classical Runge-Kutta step of length h."""
    for stage in range(4):
        part = 0.0 if stage == 0 else (0.5 * h if stage < 3 else h)
        for k in range(y.size):
            after[k] = y[k]
            if stage > 0:
                after[k] += part * slopes[stage - 1, k]
        _derivative(t + part, after, mode, p, coil, voltage, target, slopes[stage])
    s1, s2, s3, s4 = slopes[0], slopes[1], slopes[2], slopes[3]
    for k in range(y.size):
        after[k] = y[k] + h / 6.0 * (s1[k] + 2.0 * s2[k] + 2.0 * s3[k] + s4[k])


@njit(error_model="numpy")
def _advance(t, y, mode, p, coil, voltage, target, h, slopes, after, conditions):
    """Move the state on by h, turning switches at the times at which they turn (by secants)."""
    before, now = conditions[0], conditions[1]
    for events in range(EVENTS + 1):
        _step(t, y, mode, p, coil, voltage, target, h, slopes, after)
        if mode.size == 0 or events == EVENTS:
            break
        p[-3] = y[DEPTH]
        _switch(t, y[FIRST:].ctypes, p.ctypes, y[COIL], y[SPEED], mode.ctypes, before.ctypes)
        first, share = -1, 1.0
        p[-3] = after[DEPTH]
        _switch(
            t + h, after[FIRST:].ctypes, p.ctypes, after[COIL], after[SPEED], mode.ctypes,
            now.ctypes,
        )  # fmt: skip
        for k in range(mode.size):
            if now[k] < 0.0:
                here = max(before[k], 0.0) / max(max(before[k], 0.0) - now[k], 1e-300)
                if first < 0 or here < share:
                    first, share = k, here
        if first < 0:
            break
        _step(t, y, mode, p, coil, voltage, target, share * h, slopes, after)
        for k in range(y.size):
            y[k] = after[k]
        mode[first] = 1.0 - mode[first]
        t += share * h
        h -= share * h
    for k in range(y.size):
        y[k] = after[k]


@njit(error_model="numpy")
def _simulate(
    y, mode, p, coil, command, target, count, period, substeps, slopes, after, rest, conditions,
    position, force,
):  # fmt: skip
    """Sample coil displacement and force, then move on by one period, for each command."""
    reach = coil[7]
    h = period / substeps
    for n in range(command.size):
        t = (count + n) * period
        p[-3] = y[DEPTH]
        p[-2] = (target - y[DEPTH]) / coil[6]
        position[n] = y[COIL]
        force[n] = _output(t, y[FIRST:].ctypes, p.ctypes, y[COIL], y[SPEED], mode.ctypes)
        if y[DEPTH] >= -1e-6:
            if p[-1] == 0.0:
                # Tissue that is touched anew has forgotten: what remembers is as after long rest.
                _begin(p.ctypes, y[COIL], force[n], rest.ctypes)
                for k in range(FIRST + 2, y.size):
                    y[k] = rest[k - FIRST]
            p[-1] = 1.0
        elif y[DEPTH] < -reach:
            p[-1] = 0.0
        for part in range(substeps):
            _advance(
                t + part * h, y, mode, p, coil, command[n], target, h, slopes, after, conditions
            )


@cfunc(types.void(types.CPointer(_P), types.CPointer(types.int64), _P, _P), error_model="numpy")
def derivative(arrays, sizes, at, filled):
    """Fill the rates of a state, with neither voltage nor stage; ``arrays`` as for ``simulate``."""
    n, s, known = carray(sizes, 3)
    mode, p, coil = carray(arrays[1], s), carray(arrays[2], known), carray(arrays[3], 8)
    _derivative(0.0, carray(at, n), mode, p, coil, 0.0, 0.0, carray(filled, n))


@cfunc(
    types.void(
        types.CPointer(_P), types.CPointer(types.int64), _P, *3 * [types.int64], _F8, _F8
    ),
    error_model="numpy",
)  # fmt: skip
def simulate(arrays, sizes, samples, number, count, substeps, target, period):
    """Take ``number`` samples, the first of which is sample ``count``.

    ``arrays`` are the state, the switches, the values, the coil's constants, and room for slopes,
    states and conditions; ``sizes`` the lengths of the first three. ``samples`` are rows of
    commands, positions and forces.
    """
    n, s, known = carray(sizes, 3)
    rows, room = carray(samples, (3, number)), carray(arrays[5], (2, n))
    _simulate(
        carray(arrays[0], n),
        carray(arrays[1], s),
        carray(arrays[2], known),
        carray(arrays[3], 8),
        rows[0],
        target,
        count,
        period,
        substeps,
        carray(arrays[4], (4, n)),
        room[0],
        room[1],
        carray(arrays[6], (2, s)),
        rows[1],
        rows[2],
    )
