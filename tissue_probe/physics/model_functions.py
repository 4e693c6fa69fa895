"""A model's generated functions as what integrates the model calls them: by name, linked later.

All take (t, z, p, u, mode, T, dU, ...): time, states, values and what is prepared of them,
(u, u', u''), switches, tangents of the n states and of u: n and 3 rows of q columns one after the
other, so that a compiler knows where all of them lie. What follows is filled; the coil's course u
is its position, or its force where that is what drives.
"""

import ctypes

import llvmlite.binding as llvm
from numba import njit, types

_F8, _P = types.float64, types.CPointer(types.float64)
_AT = (_F8, *6 * [_P])

#: As ``response_code`` generates them: pointers, for C.
RATE = types.void(*_AT, _P, _P)
OUTPUT = types.float64(*_AT, _P)
SWITCH = types.void(*_AT, _P, _P, _P, _P)
PREPARE = types.void(_P)  # fills what follows the values in p
#: Of values, measured position and force: fills the states' start, then their relaxation rates.
BEGIN = types.void(_P, _F8, _F8, _P)
#: Of times, measured positions and values: fills true positions and their changes by values.
POSITION = types.void(types.int64, _P, _P, _P, _P, _P)

#: What is linked later, with a model's functions.
LINKED = ("rate", "output", "switch")
# Numba links at once what it compiles; there they only have to be found.
for _name in LINKED:
    llvm.add_symbol(_name, ctypes.cast(ctypes.pythonapi.Py_FatalError, ctypes.c_void_p).value)

_rate = types.ExternalFunction("rate", RATE)
_output = types.ExternalFunction("output", OUTPUT)
_switch = types.ExternalFunction("switch", SWITCH)


@njit(error_model="numpy")
def rate(t, z, p, u, mode, T, dU, f, dT):
    """Fill z' and its derivatives along T."""
    _rate(
        t, z.ctypes, p.ctypes, u.ctypes, mode.ctypes, T.ctypes, dU.ctypes, f.ctypes, dT.ctypes
    )  # fmt: skip


@njit(error_model="numpy")
def output(t, z, p, u, mode, T, dU, dF):
    """Return what is measured; fill its derivatives."""
    return _output(t, z.ctypes, p.ctypes, u.ctypes, mode.ctypes, T.ctypes, dU.ctypes, dF.ctypes)


@njit(error_model="numpy")
def switch(t, z, p, u, mode, T, dU, f, g, dg, G):
    """Fill g, which stays positive while a switch stays as it is, g' for z' = f, and G = dg."""
    _switch(
        t, z.ctypes, p.ctypes, u.ctypes, mode.ctypes, T.ctypes, dU.ctypes, f.ctypes, g.ctypes,
        dg.ctypes, G.ctypes,
    )  # fmt: skip
