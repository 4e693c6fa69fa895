"""A time that stands in two columns, as ROS writes it: seconds, and nanoseconds beside them.

Contents: making one column of both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tissue_probe.recording.clocks.times import EPOCH
from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import NANOSECONDS

#: Endings of names, in lower case: of whole seconds, and of the nanoseconds beside them.
SECONDS = ("seconds", "secs", "sec")
NANOS = ("nanoseconds", "nanosecs", "nanosec", "nsecs", "nsec")
#: The name of the one column, which is this suite's name of a time.
TIME_COLUMN = "time"


def with_stamps(source: Columns) -> Columns:
    """Return columns with the time that two of them tell together; as they are where none do.

    Several such pairs are several clocks: which counts must be said.
    """
    pairs = _pairs(source.names)
    if len(pairs) != 1 or {"t", TIME_COLUMN} & set(source.names):
        return source
    (seconds, nanos), load = pairs[0], source.load

    def join_stamps(wanted: Sequence[str], progress: Progress) -> Loaded:
        if TIME_COLUMN not in wanted:
            return load(wanted, progress)
        others = [name for name in wanted if name != TIME_COLUMN]
        found = load(list(dict.fromkeys([*others, seconds, nanos])), progress)
        named = dict(zip(dict.fromkeys([*others, seconds, nanos]), found.columns, strict=True))
        named[TIME_COLUMN] = _add_seconds(source, seconds, named[seconds], nanos, named[nanos])
        return found._replace(columns=[named[name] for name in wanted])

    told = f"time is {seconds} and {nanos} together"
    return replace(
        source, names=(*source.names, TIME_COLUMN), load=join_stamps, told=(*source.told, told)
    )


def _add_seconds(
    source: Columns, seconds: str, whole: np.ndarray, nanos: str, beside: np.ndarray
) -> np.ndarray:
    """Return times as ``datetime64[ns]``; NaT where one of both is not known.

    Raises
    ------
    RecordingError
        If they are not whole seconds and the nanoseconds beside them.
    """
    both = whole.dtype.kind in "iuf" and beside.dtype.kind in "iuf"
    known = np.isfinite(whole) & np.isfinite(beside) if both else np.zeros(0, dtype=bool)
    s, n = (each[known] if both else known for each in (whole, beside))
    if (
        not both
        or np.any(s % 1)
        or np.any((n < 0) | (n >= NANOSECONDS))
        or np.any(np.abs(s) > EPOCH[1])
    ):
        raise RecordingError(
            f"{source.path}: columns {seconds} and {nanos} are no seconds and the nanoseconds "
            "beside them: give the column of times by `time`"
        )
    times = np.full(whole.size, np.datetime64("NaT"), dtype="datetime64[ns]")
    times[known] = (s.astype(np.int64) * NANOSECONDS + n.astype(np.int64)).view("datetime64[ns]")
    return times


def _pairs(names: Sequence[str]) -> list[tuple[str, str]]:
    """Return the names of seconds and nanoseconds that differ by their endings only."""
    plain = {name.strip().casefold(): name for name in names}
    return [
        (plain[before + seconds], plain[before + nanos])
        for seconds in SECONDS
        for nanos in NANOS
        for before in {each.removesuffix(nanos) for each in plain if each.endswith(nanos)}
        if before + seconds in plain
    ]
