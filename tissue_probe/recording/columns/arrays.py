"""Names for the columns of arrays: vectors by their name, a matrix's columns as ``name[:,2]``.

Contents: which arrays are columns.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

NUMBER_KINDS = "fiubM"
"""Kinds of NumPy arrays that are columns: floats, whole numbers, truths, dates."""

MOST_COLUMNS = 64
"""Most columns of a matrix; one with more is a picture or a table on its side."""


def array_columns(name: str, shape: tuple[int, ...], dtype: np.dtype) -> Iterator[str]:
    """Yield the names of the columns of an array; none where it is no column.

    Parameters
    ----------
    name : str
        Of the array.
    shape, dtype
        Its own. Fields of a structured array are named ``name.field``, or ``field`` if it has no
        name; the columns of a matrix ``name[:,0]`` and so on.
    """
    if dtype.names:
        for each in dtype.names:
            yield from array_columns(f"{name}.{each}" if name else each, shape, dtype[each])
        return
    if dtype.kind not in NUMBER_KINDS or dtype.subdtype:
        return
    long = [size for size in shape if size != 1]
    if len(long) == 1 and len(shape) <= 2:
        yield name
    elif len(long) == 2 and len(shape) == 2 and shape[1] <= MOST_COLUMNS and shape[0] > 1:
        yield from (f"{name}[:,{number}]" for number in range(shape[1]))


def array_column(array: np.ndarray, column: str) -> np.ndarray:
    """Return the column of an array that ``array_columns`` so named, of shape (n,)."""
    if array.dtype.names:
        for field in array.dtype.names:
            if column == field or column.endswith(f".{field}"):
                return array[field].ravel()
    if array.ndim == 2 and 1 not in array.shape:
        return np.ascontiguousarray(array[:, int(column.rpartition("[:,")[2][:-1])])
    return array.ravel()
