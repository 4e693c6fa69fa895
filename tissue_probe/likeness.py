"""Whether two results say the same: by content, arrays and values that are not known among it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


class Alike:
    """A result that equals another one of the same content, such as its copy in another process."""

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return are_alike(self, other)

    __hash__ = None  # type: ignore[assignment]


def are_alike(one: Any, other: Any) -> bool:
    """Whether two values are the same through and through; an unknown value (NaN) equals itself."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        known = one.dtype.kind in "fcmM"
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=known)
    if is_dataclass(one) and not isinstance(one, type):
        return all(are_alike(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, Mapping):
        return list(one) == list(other) and all(are_alike(one[key], other[key]) for key in one)
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(are_alike, one, other))
    return bool(one == other or (one != one and other != other))
