"""Samples from files with named columns, in any units and polarity, as an even recording.

Contents: from columns to samples, and the notes on it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from tissue_probe.recording.clocks.counters import unwrap_counter
from tissue_probe.recording.clocks.even_grid import (
    BRIDGED,
    GAP,
    EvenGrid,
    consecutive,
    even_grid,
    sample_blocks,
)
from tissue_probe.recording.clocks.fresh_values import REPEATED, drives, fresh_values
from tissue_probe.recording.clocks.own_clocks import (
    BROUGHT,
    at_times,
    compare_clocks,
    rows_of_their_own,
)
from tissue_probe.recording.clocks.times import Times, following_on, times
from tissue_probe.recording.columns.open_columns import open_columns
from tissue_probe.recording.columns.source import Columns, Progress
from tissue_probe.recording.columns.stamps import with_stamps
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout
from tissue_probe.recording.tables.roles import Roles, roles
from tissue_probe.signals import (
    NANOSECONDS,
    Channel,
    FloatArray,
    OwnTimes,
    PalpationSite,
    Phase,
    Recording,
    begin_anew,
)

EXPORTED = ("sequence", "site")
"""Further columns of ``tables.write_samples``; there is no site where the probe dwells at none."""

PLACE_COLUMNS = ("site_x", "site_y", "site_z")
"""Where the site is [m]."""


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
    """Make a recording of columns; return it, and notes on its changes.

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
    if found.own_times:
        time, position, force, place, said = _each_by_its_clock(source, found, layout, progress)
    else:
        time, position, force, place, said = _by_one_clock(source, found, layout, progress)
    second = _second(source, found, layout, time)
    for role, values in (("position", position), ("force", force)):
        if not np.isfinite(values).any():
            raise RecordingError(
                f"{path}: column {found.names[role]}, the {role}, has no number in any row; give "
                f"another by `{role}`"
            )
    notes = [f"{path}: {'; '.join(said)}"] if said else []
    sites = tuple(_sites(source, time)) if set(EXPORTED) <= set(source.names) else ()
    known = np.isfinite(time.seconds)
    taken = [known]
    if not known.all():
        if not known.any():
            raise RecordingError(f"{path} tells no time in any row, in the column of times")
        left_out = np.count_nonzero(~known)
        notes.append(f"{path}: {left_out} rows without a time left out")
        time = time._replace(seconds=time.seconds[known])
        position, force = position[known], force[known]
    if (own_rows := rows_of_their_own(time.seconds, position, force)) is not None:
        notes.append(f"{path}: position and force stand in rows of their own; {BROUGHT}")
        position = at_times(time.seconds, position, time.seconds[own_rows])
        taken.append(own_rows)
        time, force = time._replace(seconds=time.seconds[own_rows]), force[own_rows]
    fresh, doubt = _fresh(path, time.seconds, position, force, notes)
    if fresh is not None:
        taken.append(fresh)
        time = time._replace(seconds=time.seconds[fresh])
        position, force = position[fresh], force[fresh]
    if found.timed or fresh is not None or _has_pauses(time.seconds, found):
        grid = even_grid(
            time.seconds, str(path), BRIDGED, lambda row: place(_among_all(row, taken))
        )
    else:
        grid = consecutive(force.size, 1.0 / found.sample_rates.get("force", 1.0))
    notes += grid.notes
    own = None if grid.even else OwnTimes(time.origin, time.seconds, position, force)
    spans = [_values(grid, time.seconds, position)]
    del position
    spans.append(_values(grid, time.seconds, force))
    del force
    blocks = tuple(sample_blocks(grid, time.origin, *spans))
    noise = grid.noise(time.seconds)
    recording = Recording(
        blocks,
        sites,
        time_doubt=doubt,
        noise=noise,
        own=own,
        input2=second,
        units_from=found.units_from,
    )
    return recording, tuple(notes)


Read = tuple[Times, FloatArray, FloatArray, Callable[[int], str], list[str]]
"""Times, position [m], force [N], where in the file a row is, and the changes, in phrases."""


def _by_one_clock(source: Columns, found: Roles, layout: Layout, progress: Progress) -> Read:
    """Read position and force that stand in the same rows."""
    columns, told, place, blocks, begins = source.read(list(found.names.values()), progress)
    signals = dict(zip(found.names, columns, strict=True))
    time = following_on(_times(source, found, layout, signals), blocks, begins)
    said = [*source.told, *found.told, *told, *time.told]
    position = _position(source, found, layout, signals["position"], time, said)
    force = _scale_column(source, found, "force", signals["force"], layout.force_sign)
    return time, position, force, place, said


