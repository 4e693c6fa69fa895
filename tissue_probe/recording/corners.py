"""A table of the corners of a polygon.

What belongs here: its columns. What does not: what the polygon is for (``mapping.polygon``).
"""

from __future__ import annotations

import numpy as np

from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import FloatArray


def read_corners(columns: Columns) -> FloatArray:
    """Return x and y of each corner [m], shape (n, 2).

    Raises
    ------
    RecordingError
        If a column is missing, or one holds no numbers.
    """
    names = ("x", "y")
    columns.require(names)
    loaded = columns.read(list(names)).columns
    for name, values in zip(names, loaded, strict=True):
        if values.dtype.kind not in "fiu":
            raise RecordingError(f"{columns.path}: column {name} holds no numbers")
    return np.column_stack([values.astype(np.float64) for values in loaded])
