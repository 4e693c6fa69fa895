"""Pointers in Numba's Python: Numba takes half the time that it takes for arrays.

Contents: how functions that work on pointers are compiled, and a pointer to later elements.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeVar

from numba import njit, types
from numba.extending import intrinsic

_FunctionT = TypeVar("_FunctionT", bound=Callable[..., object])

#: For ``cfunc``, of an integrator of a model: arrays, sizes, sample period, time of first sample.
RUN_TYPE = types.void(
    types.CPointer(types.CPointer(types.float64)), types.CPointer(types.int64),
    types.float64, types.float64,
)  # fmt: skip


_T = TypeVar("_T")


def compile_inner(function: _FunctionT) -> _FunctionT:
    """Compile a function that compiled code alone calls, so that Python needs no way in."""
    return _compile(function, fastmath=False)


def compile_fused(function: _FunctionT) -> _FunctionT:
    """Do as ``compile_inner``; a product and a sum may be one instruction, rounded once."""
    return _compile(function, fastmath={"contract"})


def _compile(function: _FunctionT, fastmath: bool | set[str]) -> _FunctionT:
    # Numba's own types lack the two options by which no wrapper is made.
    compiled: _FunctionT = njit(  # type: ignore[call-overload]
        function,
        error_model="numpy",
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
        fastmath=fastmath,
    )
    return compiled


class Pointer(Protocol[_T]):
    """Elements in memory, of which only the code that counts them knows how many there are."""

    def __getitem__(self, place: int, /) -> _T:
        """Read an element."""

    def __setitem__(self, place: int, value: _T, /) -> None:
        """Write an element."""


if TYPE_CHECKING:

    def further(pointer: Pointer[_T], count: int) -> Pointer[_T]:
        """Return a pointer to the element so many places later."""

else:

    @intrinsic
    def further(typing, pointer, count):
        """Return a pointer to the element so many places later."""

        def generate(context, builder, signature, arguments):
            return builder.gep(arguments[0], [arguments[1]])

        return pointer(pointer, types.int64), generate
