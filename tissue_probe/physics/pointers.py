"""Pointers in Numba's Python: Numba takes half the time that it takes for arrays.

Contents: how functions that work on pointers are compiled, and a pointer to later elements.
"""

from numba import types
from numba.extending import intrinsic

#: For ``njit``: the function is called by compiled code only.
OPTIONS = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
#: For ``cfunc``, of an integrator of a model: arrays, sizes, sample period, time of first sample.
RUN = types.void(
    types.CPointer(types.CPointer(types.float64)), types.CPointer(types.int64),
    types.float64, types.float64,
)  # fmt: skip


@intrinsic
def further(typing, pointer, count):
    """Return a pointer to the element so many places later."""

    def generate(context, builder, signature, arguments):
        return builder.gep(arguments[0], [arguments[1]])

    return pointer(pointer, types.int64), generate
