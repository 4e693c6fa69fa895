"""A table of sites: where tissue was felt, and how stiff it was there.

What belongs here: the columns of such a table. What does not: what is made of it (``mapping``).
"""

from __future__ import annotations

import numpy as np

from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import FloatArray

#: Columns that a table of sites has, and those that it may have; m, s and N/m.
NEEDED = ("x", "y", "k", "k_sd")
OPTIONAL = ("z", "t", "site")


def is_site_table(columns: Columns) -> bool:
    """Whether a table is one of sites: it names places and their stiffness."""
    return {"x", "y", "k"} <= set(columns.names)


def read_sites(columns: Columns) -> dict[str, FloatArray]:
    """Return the columns of a table of sites by name, those that it has.

    Raises
    ------
    RecordingError
        If a needed column is missing, or one holds no numbers.
    """
    columns.require(NEEDED)
    names = [*NEEDED, *(name for name in OPTIONAL if name in columns.names)]
    loaded = columns.read(names).columns
    found = {}
    for name, values in zip(names, loaded, strict=True):
        if values.dtype.kind not in "fiu":
            raise RecordingError(f"{columns.path}: column {name} holds no numbers")
        found[name] = values.astype(np.float64)
    return found
