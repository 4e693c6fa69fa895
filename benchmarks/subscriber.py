"""Somebody else's program that wants every sample by itself: counts messages of one topic."""

from __future__ import annotations

import json
import sys
from functools import partial
from pathlib import Path

from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node

from tissue_probe.nodes.conversions import from_time
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import PER_SAMPLE

#: Time between two looks at what has arrived [s].
INTERVAL = 0.05


class Subscriber(Node):
    """Takes every message of a topic; at its end writes how many, and the time they span.

    Whoever joins while samples flow begins with any of them: what it lost lies in between.
    """

    def __init__(self, topic: str, output: Path) -> None:
        super().__init__("subscriber")
        self._output = output
        self._stamps: list[int] = []
        self._inbox = Inbox(self)
        self._inbox.subscribe(WrenchStamped, topic, PER_SAMPLE, self._on_wrench)
        self.create_timer(INTERVAL, self._take)

    def destroy_node(self) -> None:
        """Take what has arrived, write the number, end the node."""
        self._take()
        span = self._stamps[-1] - self._stamps[0] if self._stamps else 0
        found = {"received": len(self._stamps), "nanoseconds": span}
        self._output.write_text(json.dumps(found))
        self._inbox.destroy()
        super().destroy_node()

    def _take(self) -> None:
        self._inbox.empty()

    def _on_wrench(self, message: WrenchStamped, info: dict) -> None:
        self._stamps.append(from_time(message.header.stamp))


if __name__ == "__main__":
    # What is left on the command line is for ROS.
    program, topic, output = sys.argv
    sys.argv = [program]
    raise SystemExit(run(partial(Subscriber, topic, Path(output))))
