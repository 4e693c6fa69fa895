"""A table of sites: where tissue was felt, and how stiff it was there.

Contents: the columns of such a table.
"""

from __future__ import annotations

from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.tables.quantity_columns import find_quantities, read_quantities
from tissue_probe.recording.units import POSITION_UNITS, STIFFNESS_UNITS, TIME_UNITS
from tissue_probe.signals import FloatArray

#: Columns that a table of sites has.
SITE_COLUMNS = ("x", "y", "k")
#: These and those that it may have, each with its units.
_SITE_UNITS = {
    **dict.fromkeys(("x", "y"), POSITION_UNITS),
    **dict.fromkeys(("k", "k_sd"), STIFFNESS_UNITS),
    "z": POSITION_UNITS,
    "t": TIME_UNITS,
    "site": {},
}


def is_site_table(columns: Columns) -> bool:
    """Whether a table is one of sites: it names places and their stiffness."""
    return {"x", "y", "k"} <= set(find_quantities(columns, _SITE_UNITS))


def refuse_misnamed(columns: Columns) -> None:
    """Refuse a table that names places, and no results there.

    Raises
    ------
    RecordingError
        If it has x and y, but no k, and is no exported scan.
    """
    found = find_quantities(columns, _SITE_UNITS)
    if {"x", "y"} <= set(found) and "k" not in found and "sequence" not in columns.names:
        raise RecordingError(
            f"{columns.path} has places, but no k: a table of sites has the columns x, y [m], k "
            "and perhaps k_sd [N/m], or with another unit in the name (x_mm, k [N/mm]); "
            f"{columns.has()}; if it is a recording, state `position` and `force`"
        )


def read_sites(columns: Columns) -> dict[str, FloatArray]:
    """Return the columns of a table of sites by name, those that it has, in SI.

    Raises
    ------
    RecordingError
        If a needed column is missing, or one holds no numbers.
    """
    return read_quantities(columns, _SITE_UNITS, SITE_COLUMNS)
