"""A node's report on its own health once a second on /diagnostics (REP 107).

OK: as it should be. WARN: it goes on, but someone should look. ERROR: it does not do its task.
STALE: nothing comes in that it could work on.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from tissue_probe.nodes.timers import every

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
STALE = DiagnosticStatus.STALE


@dataclass(frozen=True)
class Health:
    """A level, a sentence, and named values (each with its unit in its name)."""

    level: bytes = OK
    message: str = "as it should be"
    values: dict[str, object] = field(default_factory=dict)


class Rate:
    """How fast a count grows."""

    def __init__(self) -> None:
        self._count, self._time = 0, time.monotonic()

    def __call__(self, count: int) -> float:
        """Return how many a second there were since last asked; a count below that is a new one."""
        now = time.monotonic()
        before, since = self._count, self._time
        self._count, self._time = count, now
        return (count - before if count >= before else count) / max(now - since, 1e-3)


class Diagnostics:
    """Publishes the health that ``examine`` returns, once a second."""

    def __init__(self, node: Node, examine: Callable[[], Health]) -> None:
        self._node = node
        self._examine = examine
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        every(1.0, node, self.publish)

    def publish(self) -> None:
        """Examine and publish now."""
        health = self._examine()
        status = DiagnosticStatus(
            level=health.level,
            name=self._node.get_fully_qualified_name(),
            message=health.message,
            values=[KeyValue(key=key, value=str(value)) for key, value in health.values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
