"""Samples from files with named columns, in any units and polarity, as an even recording.

What belongs here: from columns to samples, and what is said of it.
What does not: file formats (``columns``), which column is what (``roles``), times (``times``),
uneven ones (``even_grid``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from tissue_probe.recording.columns.open_columns import open_columns
from tissue_probe.recording.columns.source import Columns, Progress
from tissue_probe.recording.columns.stamps import with_stamps
from tissue_probe.recording.counters import unwrapped
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.even_grid import (
    BRIDGED,
    EvenGrid,
    consecutive,
    even_grid,
    interpolate,
    sample_blocks,
)
from tissue_probe.recording.fresh_values import REPEATED, drives, fresh_values
from tissue_probe.recording.layout import Layout
from tissue_probe.recording.roles import Roles, roles
from tissue_probe.recording.times import Times, times
from tissue_probe.signals import (
    NANOSECONDS,
    FloatArray,
    OwnTimes,
    PalpationSite,
    Phase,
    Recording,
    begin_anew,
)

EXPORTED = ("sequence", "site")
"""What ``tables.write_samples`` tells besides; there is no site where the probe dwells at none."""

PLACES = ("site_x", "site_y", "site_z")
"""Where the site is [m]."""


OWN_ROWS = 0.5
"""Share of a channel's rows in which the other is known, below which each has rows of its own: by
gaps alone most of a recording would be missing."""

FEWEST_ROWS = 12
"""Values of a channel that is brought to the times of the other: the inspection asks for
as many."""

JOINED = (
    "position and force stand in rows of their own; the position is brought to the times of the "
    "force by a cubic spline"
)


def read_table(
    path: Path, layout: Layout, progress: Progress = lambda share: None
) -> tuple[Recording, tuple[str, ...]]:
    """Read a file of columns as ``read_columns`` does; text, spreadsheet, TDMS, MATLAB and so on.

    Raises
    ------
    RecordingError
        As ``read_columns``, or if the file cannot be read.
    """
    return read_columns(open_columns(path), layout, progress)


def read_columns(
    source: Columns, layout: Layout, progress: Progress = lambda share: None
) -> tuple[Recording, tuple[str, ...]]:
    """Make a recording of columns; return it, and notes on what was done.

    Columns that are not named are those with usual names (``roles``). Where times jitter the
    samples are resampled, where they have gaps a new block begins; where a channel repeats old
    values only the fresh ones are taken. The sites of an exported scan are read.

    Parameters
    ----------
    source : Columns
        Of a file, or from memory.
    layout : Layout
        Where the signals are, in which units and polarity.
    progress : callable
        Told the share that is read, from 0 to 1.

    Raises
    ------
    RecordingError
        If a column cannot be read or is not found, a unit or the polarity is not known, or
        something is stated that only bags have.
    """
    path = source.path
    _refuse_statements_on_bags(path, layout)
    if layout.time is None and layout.sample_rate is None:
        source = with_stamps(source)
    found = roles(source, layout)
    columns, told, place = source.read(list(found.names.values()), progress)
    signals = dict(zip(found.names, columns, strict=True))
    del columns
    said = [*source.told, *found.told, *told]
    time = _times(source, found, layout, signals)
    said += time.told
    position = _position(source, found, layout, signals, time, said)
    force = _scaled(source, found, "force", signals.pop("force"), layout.force_sign)
    for role, values in (("position", position), ("force", force)):
        if not np.isfinite(values).any():
            raise RecordingError(
                f"{path}: column {found.names[role]}, the {role}, has no number in any row; give "
                f"another by `{role}`"
            )
    if (late := _later(source, found)) and "time" not in found.names:
        said.append(
            f"the force's channel begins {1e3 * late:.4g} ms after the position's; the position is "
            "brought to the times of the force by a cubic spline"
        )
        position = interpolate(time.seconds, position, time.seconds + late, reach=BRIDGED)
    notes = [f"{path}: {'; '.join(said)}"] if said else []
    sites = tuple(_sites(source, time)) if set(EXPORTED) <= set(source.names) else ()
    known = np.isfinite(time.seconds)
    taken = [known]
    if not known.all():
        if not known.any():
            raise RecordingError(f"{path}: column {found.names['time']} tells no time in any row")
        left_out = np.count_nonzero(~known)
        notes.append(f"{path}: {left_out} rows without a time left out")
        time = time._replace(seconds=time.seconds[known])
        position, force = position[known], force[known]
    if (own_rows := _rows_of_their_own(time.seconds, position, force)) is not None:
        notes.append(f"{path}: {JOINED}")
        moved = np.isfinite(position)
        position = interpolate(
            time.seconds[moved], position[moved], time.seconds[own_rows], reach=BRIDGED
        )
        taken.append(own_rows)
        time, force = time._replace(seconds=time.seconds[own_rows]), force[own_rows]
    fresh, doubt = _fresh(path, time.seconds, position, force, notes)
    if fresh is not None:
        taken.append(fresh)
        time = time._replace(seconds=time.seconds[fresh])
        position, force = position[fresh], force[fresh]
    if "time" in found.names or fresh is not None:
        grid = even_grid(
            time.seconds, str(path), BRIDGED, lambda row: place(_among_all(row, taken))
        )
    else:
        grid = consecutive(force.size, 1.0 / (found.sample_rate or 1.0))
    notes += grid.notes
    own = None if grid.even else OwnTimes(time.origin, time.seconds, position, force)
    spans = [_values(grid, time.seconds, position)]
    del position, signals
    spans.append(_values(grid, time.seconds, force))
    del force
    blocks = tuple(sample_blocks(grid, time.origin, *spans))
    noise = grid.noise(time.seconds)
    return Recording(blocks, sites, time_doubt=doubt, noise=noise, own=own), tuple(notes)


def _rows_of_their_own(
    time: FloatArray, position: FloatArray, force: FloatArray
) -> np.ndarray | None:
    """Return the rows of the force, where position and force stand in rows of their own.

    So do two topics that were merged by their times, and two channels of two rates. Times that do
    not ascend are told as such elsewhere.
    """
    moved, felt = np.isfinite(position), np.isfinite(force)
    both = np.count_nonzero(moved & felt)
    apart = both < OWN_ROWS * max(np.count_nonzero(moved), np.count_nonzero(felt))
    enough = min(np.count_nonzero(moved), np.count_nonzero(felt)) >= FEWEST_ROWS
    return felt if apart and enough and bool(np.all(np.diff(time) >= 0.0)) else None


def _later(source: Columns, found: Roles) -> float:
    """Return by how much the force's channel begins after the position's, as the file says [s]."""
    position, force = (source.starts.get(found.names[role]) for role in ("position", "force"))
    return 0.0 if position is None or force is None else force - position


def _refuse_statements_on_bags(path: Path, layout: Layout) -> None:
    """Refuse what is stated of a bag's topics and clocks: a table has neither."""
    for name, stated in (("samples_topic", layout.samples_topic), ("clock", layout.clock)):
        if stated is not None:
            raise RecordingError(
                f"{path} is a table, which has no topics and one clock: leave out `{name}`"
            )


