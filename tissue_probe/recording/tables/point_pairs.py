"""A table of point pairs: places in the map's frame, and the same in another one.

Contents: its columns.
"""

from __future__ import annotations

from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.tables.quantity_columns import read_quantities
from tissue_probe.recording.units import POSITION_UNITS
from tissue_probe.signals import FloatArray

PAIR_COLUMNS, PAIR_HEIGHTS = ("x", "y", "X", "Y"), ("z", "Z")


def read_pairs(columns: Columns) -> dict[str, FloatArray]:
    """Return x, y, X, Y [m] of each pair by name, and z, Z where the table has them.

    Raises
    ------
    RecordingError
        If a needed column is missing, or one holds no numbers, or there is z without Z.
    """
    units = dict.fromkeys((*PAIR_COLUMNS, *PAIR_HEIGHTS), POSITION_UNITS)
    found = read_quantities(columns, units, PAIR_COLUMNS, any_case=False)
    if "z" in found and "Z" not in found:
        raise RecordingError(f"{columns.path} has a column z, but no Z: give both, or Z, or none")
    return found
