"""Poses and wrenches as they were measured, each at times of its own, brought to one even grid.

Contents: their faults, told in a sentence; stretches without a hole.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tissue_probe.errors import MeasurementError
from tissue_probe.recording.clocks.channel import SILENT_PERIODS
from tissue_probe.recording.clocks.local_cubic import local_cubic
from tissue_probe.recording.robot.settings import UNIT_ROUNDING
from tissue_probe.sensor.free_air import WRENCH_AXES, FreeAir
from tissue_probe.sensor.smoothed_air import LONGEST_SENSOR_DELAY, SHORTEST_AIR
from tissue_probe.signals import LONGEST_SILENCE, NANOSECONDS, FloatArray, IntArray

#: A pose that moves faster has jumped [m/s], [rad/s]: no robot does it where it feels for anything.
FASTEST_POSE, FASTEST_POSE_TURN = 5.0, 30.0
#: Slower samples tell no motion of an arm [Hz]: the filter of the fit ends at 12.
LOWEST_SAMPLE_RATE = 40.0
#: In saturation an axis stays at its greatest value for so many samples: noise does not.
SATURATED = 10
#: An axis with fewer values has coarse steps, at whose ends it may stay.
FEW_VALUES = 50


@dataclass(frozen=True)
class Track:
    """One topic: stamps [ns], ascending, shape (n,), and rows, shape (n, c)."""

    stamps: IntArray
    rows: FloatArray


def stretches(
    poses: Track, wrenches: Track, joints: Track | None = None, origin: int | None = None
) -> list[FreeAir]:
    """Return the stretches in which all is known, on the wrench's own mean period.

    Parameters
    ----------
    poses : Track
        Rows x, y, z [m], then the quaternion x, y, z, w, which turns the sensor's axes into the
        base's.
    wrenches : Track
        Rows of force [N] and torque [N m] in the sensor's axes.
    joints : Track or None
        Rows of the angles of joints along which a cable runs [rad].
    origin : int or None
        From which stamp the times of the stretches count [ns]; None for the first.

    Raises
    ------
    MeasurementError
        If something is wrong with them; says the fault, where, and the remedy.
    """
    both = np.concatenate([poses.stamps[:1], wrenches.stamps[:1]])
    begin = int(both.min()) if both.size else 0
    tracks = {"the pose": poses, "the wrench": wrenches}
    if joints is not None:
        tracks["the joints"] = joints
    for name, track in tracks.items():
        _check_track(name, track, begin)
    _check_wrench(wrenches, begin)
    poses = Track(poses.stamps, np.hstack([poses.rows[:, :3], _even_signs(poses.rows[:, 3:])]))
    _check_poses(poses, begin)
    period = round(float(np.median(np.diff(wrenches.stamps))))
    runs = []
    for at in _together(list(tracks.values()), period):
        place = _values(poses, at)
        turn = place[:, 3:] / np.linalg.norm(place[:, 3:], axis=1)[:, None]
        angles = _values(joints, at) if joints is not None else np.empty((at.size, 0))
        first = float(at[0] - (begin if origin is None else origin)) / NANOSECONDS
        seconds = period / NANOSECONDS
        runs.append(FreeAir(first, seconds, place[:, :3], turn, _values(wrenches, at), angles))
    if not runs:
        raise MeasurementError(
            f"pose and wrench are never both there for {SHORTEST_AIR:g} s without a hole: record "
            "both by one clock, without losses"
        )
    return runs


def _check_track(name: str, track: Track, begin: int) -> None:
    if len(track.stamps) < 4:
        raise MeasurementError(f"{name} has {len(track.stamps)} samples: record a minute of both")
    wrong = ~np.asarray(np.isfinite(track.rows).all(axis=1))
    if wrong.any():
        raise MeasurementError(
            f"{name} is not finite {_at(track, wrong, begin)}: leave such samples out, or mend "
            "the node that publishes them"
        )
    steps = np.diff(track.stamps)
    if (steps <= 0).any():
        wrong = np.concatenate([np.array([False]), steps <= 0])
        raise MeasurementError(
            f"the times of {name} do not ascend {_at(track, wrong, begin)}: sort the samples, and "
            "leave out those that come twice"
        )
    rate = NANOSECONDS / float(np.median(steps))
    if rate < LOWEST_SAMPLE_RATE:
        raise MeasurementError(
            f"{name} comes {rate:.3g} times a second: record at {LOWEST_SAMPLE_RATE:g} Hz or more"
        )


def _check_wrench(track: Track, begin: int) -> None:
    """Refuse a wrench that stops, or is in saturation."""
    same = (np.diff(track.rows, axis=0) == 0.0).all(axis=1) & track.rows[1:].any(axis=1)
    held = _longest(same)
    lasted = track.stamps[held[1]] - track.stamps[held[0]] if held else 0
    if held and lasted > LONGEST_SILENCE:
        when = (track.stamps[held[0]] - begin) / NANOSECONDS
        raise MeasurementError(
            f"the wrench stops at {when:.2f} s: for {lasted / NANOSECONDS:.2g} s it repeats one "
            "value to the last bit; does its sensor or its driver hang?"
        )
    for axis, values in zip(WRENCH_AXES, track.rows.T, strict=True):
        if np.unique(values).size < FEW_VALUES:
            continue
        for extreme in (values.max(), values.min()):
            held = _longest(values[1:] == extreme)
            if held and held[1] - held[0] >= SATURATED:
                when = (track.stamps[held[0]] - begin) / NANOSECONDS
                raise MeasurementError(
                    f"{axis} is in saturation at {when:.2f} s: it stays at {extreme:.6g}; take a "
                    "wider range of the sensor, or a lighter load"
                )


def _check_poses(track: Track, begin: int) -> None:
    length = np.linalg.norm(track.rows[:, 3:], axis=1)
    wrong = np.abs(length - 1.0) > UNIT_ROUNDING
    if wrong.any():
        raise MeasurementError(
            f"the orientation is none {_at(track, wrong, begin)}: a quaternion x, y, z, w has "
            "length 1"
        )
    # Stamps may jitter by as much as a period.
    seconds = np.maximum(np.diff(track.stamps), np.median(np.diff(track.stamps))) / NANOSECONDS
    way = np.linalg.norm(np.diff(track.rows[:, :3], axis=0), axis=1)
    turn = 2.0 * np.linalg.norm(np.diff(track.rows[:, 3:], axis=0), axis=1)
    jumps = (way > FASTEST_POSE * seconds) | (turn > FASTEST_POSE_TURN * seconds)
    if jumps.any():
        number = int(np.argmax(jumps))
        when = (track.stamps[number + 1] - begin) / NANOSECONDS
        raise MeasurementError(
            f"the pose jumps at {when:.2f} s, by {1e3 * way[number]:.3g} mm and {turn[number]:.2g} "
            "rad from one sample to the next: record without changing tool or base frame"
        )


def _at(track: Track, wrong: np.ndarray, begin: int) -> str:
    when = (track.stamps[int(np.argmax(wrong))] - begin) / NANOSECONDS
    count = int(wrong.sum())
    return f"at {when:.2f} s" + (f" and {count - 1} times after it" if count > 1 else "")


def _longest(held: np.ndarray) -> tuple[int, int] | None:
    """Return first and last sample of the longest row of samples that repeat the one before."""
    edges = np.diff(np.concatenate([[0], held.astype(int), [0]]))
    begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    if not begins.size:
        return None
    number = int(np.argmax(ends - begins))
    return int(begins[number]), int(ends[number])


def _even_signs(quaternions: FloatArray) -> FloatArray:
    """Return the quaternions, each on the side of the one before it: q and -q are one turn."""
    turned = np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0
    signs = np.concatenate([[1.0], np.cumprod(np.where(turned, -1.0, 1.0))])
    found: FloatArray = quaternions * signs[:, None]
    return found


def _together(tracks: list[Track], period: int) -> Iterator[IntArray]:
    """Yield the grids of the stretches in which no track has a hole."""
    first = max(int(track.stamps[1]) for track in tracks)
    last = min(int(track.stamps[-2]) for track in tracks)
    holes = [(first, first)]
    for track in tracks:
        steps = np.diff(track.stamps)
        for number in map(int, np.flatnonzero(steps > SILENT_PERIODS * np.median(steps))):
            # Two samples on either side are needed.
            before, after = max(number - 1, 0), min(number + 2, len(track.stamps) - 1)
            holes.append((int(track.stamps[before]), int(track.stamps[after])))
    holes = [*sorted(holes), (last, last)]
    end = first
    needed = NANOSECONDS * (SHORTEST_AIR + 2.0 * LONGEST_SENSOR_DELAY)
    for before, after in holes:
        if before - end > needed:
            yield np.arange(end + 1, before + 1, period, dtype=np.int64)
        end = max(end, after)


def _values(track: Track, at: IntArray) -> FloatArray:
    return local_cubic(track.stamps, track.rows, at)
