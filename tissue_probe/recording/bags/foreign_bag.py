"""Position and force out of the bags of other recorders, on one even grid of time.

Contents: putting two topics together.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from tissue_probe.recording.bags.bag import Bag
from tissue_probe.recording.bags.topic_field import (
    FORCE_FIELDS,
    INPUT2_FIELDS,
    POSITION_FIELDS,
    FieldValues,
    candidates,
    read_field,
)
from tissue_probe.recording.clocks.clocks import ClockedTimes
from tissue_probe.recording.clocks.even_grid import BRIDGED, even_grid, interpolate, sample_blocks
from tissue_probe.recording.clocks.fresh_values import fresh_values
from tissue_probe.recording.clocks.position_rate import tell_slow_position
from tissue_probe.recording.clocks.two_clocks import by_one_clock
from tissue_probe.recording.columns.source import Progress
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout
from tissue_probe.recording.units import FORCE_UNITS, POSITION_UNITS, unit_size
from tissue_probe.signals import (
    NANOSECONDS,
    Channel,
    FloatArray,
    IntArray,
    OwnTimes,
    Recording,
    SampleBlock,
)


def read_foreign_bag(
    bag: Bag, path: Path, layout: Layout, progress: Progress = lambda share: None
) -> tuple[Recording, tuple[str, ...]]:
    """Read a force and a position topic; return the recording, and notes on its changes.

    Samples are those of the force, at the stamps in its headers; the position is brought to them by
    a cubic spline. Faults of the clocks are told, and made good or refused (``two_clocks``). In SI
    unless stated otherwise, as ROS has it (REP 103).

    Parameters
    ----------
    bag : Bag
        Of ROS 1 or 2.
    path : path
        Its name in messages.
    layout : Layout
        Names the fields and the force's polarity.
    progress : callable
        Told the share that is read, from 0 to 1.

    Raises
    ------
    RecordingError
        If a topic or field is not there, the polarity is not stated, the two never overlap, or
        their times cannot be told; says which parameter settles it.
    """
    if layout.force is None or layout.position is None or layout.force_polarity is None:
        raise RecordingError(_what_to_state(bag, path, layout))
    fields = FORCE_FIELDS | POSITION_FIELDS
    force = read_field(bag, path, layout.force, fields, progress, (0.0, 0.5))
    position = read_field(bag, path, layout.position, POSITION_FIELDS, progress, (0.5, 1.0))
    f_clock, u_clock, cuts, notes = by_one_clock(
        path, force, position, layout.clock, layout.sample_rate
    )
    second = _second(bag, path, layout, force, f_clock.stamped)
    u_unit = layout.position_sign * unit_size(layout.position_unit or "m", POSITION_UNITS)
    f_unit = layout.force_sign * unit_size(layout.force_unit or "N", FORCE_UNITS)
    # Coarse stamps are known to half a step; a step that was taken out is, to its own error.
    doubts = max(f_clock.tick, u_clock.tick) / 2.0, f_clock.doubt, u_clock.doubt
    doubt = float(np.hypot.reduce(doubts)) / NANOSECONDS
    f_clock, f, told_force = _fresh(force, f_clock)
    u_clock, u, told_position = _fresh(position, u_clock)
    notes = [*force.notes, *position.notes, *notes, *told_force, *told_position]
    f_name, u_name, origin = force.name, position.name, int(f_clock.times[0])
    parts = list(_parts(f_clock.times, u_clock.times, cuts))
    del force, position  # of a long bag, hundreds of megabytes
    f_times, u_times = _seconds(f_clock.times, origin), _seconds(u_clock.times, origin)
    del f_clock, u_clock
    blocks: list[SampleBlock] = []
    rates, slow, noises, even = [], [], [], True
    taken: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]] = []
    for part_f, part_u in parts:
        f_time, u_time = f_times[part_f], u_times[part_u]
        if f_time.size < 2 or u_time.size < 2:
            notes.append(
                f"{f_time.size} samples of the force between two steps of a clock are left out"
            )
            continue
        grid = even_grid(f_time, f"{path}, {f_name}", BRIDGED)
        moved, felt = u[part_u] * u_unit, f[part_f] * f_unit
        positions = [interpolate(u_time, moved, span.times) for span in grid.spans]
        forces = [grid.values(span, f_time, felt) for span in grid.spans]
        even = even and grid.even
        taken.append((f_time, u_time, moved, felt))
        blocks += _numbered_on(blocks, sample_blocks(grid, origin, positions, forces))
        rates.append((1.0 / grid.period, (u_time.size - 1) / (u_time[-1] - u_time[0])))
        notes += grid.notes
        noises.append(grid.noise(f_time))
        longest = int(np.argmax([span.times.size for span in grid.spans]))
        slow.append(tell_slow_position(u_name, u_time, grid.spans[longest].times, forces[longest]))
    if not any(np.isfinite(block.position).any() for block in blocks):
        raise RecordingError(f"{path}: {f_name} and {u_name} were never recorded at the same time")
    f_rate, u_rate = rates[0]
    read = (
        f"{path}: force is {f_name} at {f_rate:.6g} Hz, position {u_name} "
        f"at {u_rate:.6g} Hz, brought to the times of the force by a cubic spline"
    )
    told_slow = [said for said in slow if said][:1]
    own = None if even else _own_times(origin, taken)
    recording = Recording(tuple(blocks), time_doubt=doubt, noise=noises[0], own=own, input2=second)
    return recording, (read, *notes, *told_slow)


def _second(
    bag: Bag, path: Path, layout: Layout, force: FieldValues, stamped: bool
) -> Channel | None:
    """Return the further channel that is asked for, by the clock of the force."""
    if layout.input2 is None:
        return None
    found = read_field(bag, path, layout.input2, INPUT2_FIELDS)
    _, clock, _, _ = by_one_clock(path, force, found, layout.clock, layout.sample_rate)
    if clock.stamped != stamped:
        raise RecordingError(
            f"{path}: {found.name} has no stamps by which the force goes: read all by the "
            "recorder's clock (`clock` recorder)"
        )
    values, origin = found.values[clock.rows], int(clock.times[0])
    if unknown := int(np.count_nonzero(~np.isfinite(values))):
        raise RecordingError(
            f"{path}: {found.name} has no number in {unknown} of {values.size} messages: a "
            "channel that drives must be known throughout, so give another by `input2`"
        )
    return Channel(found.name, origin, _seconds(clock.times, origin), values)


def _own_times(
    origin: int, taken: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]]
) -> OwnTimes:
    """Return a force at its own times, with the position there.

    ``taken`` has, of each part, times of force and position, position and force.
    """
    parts = [(at, interpolate(times, moved, at), felt) for at, times, moved, felt in taken]
    return OwnTimes(origin, *map(np.concatenate, zip(*parts, strict=True)))


def _what_to_state(bag: Bag, path: Path, layout: Layout) -> str:
    parameters = []
    for role, name, fields in (
        ("force", layout.force, FORCE_FIELDS),
        ("position", layout.position, POSITION_FIELDS),
    ):
        if name is None:
            found = candidates(bag, fields)
            topics = ", ".join(topic.name for topic in bag.topics)
            there = ", ".join(found) or f"none of a usual type; the topics are {topics or 'none'}"
            parameters.append(f"`{role}` /TOPIC.FIELD (there is {there})")
    if layout.force_polarity is None:
        parameters.append("`force_polarity` (compression or tension: which forces are positive)")
    return f"{path} is no recording of this suite, so state {' and '.join(parameters)}"


def _fresh(field: FieldValues, clock: ClockedTimes) -> tuple[ClockedTimes, FloatArray, list[str]]:
    """Return times and values of a channel, without the old ones that it repeats."""
    values = field.values[clock.rows]
    fresh = fresh_values(values)
    if fresh.all():
        return clock, values, []
    kept = np.flatnonzero(fresh)
    share = values.size / kept.size
    rate = NANOSECONDS * (kept.size - 1) / float(clock.times[kept[-1]] - clock.times[kept[0]])
    said = (
        f"{field.name} repeats old values, each {share:.3g} times: {kept.size} fresh ones, at "
        f"{rate:.4g} Hz, of {values.size} are used"
    )
    rows = kept if isinstance(clock.rows, slice) else clock.rows[fresh]
    thinned = replace(clock, times=clock.times[fresh], rows=rows)
    return thinned, values[fresh], [said]


def _parts(
    force_times: IntArray, position_times: IntArray, cuts: IntArray
) -> Iterator[tuple[slice, slice]]:
    """Yield the rows of force and position between steps of a clock."""
    ends = [
        [0, *np.searchsorted(times, cuts), times.size] for times in (force_times, position_times)
    ]
    for f, u in zip(*(pairwise(each) for each in ends), strict=True):
        if f[0] < f[1]:
            yield slice(*f), slice(*u)


def _numbered_on(before: list[SampleBlock], blocks: Iterator[SampleBlock]) -> Iterator[SampleBlock]:
    """Return the blocks numbered on from those before, less one: they are not to be joined."""
    begin = before[-1].sequence + len(before[-1]) + 1 if before else 0
    return (replace(block, sequence=begin + block.sequence) for block in blocks)


def _seconds(times: IntArray, origin: int) -> FloatArray:
    return (times - origin) / NANOSECONDS
