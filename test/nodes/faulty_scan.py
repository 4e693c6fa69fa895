"""A scan node in which one setpoint cannot be sent, as a middleware may fail.

Run as a program with the scan's arguments. SCAN_FAILS names when: in the descent or in the dwell.
"""

from __future__ import annotations

import os

from geometry_msgs.msg import PoseStamped
from rclpy.publisher import Publisher

#: Heights of the setpoints that fail [m]: in the descent so low that poses have shown it by then.
HEIGHTS = {"descent": (0.0002, 0.001), "dwell": (0.0, 0.0)}
#: The first setpoints at a height are part of the descent.
SENT_BEFORE = {"descent": 0, "dwell": 20}

publish = Publisher.publish


class Fault:
    """Fails once, then never again."""

    def __init__(self, when: str) -> None:
        self._low, self._high = HEIGHTS[when]
        self._left = SENT_BEFORE[when]

    def publish(self, publisher: Publisher, message: object) -> None:
        if isinstance(message, PoseStamped) and self._is_due(message.pose.position.z):
            raise ZeroDivisionError("a fault that nobody foresaw")
        publish(publisher, message)

    def _is_due(self, height: float) -> bool:
        self._left -= self._low <= height <= self._high
        if self._left >= 0:
            return False
        self._left = 10**9
        return True


if __name__ == "__main__":
    fault = Fault(os.environ["SCAN_FAILS"])
    Publisher.publish = lambda publisher, message: fault.publish(publisher, message)
    from tissue_probe.nodes.scan import main

    raise SystemExit(main())