def _each_by_its_clock(source: Columns, found: Roles, layout: Layout, progress: Progress) -> Read:
    """Read position and force of which each channel tells its own times; the force's are kept."""
    said = [*source.told, *found.told]
    own, columns = {}, {}
    for role in ("position", "force"):
        name = found.names[role]
        clock = source.clocks.get(name)
        loaded = source.read([name, clock] if clock else [name], progress)
        said += loaded.told if role == "force" else ()
        columns[role] = loaded.columns[0]
        if clock:
            told = times(loaded.columns[1], clock, source.units.get(clock), False, str(source.path))
        else:
            told = Times(
                0, _count_times(columns[role].size, loaded.blocks, found.sample_rates[role])
            )
        told = told._replace(seconds=told.seconds + source.starts.get(name, 0.0))
        own[role] = following_on(told, loaded.blocks, loaded.begins)
    said += own["force"].told
    position = _position(source, found, layout, columns["position"], own["position"], said)
    force = _scale_column(source, found, "force", columns["force"], layout.force_sign)
    seconds = own["position"].seconds + (own["position"].origin - own["force"].origin) / NANOSECONDS
    if differ := compare_clocks(seconds, own["force"].seconds):
        said.append(differ)
        position = at_times(seconds, position, own["force"].seconds)
    return own["force"], position, force, loaded.place, said


def _second(source: Columns, found: Roles, layout: Layout, time: Times) -> Channel | None:
    """Return the further channel that is asked for; of times of its own, where it has these."""
    name = layout.input2
    if name is None:
        return None
    source.require([name])
    clock = source.clocks.get(name) if found.own_times else None
    columns = source.read([name, clock] if clock else [name]).columns
    values, path = columns[0], source.path
    if clock:
        time = times(columns[1], clock, source.units.get(clock), False, str(path))
    if values.dtype.kind not in "iuf":
        raise RecordingError(f"{path}: column {name} has no numbers, but truths, times or words")
    if values.size != time.seconds.size:
        raise RecordingError(
            f"{path}: column {name} has {values.size} values for {time.seconds.size} times; give "
            "another by `input2`"
        )
    known = np.isfinite(time.seconds)
    values, seconds = values[known].astype(np.float64), time.seconds[known]
    if unknown := np.flatnonzero(~np.isfinite(values)).tolist():
        raise RecordingError(
            f"{path}: column {name} has no number in {len(unknown)} of {values.size} rows, first "
            f"at {seconds[unknown[0]]:.6g} s: a channel that drives must be known throughout, so "
            "fill it in or cut these rows out"
        )
    return Channel(name, time.origin, seconds, values)


def _has_pauses(seconds: FloatArray, found: Roles) -> bool:
    """Whether blocks of samples that have a rate do not follow each other at once."""
    period = 1.0 / found.sample_rates["force"]
    return bool(np.any(np.diff(seconds) > GAP * period))


def _count_times(count: int, blocks: Sequence[int], rate: float) -> FloatArray:
    """Return times of samples at a rate [Hz] that begin anew with each block [s]."""
    bounds = (0, *blocks, count)
    return np.concatenate([np.arange(n) for n in np.diff(bounds)]) / rate


def _refuse_statements_on_bags(path: Path, layout: Layout) -> None:
    """Refuse statements on a bag's topics and clocks: a table has neither."""
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
        return Times(0, np.arange(signals["force"].size) / found.sample_rates["force"])
    certain = layout.time_unit is not None or set(EXPORTED) <= set(source.names)
    column = signals["time"]
    name = found.names["time"]
    if column.dtype.kind not in "iufmM":
        raise RecordingError(f"{source.path}: column {name} tells no times, but truths or words")
    return times(column, name, found.units.get("time"), certain, str(source.path))


def _position(
    source: Columns,
    found: Roles,
    layout: Layout,
    column: np.ndarray,
    time: Times,
    said: list[str],
) -> FloatArray:
    if column.dtype.kind in "iuf":
        column, bits = unwrap_counter(column)
        if bits:
            name = found.names["position"]
            said.append(
                f"{name} is a counter of {bits} bits that began again, and is counted on; its "
                "zero may lie whole turns away"
            )
    values = _scale_column(source, found, "position", column, layout.position_sign)
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


def _scale_column(
    source: Columns, found: Roles, role: str, column: np.ndarray, sign: float
) -> FloatArray:
    """Return a column in SI, positive in compression; NaN where not known."""
    if column.dtype.kind not in "iuf":
        raise RecordingError(
            f"{source.path}: column {found.names[role]} has no numbers, but truths, times or words"
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
    told = [name for name in PLACE_COLUMNS if name in source.names]
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
        x, y, z = (float(column[row]) for column in places) if places else (np.nan,) * 3
        yield PalpationSite(stamp, int(numbers[row]), (x, y, z), phase)
