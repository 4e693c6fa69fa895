"""A sample clock in software: absolute deadlines on the monotonic clock."""

from __future__ import annotations

import time
from collections import deque

#: Wake-ups whose lateness is remembered: those of a second at 2 kHz.
WAKE_UPS_REMEMBERED = 2000


class Pacer:
    """Wakes at ``start + n * period``, so that being late once never shifts later calls.

    It runs on the monotonic clock: steps of the wall clock do not touch it.

    Parameters
    ----------
    period : float
        Time between two deadlines [s].

    Attributes
    ----------
    worst_lateness : float
        Longest time between a deadline and the wake-up for it since last set to zero [s].
    recent : deque of float
        The same for each of the latest wake-ups [s], at most ``WAKE_UPS_REMEMBERED``.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self.recent: deque[float] = deque(maxlen=WAKE_UPS_REMEMBERED)
        self.restart()

    def restart(self) -> None:
        """Make now deadline number 0."""
        self._start = time.monotonic()
        self.worst_lateness = 0.0
        self.recent.clear()

    def wait_for(self, number: int) -> float:
        """Sleep until deadline ``number``; return by how much it was missed [s], 0 at the least."""
        deadline = self._start + number * self._period
        remaining = deadline - time.monotonic()
        if remaining > 0.0:
            time.sleep(remaining)
        lateness = max(0.0, time.monotonic() - deadline)
        self.worst_lateness = max(self.worst_lateness, lateness)
        self.recent.append(lateness)
        return lateness
