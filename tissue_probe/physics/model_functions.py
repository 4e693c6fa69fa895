"""A model's generated functions as what integrates the model calls them: by name, linked later.

All take (t, z, p, u, mode, T, dU, ...): time, states, values and what is prepared of them,
(u, u', u'', the second input), switches, tangents of the n states and of u: n and 3 rows of q
columns one after the other, so that a compiler knows where all of them lie. What follows is filled;
the coil's course u is its position, or its force where that is what drives.
"""

import ctypes

import llvmlite.binding as llvm
from numba import types

_F8, _P = types.float64, types.CPointer(types.float64)
_AT = (_F8, *6 * [_P])

#: What is linked later, with a model's functions.
LINKED = ("rate", "output", "switch")
# Numba links at once what it compiles; there they only have to be found.
for _name in LINKED:
    llvm.add_symbol(_name, ctypes.cast(ctypes.pythonapi.Py_FatalError, ctypes.c_void_p).value)

#: Fills f = z' and its derivatives dT along T.
rate = types.ExternalFunction("rate", types.void(*_AT, _P, _P))
#: Returns what is measured; fills its derivatives.
output = types.ExternalFunction("output", types.float64(*_AT, _P))
#: Of f, fills g, which stays positive while a switch stays as it is, g', and the derivatives of g.
switch = types.ExternalFunction("switch", types.void(*_AT, _P, _P, _P, _P))
