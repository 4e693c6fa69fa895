"""A model's generated functions as an integrator calls them: by name, linked later.

All take (t, z, p, u, mode, T, dU, ...): time, states, values and numbers prepared from them, (u,
u', u'', the second input), switches, tangents of the n states and of u: n and 3 rows of q columns
one after the other, so that a compiler knows where all of them lie. Further arguments are filled;
the coil's course u is its position, or its force where that is the input.
"""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, TypeAlias

import llvmlite.binding as llvm
from numba import types

from tissue_probe.physics.pointers import Pointer

Numbers: TypeAlias = "Pointer[float]"
_F8, _P = types.float64, types.CPointer(types.float64)
_AT = (_F8, *6 * [_P])

#: The functions that are linked later, with a model's.
LINKED = ("rate", "output", "switch")
# Numba links compiled code at once; there they only have to be found.
for _name in LINKED:
    llvm.add_symbol(_name, ctypes.cast(ctypes.pythonapi.Py_FatalError, ctypes.c_void_p).value)

if TYPE_CHECKING:

    def rate(
        t: float, z: Numbers, p: Numbers, u: Numbers, mode: Numbers, T: Numbers, dU: Numbers,
        f: Numbers, slope: Numbers,
    ) -> None:  # fmt: skip
        """Fill f = z' and its derivatives dT along T."""

    def output(
        t: float, z: Numbers, p: Numbers, u: Numbers, mode: Numbers, T: Numbers, dU: Numbers,
        slope: Numbers,
    ) -> float:  # fmt: skip
        """Return the output; fill its derivatives."""

    def switch(
        t: float, z: Numbers, p: Numbers, u: Numbers, mode: Numbers, T: Numbers, dU: Numbers,
        f: Numbers, g: Numbers, g_rate: Numbers, slope: Numbers,
    ) -> None:  # fmt: skip
        """Of f, fill g, which stays positive while a switch stays as it is, g', and dg."""

else:
    rate = types.ExternalFunction("rate", types.void(*_AT, _P, _P))
    output = types.ExternalFunction("output", types.float64(*_AT, _P))
    switch = types.ExternalFunction("switch", types.void(*_AT, _P, _P, _P, _P))
