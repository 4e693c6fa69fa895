"""A table of the corners of a polygon.

Contents: its columns.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.tables.quantity_columns import read_quantities
from tissue_probe.recording.units import POSITION_UNITS
from tissue_probe.signals import FloatArray


def read_corners(columns: Columns) -> FloatArray:
    """Return x and y of each corner [m], shape (n, 2).

    Raises
    ------
    RecordingError
        If a column is missing, or one holds no numbers.
    """
    found = read_quantities(columns, {"x": POSITION_UNITS, "y": POSITION_UNITS}, ("x", "y"))
    return np.column_stack([found["x"], found["y"]])
