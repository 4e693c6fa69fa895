"""Time in which this process looked: its own pauses are no silence of others.

A loop that got no processor for a second has heard nobody for a second, and may look before those
threads have run that receive. So the silence of others is measured in the time of the loop itself.
"""

from __future__ import annotations

import time

#: Longest time between two looks that counts as looking [s]: some steps of a loop of 10 ms, in
#: which the threads that receive have run, too.
LONGEST_LOOK_STEP = 0.03


class OwnTime:
    """A clock that goes on with the monotonic one, but by ``LONGEST_LOOK_STEP`` a look at most."""

    def __init__(self) -> None:
        self._time = 0.0
        self._looked = time.monotonic()

    def __call__(self) -> float:
        """Look; return the time [s]."""
        now = time.monotonic()
        self._time += min(now - self._looked, LONGEST_LOOK_STEP)
        self._looked = now
        return self._time
