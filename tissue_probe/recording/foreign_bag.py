"""Position and force out of the bags of other recorders, on one even grid of time.

What belongs here: putting two topics together, and what is known of their clocks.
What does not: the fields' values (``topic_field``), resampling (``even_grid``).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tissue_probe.recording.bag import Bag
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.even_grid import BRIDGED, even_grid, interpolate, sample_blocks
from tissue_probe.recording.layout import Layout
from tissue_probe.recording.topic_field import (
    FORCE_FIELDS,
    POSITION_FIELDS,
    FieldValues,
    candidates,
    read_field,
)
from tissue_probe.recording.units import FORCE_UNITS, POSITION_UNITS, unit_size
from tissue_probe.signals import NANOSECONDS, FloatArray, IntArray, Recording

CLOCKS_APART = 1e-3
"""Difference between the delays of two topics that is worth telling [s]."""

_POSSIBLE_DELAY = 1.0  # s; no message takes longer to the recorder: more is a clock of its own


def read_foreign_bag(bag: Bag, path: Path, layout: Layout) -> tuple[Recording, tuple[str, ...]]:
    """Read a force and a position topic; return the recording, and notes on what was done.

    Samples are those of the force, at the stamps in its headers; the position is brought to them by
    a cubic spline. If one has no stamps, or their clocks are more than a second apart, both go by
    the times they were recorded. In SI unless stated otherwise, as ROS has it (REP 103).

    Parameters
    ----------
    bag : Bag
        Of ROS 1 or 2.
    path : path
        What to call it in messages.
    layout : Layout
        Names the fields and the force's polarity.

    Raises
    ------
    RecordingError
        If a topic or field is not there, the polarity is not stated, or the two never overlap.
    """
    if layout.force is None or layout.position is None or layout.force_polarity is None:
        raise RecordingError(_what_to_state(bag, path, layout))
    if layout.sample_rate is not None:
        raise RecordingError(f"{path} is a bag, which has times: leave out --sample-rate")
    force = read_field(bag, path, layout.force, FORCE_FIELDS | POSITION_FIELDS)
    position = read_field(bag, path, layout.position, POSITION_FIELDS)
    force_times, position_times, notes = _times(force, position)
    force_times, f = _ascending(force_times, force.values)
    position_times, u = _ascending(position_times, position.values)
    origin = int(force_times[0])
    f_time, u_time = (_seconds(times, origin) for times in (force_times, position_times))
    grid = even_grid(f_time, f"{path}, {force.name}", BRIDGED)
    u = u * layout.position_sign * unit_size(layout.position_unit or "m", POSITION_UNITS)
    f = f * layout.force_sign * unit_size(layout.force_unit or "N", FORCE_UNITS)
    positions = [interpolate(u_time, u, span.times) for span in grid.spans]
    if not any(np.isfinite(part).any() for part in positions):
        raise RecordingError(
            f"{path}: {force.name} and {position.name} were never recorded at the same time"
        )
    forces = [grid.values(span, f_time, f) for span in grid.spans]
    recording = Recording(tuple(sample_blocks(grid, origin, positions, forces)))
    rate = (u_time.size - 1) / (u_time[-1] - u_time[0]) if u_time.size > 1 else 0.0
    read = (
        f"{path}: force is {force.name} at {1.0 / grid.period:.6g} Hz, position {position.name} "
        f"at {rate:.6g} Hz, brought to the times of the force by a cubic spline"
    )
    return recording, (read, *notes, *grid.notes)


def _what_to_state(bag: Bag, path: Path, layout: Layout) -> str:
    options = []
    for role, name, fields in (
        ("force", layout.force, FORCE_FIELDS),
        ("position", layout.position, POSITION_FIELDS),
    ):
        if name is None:
            found = candidates(bag, fields)
            topics = ", ".join(topic.name for topic in bag.topics)
            there = ", ".join(found) or f"none of a usual type; the topics are {topics or 'none'}"
            options.append(f"--{role} /TOPIC.FIELD (there is {there})")
    if layout.force_polarity is None:
        options.append("--force-polarity (compression or tension: which forces are positive)")
    return f"{path} is no recording of this suite, so state {' and '.join(options)}"


def _times(force: FieldValues, position: FieldValues) -> tuple[IntArray, IntArray, list[str]]:
    """Return the times to go by, and what is to be said of the clocks."""
    for field in (force, position):
        if field.stamped is None:
            return force.logged, position.logged, [_by_log_time(f"{field.name} has no stamps")]
    assert force.stamped is not None
    assert position.stamped is not None
    force_delay, position_delay = _delay(force), _delay(position)
    apart = abs(force_delay - position_delay) / NANOSECONDS
    if apart > _POSSIBLE_DELAY:
        said = f"the clocks that stamp {force.name} and {position.name} are {apart:.6g} s apart"
        return force.logged, position.logged, [_by_log_time(said)]
    notes = []
    if apart > CLOCKS_APART:
        late, later = (1e3 * delay / NANOSECONDS for delay in (force_delay, position_delay))
        notes.append(
            f"{force.name} was recorded {late:.4g} ms after its stamps, {position.name} "
            f"{later:.4g} ms: if that is their clocks and not the way to the recorder, the signals "
            f"are {1e3 * apart:.3g} ms apart"
        )
    return force.stamped, position.stamped, notes


def _by_log_time(why: str) -> str:
    return (
        f"{why}: both signals are taken at the times they were recorded, and may be shifted by "
        "their different ways to the recorder"
    )


def _delay(field: FieldValues) -> float:
    """Return how much later than stamped the messages were recorded [ns], the median."""
    return float(np.median(field.logged - field.stamped))


def _ascending(times: IntArray, values: FloatArray) -> tuple[IntArray, FloatArray]:
    """Sort by time; of several at one time, keep the first."""
    times, first = np.unique(times, return_index=True)
    return times, values[first]


def _seconds(times: IntArray, origin: int) -> FloatArray:
    return (times - origin) / NANOSECONDS
