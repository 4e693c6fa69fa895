"""The clocks of two channels, brought together.

Contents: by which clock force and position go, and which recordings are refused.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tissue_probe.recording.bags.topic_field import FieldValues
from tissue_probe.recording.clocks.clocks import (
    SHIFT_WORTH_TELLING,
    STEP_DEVIATIONS,
    ClockedTimes,
    correct_clocks,
    onto_recorder,
    space_evenly,
    usual_step,
)
from tissue_probe.recording.clocks.even_grid import GAP
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Clock
from tissue_probe.signals import NANOSECONDS, IntArray

POSSIBLE_DELAY = 1.0
"""Longest that a message takes to the recorder [s]: a difference of more is one of clocks."""

SIMULATED = 0.01
"""Drifts larger than this are none of clocks, of which the worst are wrong by a thousandth: the
stamps are simulated or replayed time then, and right."""


MISSING = 0.05
"""Largest share of long steps in the times at which a recorder wrote: they come from the traffic,
and not from a loop that jitters."""


def by_one_clock(
    path: object,
    force: FieldValues,
    position: FieldValues,
    clock: Clock | None,
    sample_rate: float | None,
) -> tuple[ClockedTimes, ClockedTimes, IntArray, list[str]]:
    """Return the times of force and position by one clock, where it stepped, and the notes.

    Stamps count, unless one channel has none, or the two clocks are more than a second apart: then
    both go by the recorder's clock, as far as the stamps tell it. A drift against the
    recorder's that both share is taken out.

    Parameters
    ----------
    path : path
        The bag's name in messages.
    force, position : FieldValues
        The two channels.
    clock : {"stamps", "recorder"}, optional
        By which to go, instead of a choice by the stamps.
    sample_rate : float, optional
        Rate at which the force was sampled, evenly and none lost, in the place of its times [Hz].

    Raises
    ------
    RecordingError
        If the clocks drift apart, or times cannot be told; says which parameter decides.
    """
    if clock == "stamps":
        _require_stamps(path, force, position)
    if sample_rate is not None:
        force = replace(force, stamped=None)
    both = [_refine_times(path, field, clock) for field in (force, position)]
    if sample_rate is not None:
        both[0] = _at_the_rate(path, force, both[0], sample_rate)
    notes = [note for found in both for note in found.notes]
    both = _made_good_alike(path, force, position, *both)
    if sample_rate is None and not both[0].stamped:
        _refuse_irregular(
            path, force, "state `sample_rate` if that was done evenly and no message is lost"
        )
    if not both[1].stamped:
        _refuse_irregular(path, position, "record it with stamps (PoseStamped, ...)")
    if not (both[0].stamped and both[1].stamped):
        if sample_rate is None or not both[1].stamped:
            notes.append(_by_the_recorder(force, position, *both))
        both = [onto_recorder(each) for each in both]
    else:
        f, u = both
        both, said = _join_stamps(path, force, position, f, u, clock)
        notes += said
    f, u = both
    return f, u, _cuts(f, u), notes


def _cuts(f: ClockedTimes, u: ClockedTimes) -> IntArray:
    """Return where to split; a step that both share is one, at the earlier of its times."""
    cuts = [np.delete(each.cuts, each.setback_cuts) for each in (f, u)]
    shared = [each.cuts[each.setback_cuts] for each in (f, u)]
    if shared[0].size and shared[1].size:
        shared = [np.minimum(*shared)]
    return np.unique(np.concatenate([*cuts, *shared]))


def _refine_times(path: object, field: FieldValues, clock: Clock | None) -> ClockedTimes:
    found = correct_clocks(field.name, field.logged, field.stamped)
    if found.even:
        return found
    if clock == "recorder":
        return correct_clocks(field.name, field.logged, None)
    raise RecordingError(
        f"{path}: the stamps of {field.name} come in steps of {found.tick / 1e6:.4g} ms, several "
        "messages to a step, and not evenly; state `clock` recorder to go by when they were "
        "recorded, or stamp them more finely"
    )


def _at_the_rate(
    path: object, force: FieldValues, clock: ClockedTimes, rate: float
) -> ClockedTimes:
    """Return even times at a stated rate [Hz], or nearly: the recorder's clock counts.

    Raises
    ------
    RecordingError
        If the messages came at a rate that no error of clocks makes of it.
    """
    even = space_evenly(clock, force.name, force.logged, rate)
    if not _drifts(even.drift, even.drift_error, even.duration):
        return even
    came = rate / (1.0 + even.drift)
    if abs(even.drift) > SIMULATED:
        raise RecordingError(
            f"{path}: `sample_rate` is {rate:g} Hz, but the messages of {force.name} were recorded "
            f"at {came:.6g} a second on average, and no clock is wrong by so much; state the rate "
            "at which they were taken, or record with stamps if some were lost"
        )
    error = even.drift_error * even.duration / 2.0  # at the ends, in the middle there is none
    even = space_evenly(clock, force.name, force.logged, came)
    said = f"{rate:g} Hz was stated, which the recorder's clock shows to be {came:.6g} Hz"
    return replace(even, doubt=error, notes=(*even.notes, said))


def _require_stamps(path: object, *fields: FieldValues) -> None:
    for field in fields:
        if field.stamped is None:
            raise RecordingError(
                f"{path}: {field.name} has no stamps; leave `clock` out, or state recorder"
            )


def _made_good_alike(
    path: object,
    force: FieldValues,
    position: FieldValues,
    f: ClockedTimes,
    u: ClockedTimes,
) -> list[ClockedTimes]:
    """Make good steps back of the host's clock by the same in both.

    By the larger: in the other, a message may be missing there.
    """
    if not (f.setbacks.size and u.setbacks.size):
        return [f, u]
    if f.setbacks.size != u.setbacks.size:
        raise RecordingError(
            f"{path}: the clock by which {force.name} goes steps back {f.setbacks.size} times, "
            f"that of {position.name} {u.setbacks.size} times, and which belong together cannot be "
            "told; cut the recording there"
        )
    sizes = np.maximum(f.setbacks, u.setbacks)
    return [_moved_on(each, sizes - each.setbacks) for each in (f, u)]


def _moved_on(clock: ClockedTimes, more: IntArray) -> ClockedTimes:
    begins = clock.cuts[clock.setback_cuts]

    def move_times(times: IntArray) -> IntArray:
        found: IntArray = times + (more * (times[:, None] >= begins)).sum(axis=1)
        return found

    return replace(clock, times=move_times(clock.times), cuts=move_times(clock.cuts))


def _refuse_irregular(path: object, field: FieldValues, advice: str) -> None:
    """Refuse to go by log times that jitter by more than a spline bears."""
    times = np.sort(field.logged)
    usual = usual_step(times)
    if times.size < 3 or np.mean(np.diff(times) > GAP * usual) <= MISSING:
        return
    rate = NANOSECONDS * (times.size - 1) / float(times[-1] - times[0] or 1)
    raise RecordingError(
        f"{path}: {field.name} has no stamps, and its messages were recorded irregularly, "
        f"{rate:.6g} a second on average, so that it is not known when they were measured; {advice}"
    )


def _by_the_recorder(
    force: FieldValues, position: FieldValues, f: ClockedTimes, u: ClockedTimes
) -> str:
    without = [field.name for field, each in ((force, f), (position, u)) if not each.stamped]
    return (
        f"{' and '.join(without)} {'has' if len(without) == 1 else 'have'} no stamps: both signals "
        "are taken at the times they were recorded, and may be shifted by their different ways to "
        "the recorder"
    )


def _join_stamps(
    path: object,
    force: FieldValues,
    position: FieldValues,
    f: ClockedTimes,
    u: ClockedTimes,
    clock: Clock | None,
) -> tuple[list[ClockedTimes], list[str]]:
    """Bring two channels of stamps together."""
    if clock == "stamps":
        return [f, u], ["both signals go by their stamps as they are, as stated"]
    length = max(f.duration, u.duration)
    drifting = _drifts(f.drift - u.drift, np.hypot(f.drift_error, u.drift_error), length)
    if clock == "recorder":
        said = f"both signals go by the recorder's clock, as stated{_rates(force, position, f, u)}"
        return [onto_recorder(f), onto_recorder(u)], [said]
    if drifting:
        raise RecordingError(
            f"{path}: the clocks that stamp {force.name} and {position.name} drift apart by "
            f"{1e6 * abs(f.drift - u.drift):.4g} ppm, {abs(f.drift - u.drift) * length / 1e6:.4g} "
            "ms over the recording; state `clock` recorder to bring both to the recorder's, or "
            "stamps to take them as they are"
        )
    notes = []
    apart = abs(f.delay - u.delay)
    if apart > POSSIBLE_DELAY * NANOSECONDS:
        return [_take_log_times(force, f), _take_log_times(position, u)], [
            f"the clocks that stamp {force.name} and {position.name} are "
            f"{apart / NANOSECONDS:.6g} s apart: both signals are taken at the times they were "
            "recorded, less the jitter that their stamps tell, and may be shifted by their "
            "different ways to the recorder"
        ]
    if apart > SHIFT_WORTH_TELLING:
        notes.append(
            f"{force.name} was recorded {f.delay / 1e6:.4g} ms after its stamps, {position.name} "
            f"{u.delay / 1e6:.4g} ms: if that is their clocks and not the way to the recorder, the "
            f"signals are {apart / 1e6:.3g} ms apart"
        )
    shared = (f.drift * u.duration + u.drift * f.duration) / max(f.duration + u.duration, 1.0)
    error = max(f.drift_error, u.drift_error)
    if _drifts(shared, error, length) and abs(shared) < SIMULATED:
        notes.append(
            f"the clock of the stamps runs {1e6 * abs(shared):.4g} ppm "
            f"{'slower' if shared > 0 else 'faster'} than the recorder's, for both signals alike: "
            "their times are corrected to the recorder's"
        )
        return [onto_recorder(f, shared), onto_recorder(u, shared)], notes
    if abs(shared) >= SIMULATED:
        notes.append(
            f"the stamps run at {1.0 / (1.0 + shared):.4g} of the recorder's time, as those of a "
            "simulation or a replay do: they are right, and kept"
        )
    return [f, u], notes


def _take_log_times(field: FieldValues, clock: ClockedTimes) -> ClockedTimes:
    """Return times by the recorder's clock: log times, where stamps keep no time beside it."""
    if clock.jitter > POSSIBLE_DELAY * NANOSECONDS:
        return correct_clocks(field.name, field.logged, None)
    return onto_recorder(clock)


def _drifts(drift: float, error: float, length: float) -> bool:
    return abs(drift) * length > max(SHIFT_WORTH_TELLING, STEP_DEVIATIONS * error * length)


def _rates(force: FieldValues, position: FieldValues, f: ClockedTimes, u: ClockedTimes) -> str:
    drifts = [
        f"that of {field.name} is off by {1e6 * each.drift:.4g} ppm"
        for field, each in ((force, f), (position, u))
        if _drifts(each.drift, each.drift_error, each.duration)
    ]
    return f": {', '.join(drifts)}" if drifts else ""