def _among_all(row: int, taken: Sequence[np.ndarray]) -> int:
    """Return which of a file's rows one of those is that were taken, step after step."""
    for each in reversed(taken):
        row = int(np.flatnonzero(each)[row])
    return row


def _values(grid: EvenGrid, time: FloatArray, column: FloatArray) -> list[FloatArray]:
    return [grid.values(span, time, column) for span in grid.spans]


def _times(source: Columns, found: Roles, layout: Layout, signals: dict[str, np.ndarray]) -> Times:
    if "time" not in found.names:
        return Times(0, np.arange(signals["force"].size) / (found.sample_rate or 1.0))
    certain = layout.time_unit is not None or set(EXPORTED) <= set(source.names)
    column = signals.pop("time")
    name = found.names["time"]
    if column.dtype == object:
        raise RecordingError(f"{source.path}: column {name} has no numbers: it is text")
    return times(column, name, found.units.get("time"), certain, str(source.path))


def _position(
    source: Columns,
    found: Roles,
    layout: Layout,
    signals: dict[str, np.ndarray],
    time: Times,
    said: list[str],
) -> FloatArray:
    column = signals.pop("position")
    if column.dtype.kind in "iuf":
        column, bits = unwrapped(column)
        if bits:
            name = found.names["position"]
            said.append(
                f"{name} is a counter of {bits} bits that began again, and is counted on; its "
                "zero may lie whole turns away"
            )
    values = _scaled(source, found, "position", column, layout.position_sign)
    if not found.velocity:
        return values
    said.append(
        f"{found.names['position']} is a velocity, integrated to the position, which so has no "
        "zero of its own"
    )
    known = np.isfinite(values) & np.isfinite(time.seconds)
    whole = np.full(values.size, np.nan)
    from scipy.integrate import cumulative_trapezoid  # only where a velocity is given

    whole[known] = cumulative_trapezoid(values[known], time.seconds[known], initial=0.0)
    return whole


