"""A table of point pairs: places in the map's frame, and the same in another one.

What belongs here: its columns. What does not: the motion between the frames
(``mapping.registration``).
"""

from __future__ import annotations

import numpy as np

from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import FloatArray

NEEDED, OPTIONAL = ("x", "y", "X", "Y"), ("z", "Z")


def read_pairs(columns: Columns) -> dict[str, FloatArray]:
    """Return x, y, X, Y [m] of each pair by name, and z, Z where the table has them.

    Raises
    ------
    RecordingError
        If a needed column is missing, or one holds no numbers, or there is z without Z.
    """
    columns.require(NEEDED)
    names = [*NEEDED, *(name for name in OPTIONAL if name in columns.names)]
    if "z" in names and "Z" not in names:
        raise RecordingError(f"{columns.path} has a column z, but no Z: give both, or Z, or none")
    found = {}
    for name, values in zip(names, columns.read(names).columns, strict=True):
        if values.dtype.kind not in "fiu":
            raise RecordingError(f"{columns.path}: column {name} holds no numbers")
        found[name] = values.astype(np.float64)
    return found
