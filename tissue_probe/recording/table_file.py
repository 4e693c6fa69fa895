"""Samples from files with named columns, in any units and polarity, as an even recording.

What belongs here: which column is what, and what must be stated of it.
What does not: file formats (``columns``), uneven times (``even_grid``).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tissue_probe.recording.columns import column_names, read_columns, require_columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.even_grid import (
    BRIDGED,
    EvenGrid,
    consecutive,
    even_grid,
    sample_blocks,
)
from tissue_probe.recording.layout import Layout
from tissue_probe.recording.units import (
    FORCE_UNITS,
    POSITION_UNITS,
    TIME_UNITS,
    split_unit,
    unit_size,
)
from tissue_probe.signals import NANOSECONDS, FloatArray, PalpationSite, Phase, Recording

OWN = {"time": ("t", "time"), "position": ("u", "position"), "force": ("F", "force")}
"""What this suite calls the columns; in SI units, and positive in compression."""

EXPORTED = {"sequence", "site"}
"""What ``tissue_probe export`` tells besides; there is no site where the probe dwells at none."""

_UNITS = {"time": TIME_UNITS, "position": POSITION_UNITS, "force": FORCE_UNITS}


def read_table(path: Path, layout: Layout) -> tuple[Recording, tuple[str, ...]]:
    """Read a CSV, Parquet or MATLAB file; return the recording, and notes on what was done.

    Columns that are not named are those with the suite's own names (``t`` or ``time``, ``u`` or
    ``position``, ``F`` or ``force``), bare or with a unit. Where times jitter the samples are
    resampled, where they have gaps a new block begins. The sites of an exported scan are read, but
    for their places.

    Parameters
    ----------
    path : path
        Ends in ``.csv``, ``.parquet`` or ``.mat``.
    layout : Layout
        Where the signals are, in which units and polarity.

    Raises
    ------
    RecordingError
        If the file cannot be read, a column is not found, or a unit or the polarity is not known.
    """
    available = column_names(path)
    names = _names(path, layout, available)
    position_size, force_size = _sizes(path, layout, names)
    columns = dict(zip(names, read_columns(path, list(names.values())), strict=True))
    grid = _grid(path, layout, names, columns)
    position = layout.position_sign * position_size * columns["position"]
    force = layout.force_sign * force_size * columns["force"]
    time = columns.get("time", np.empty(0)) * _time_size(names)
    spans = [
        [grid.values(span, time, column) for span in grid.spans] for column in (position, force)
    ]
    blocks = tuple(sample_blocks(grid, 0, *spans))
    sites = _sites(path, layout, time) if EXPORTED.issubset(available) else ()
    return Recording(blocks, tuple(sites)), grid.notes


def _sites(path: Path, layout: Layout, time: FloatArray) -> Iterator[PalpationSite]:
    """Yield an announcement wherever an exported scan dwells at another site, or at none."""
    (sites,) = read_columns(path, ["site"])
    if layout.sample_rate is not None:
        time = np.arange(sites.size) / layout.sample_rate
    dwells = np.isfinite(sites)
    numbers = np.where(dwells, sites, -1.0).astype(int)
    for row in np.flatnonzero(np.diff(numbers, prepend=-1)):
        phase = Phase.DWELL if dwells[row] else Phase.LIFTED
        stamp = round(time[row] * NANOSECONDS)
        yield PalpationSite(stamp, int(numbers[row]), (np.nan, np.nan, np.nan), phase)


def _names(path: Path, layout: Layout, available: list[str]) -> dict[str, str]:
    wanted = {"time": layout.time, "position": layout.position, "force": layout.force}
    if layout.sample_rate is not None:
        del wanted["time"]
    names = {role: name or _own(role, available) for role, name in wanted.items()}
    if missing := [role for role, name in names.items() if name is None]:
        options = " ".join(f"--{role} COLUMN" for role in missing)
        rate = " (or --sample-rate HZ where there is none)" if "time" in missing else ""
        raise RecordingError(
            f"{path} does not say which column is the {' and which the '.join(missing)}: give "
            f"{options}{rate}; its columns are {', '.join(available) or 'none: it is empty'}"
        )
    named = {role: name for role, name in names.items() if name is not None}
    require_columns(path, list(named.values()), available)
    return named


def _own(role: str, available: list[str]) -> str | None:
    bare = [name for name in available if name in OWN[role]]
    with_unit = [name for name in available if split_unit(name, _UNITS[role])[0] in OWN[role]]
    return next(iter(bare + with_unit), None)


def _sizes(path: Path, layout: Layout, names: dict[str, str]) -> tuple[float, float]:
    """Return how large one of the position's and of the force's column is, in m and N."""
    sizes, missing = [], []
    for role, stated in (("position", layout.position_unit), ("force", layout.force_unit)):
        unit = stated or _unit(role, names[role])
        if unit is None:
            missing.append(f"--{role}-unit ({', '.join(_UNITS[role])} or a number)")
        else:
            sizes.append(unit_size(unit, _UNITS[role]))
    if layout.force_polarity is None and names["force"] not in OWN["force"]:
        missing.append("--force-polarity (compression or tension: which forces are positive)")
    if missing:
        raise RecordingError(
            f"{path}: the names {names['position']} and {names['force']} do not tell everything; "
            f"state {', '.join(missing)}"
        )
    return sizes[0], sizes[1]


def _unit(role: str, name: str) -> str | None:
    _, unit = split_unit(name, _UNITS[role])
    return unit or (next(iter(_UNITS[role])) if name in OWN[role] else None)


def _time_size(names: dict[str, str]) -> float:
    return TIME_UNITS[split_unit(names.get("time", ""), TIME_UNITS)[1] or "s"]


def _grid(
    path: Path, layout: Layout, names: dict[str, str], columns: dict[str, FloatArray]
) -> EvenGrid:
    if layout.sample_rate is not None:
        return consecutive(columns["force"].size, 1.0 / layout.sample_rate)
    return even_grid(columns["time"] * _time_size(names), str(path), BRIDGED)