def _scaled(
    source: Columns, found: Roles, role: str, column: np.ndarray, sign: float
) -> FloatArray:
    """Return a column in SI, positive in compression; NaN where not known."""
    if column.dtype.kind not in "iufb":
        raise RecordingError(
            f"{source.path}: column {found.names[role]} has no numbers, but times or words"
        )
    size = sign * found.size(role)
    if column.dtype == np.float64 and column.flags.writeable:
        if size != 1.0:
            column *= size
        return column
    return size * column.astype(np.float64)


def _fresh(
    path: Path, time: FloatArray, position: FloatArray, force: FloatArray, notes: list[str]
) -> tuple[np.ndarray | None, float]:
    """Return the rows to take where a channel repeats old values, and how old they may be [s]."""
    kept, doubt = None, 0.0
    for name, values, other in (("position", position, force), ("force", force, position)):
        if np.count_nonzero(values[1:] == values[:-1]) < REPEATED * values.size:
            continue
        fresh = fresh_values(values)
        count = np.count_nonzero(fresh)
        if count == fresh.size or drives(values, fresh, other):
            continue
        held = float(np.median(np.diff(time[fresh])))
        notes.append(
            f"{path}: the {name} repeats old values: of {fresh.size} rows the {count} that bring a "
            f"new one are taken, {1.0 / held:.4g} a second; how old these are is not told, up to "
            f"{1e3 * held:.3g} ms, so the damping is known to the stiffness times that only"
        )
        if kept is None or count < np.count_nonzero(kept):
            kept = fresh
        doubt = max(doubt, held)
    return kept, doubt


def _sites(source: Columns, time: Times) -> Iterator[PalpationSite]:
    """Yield an announcement wherever an exported scan dwells at another site, or at none."""
    told = [name for name in PLACES if name in source.names]
    sites, *places = (column.astype(np.float64) for column in source.read(["site", *told]).columns)
    dwells = np.isfinite(sites)
    numbers = np.where(dwells, sites, -1.0).astype(int)
    # The column tells each row's site, after a silence too, which would end an announced dwell.
    gap = np.rint(np.diff(time.seconds) * NANOSECONDS).astype(np.int64)
    usual = np.concatenate([gap[:1], gap[:-1]])
    told = np.diff(numbers, prepend=-1) != 0
    told[1:] |= begin_anew(gap, usual, np.zeros_like(gap)) & dwells[1:]
    for row in np.flatnonzero(told):
        phase = Phase.DWELL if dwells[row] else Phase.LIFTED
        stamp = time.origin + round(time.seconds[row] * NANOSECONDS)
        place = tuple(float(column[row]) for column in places) if places else (np.nan,) * 3
        yield PalpationSite(stamp, int(numbers[row]), place, phase)
