"""A clock whose time passes only where the DAQ itself takes or waits for it."""

from __future__ import annotations


class Stepped:
    """The time of a board [s] on a machine that is never late: for tests of times.

    Every wait ends at once, with the time at which it would have ended. Clients ask one after the
    other.
    """

    def __init__(self) -> None:
        self._now = 0.0

    def __call__(self) -> float:
        """Return the time."""
        return self._now

    def wait(self, seconds: float) -> None:
        """Let so much time pass."""
        self._now += max(seconds, 0.0)
