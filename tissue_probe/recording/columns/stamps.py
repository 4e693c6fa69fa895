"""A time that stands in two columns, as ROS writes it: seconds, and nanoseconds beside them.

What belongs here: making one column of both. What does not: what times mean (``times``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.signals import NANOSECONDS

#: Endings of names, in lower case: of whole seconds, and of the nanoseconds beside them.
SECONDS = ("seconds", "secs", "sec")
NANOS = ("nanoseconds", "nanosecs", "nanosec", "nsecs", "nsec")
#: What the one column is called, which is this suite's name of a time.
TIME = "time"


def with_stamps(source: Columns) -> Columns:
    """Return columns with the time that two of them tell together; as they are where none do.

    Several such pairs are several clocks: which counts must be said.
    """
    pairs = _pairs(source.names)
    if len(pairs) != 1 or {"t", TIME} & set(source.names):
        return source
    (seconds, nanos), load = pairs[0], source.load

    def joined(wanted: Sequence[str], progress: Progress) -> Loaded:
        if TIME not in wanted:
            return load(wanted, progress)
        others = [name for name in wanted if name != TIME]
        found = load(list(dict.fromkeys([*others, seconds, nanos])), progress)
        named = dict(zip(dict.fromkeys([*others, seconds, nanos]), found.columns, strict=True))
        whole = named[seconds].astype(np.int64) * NANOSECONDS + named[nanos].astype(np.int64)
        named[TIME] = whole.view("datetime64[ns]")
        return found._replace(columns=[named[name] for name in wanted])

    told = f"time is {seconds} and {nanos} together"
    return replace(source, names=(*source.names, TIME), load=joined, told=(*source.told, told))


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
