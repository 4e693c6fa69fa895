"""A message through a WebSocket or a pipe: a head in JSON, and arrays as bytes.

Contents: that layout.

A message is the length of its head (4 bytes, little-endian), the head, blanks up to a multiple of
eight bytes, and the arrays one after the other, each padded likewise. The head's ``arrays`` names
them in order, each with its type (``f4``, ``f8``, ``u2``) and length.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

TYPES: dict[str, np.dtype[Any]] = {
    "f4": np.dtype("<f4"),
    "f8": np.dtype("<f8"),
    "u2": np.dtype("<u2"),
}
_ALIGNED = 8


def pack_message(head: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return a message.

    Parameters
    ----------
    head : mapping
        The values that JSON holds.
    arrays : mapping of str to array
        Each of one dimension, of a type of ``TYPES``.
    """
    parts = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    told = [[name, part.dtype.str[1:], part.size] for name, part in parts.items()]
    text = as_json({**head, "arrays": told}).encode()
    text += b" " * (-(4 + len(text)) % _ALIGNED)
    pieces = [len(text).to_bytes(4, "little"), text]
    for part in parts.values():
        data = part.astype(TYPES[part.dtype.str[1:]], copy=False).tobytes()
        pieces += [data, bytes(-len(data) % _ALIGNED)]
    return b"".join(pieces)


def unpack_message(message: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return head and arrays of a message.

    Raises
    ------
    ValueError
        If it is no such message.
    """
    size = int.from_bytes(message[:4], "little")
    head = json.loads(message[4 : 4 + size])
    at = 4 + size
    arrays: dict[str, NDArray[Any]] = {}
    for name, kind, count in head.pop("arrays"):
        arrays[name] = np.frombuffer(message, TYPES[kind], count, at)
        at += arrays[name].nbytes
        at += -at % _ALIGNED
    return head, arrays


def as_json(told: object) -> str:
    """Return JSON that every browser reads: a number that is not finite is null."""
    return json.dumps(_finite(told), allow_nan=False, separators=(",", ":"))


def _finite(told: Any) -> Any:
    if isinstance(told, float):
        return told if math.isfinite(told) else None
    if isinstance(told, np.generic):
        return _finite(told.item())
    if isinstance(told, Mapping):
        return {str(name): _finite(value) for name, value in told.items()}
    if isinstance(told, (list, tuple)):
        return [_finite(value) for value in told]
    return told
