"""Columns named by their quantity, in SI or in the unit of their header.

Contents: finding and reading them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.units import split_unit
from tissue_probe.signals import FloatArray

Units = Mapping[str, float]
"""The value of each unit in SI."""


def find_quantities(
    columns: Columns, wanted: Mapping[str, Units], *, any_case: bool = True
) -> dict[str, tuple[str, float]]:
    """Return the column of each quantity that a table has, and the size of its unit in SI.

    ``x`` may be called ``x``, ``x_mm``, ``x [mm]`` or ``x (mm)``, and with ``any_case`` ``X`` too.

    Parameters
    ----------
    columns : Columns
        The table.
    wanted : mapping
        Units that each quantity may have, by its name; none where it has no unit.
    any_case : bool
        Whether capital letters mean the same.

    Raises
    ------
    RecordingError
        If two columns may be one quantity.
    """
    found = {}
    for quantity, units in wanted.items():
        stems = {name: split_unit(name, units)[0].strip() for name in columns.names}
        for same in (str, str.casefold) if any_case else (str,):
            meant = [name for name, stem in stems.items() if same(stem) == same(quantity)]
            chosen = [quantity] if quantity in meant else meant
            if len(chosen) > 1:
                raise RecordingError(
                    f"{columns.path} has several columns {quantity}: {', '.join(chosen)}; leave "
                    "one of them"
                )
            if chosen:
                unit = columns.units.get(chosen[0]) or split_unit(chosen[0], units)[1]
                found[quantity] = (chosen[0], units.get(unit or "", 1.0))
                break
    return found


def read_quantities(
    columns: Columns,
    wanted: Mapping[str, Units],
    needed: Collection[str],
    *,
    any_case: bool = True,
) -> dict[str, FloatArray]:
    """Return the columns of quantities by these names, in SI, those that the table has.

    Raises
    ------
    RecordingError
        If a needed one is missing, one holds no numbers, or two columns may be one.
    """
    found = find_quantities(columns, wanted, any_case=any_case)
    columns.require([name for name in needed if name not in found])
    loaded = columns.read([name for name, _ in found.values()]).columns
    read = {}
    for (quantity, (name, size)), values in zip(found.items(), loaded, strict=True):
        if values.dtype.kind not in "fiu":
            raise RecordingError(f"{columns.path}: column {name} holds no numbers")
        read[quantity] = size * values.astype(np.float64)
    return read
