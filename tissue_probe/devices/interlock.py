"""The lock that keeps the coil at zero after a fault until someone says that it may move again."""

from __future__ import annotations

from threading import Lock


class Interlock:
    """Armed, or tripped for a reason; it outlives the device that tripped it.

    It may be used from any thread.

    Attributes
    ----------
    reason : str
        Why it tripped; empty while it is armed.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self.reason = ""

    @property
    def tripped(self) -> bool:
        """Whether no command may reach the coil."""
        return bool(self.reason)

    def trip(self, reason: str) -> None:
        """Trip; the first reason stays, since later ones are most often its consequence."""
        with self._lock:
            self.reason = self.reason or reason

    def reset(self) -> None:
        """Arm it again."""
        with self._lock:
            self.reason = ""
