"""When a message was received, by a clock that never steps: recordings are read in that order.

DDS tells it by the wall clock. Set back by an hour, that would put the rest of a recording before
its beginning.
"""

from __future__ import annotations

import time


class LogTime:
    """Turns the times told by DDS into those of the wall clock as it went on from the beginning.

    The time of a message received while the wall clock stepped may be of either clock. It was
    received since the look before the last one, and not later than now.
    """

    def __init__(self) -> None:
        self._zero = time.time_ns() - time.monotonic_ns()
        self._since = self._looked = self._now()
        self._ahead = 0
        self._latest = 0

    def look(self) -> None:
        """Begin to take the messages that arrived since the last look."""
        self._since, self._looked = self._looked, self._now()
        self._ahead = time.time_ns() - self._looked

    def of(self, received: int) -> int:
        """Return the time of a message that DDS says was received then [ns since the epoch]."""
        within = min(max(received - self._ahead, self._since), self._now())
        self._latest = max(self._latest, within)
        return self._latest

    def _now(self) -> int:
        return time.monotonic_ns() + self._zero
