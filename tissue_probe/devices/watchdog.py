"""A thread that acts when something expected does not happen in time."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable


class Watchdog:
    """Calls ``bark`` once, from a thread of its own, if its deadline passes.

    Parameters
    ----------
    bark : callable
        Called then; may stop the watchdog.
    """

    def __init__(self, bark: Callable[[], None]) -> None:
        self._bark = bark
        self._deadline = math.inf
        self._stopped = threading.Event()
        self._stopped.set()

    def start(self, patience: float) -> None:
        """Begin to watch, with ``patience`` [s] until the deadline."""
        self.stop()
        self.expect_within(patience)
        self._stopped = threading.Event()
        threading.Thread(
            target=self._watch, args=(self._stopped,), name="watchdog", daemon=True
        ).start()

    def expect_within(self, patience: float) -> None:
        """Move the deadline to ``patience`` [s] from now."""
        self._deadline = time.monotonic() + patience

    def stop(self) -> None:
        """Cease to watch; does nothing if it does not."""
        self._stopped.set()

    def _watch(self, stopped: threading.Event) -> None:
        while not stopped.wait(max(0.0, self._deadline - time.monotonic())):
            if time.monotonic() >= self._deadline:
                self._bark()
                return
