"""A model's generated functions as an integrator calls them: by name, linked later.

All take (t, z, p, u, mode, T, dU, ...): time, states, values and numbers prepared from them, (u,
u', u'', the second input), switches, tangents of the n states and of u: n and 3 rows of q columns
one after the other, so that a compiler knows where all of them lie. Further arguments are filled;
the coil's course u is its position, or its force where that is the input.
"""

import ctypes

import llvmlite.binding as llvm
from numba import types

_F8, _P = types.float64, types.CPointer(types.float64)
_AT = (_F8, *6 * [_P])

#: The functions that are linked later, with a model's.
LINKED = ("rate", "output", "switch")
# Numba links compiled code at once; there they only have to be found.
for _name in LINKED:
    llvm.add_symbol(_name, ctypes.cast(ctypes.pythonapi.Py_FatalError, ctypes.c_void_p).value)

#: Fills f = z' and its derivatives dT along T.
rate = types.ExternalFunction("rate", types.void(*_AT, _P, _P))
#: Returns the output; fills its derivatives.
output = types.ExternalFunction("output", types.float64(*_AT, _P))
#: Of f, fills g, which stays positive while a switch stays as it is, g', and the derivatives of g.
switch = types.ExternalFunction("switch", types.void(*_AT, _P, _P, _P, _P))
