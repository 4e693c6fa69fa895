"""Timers that follow the monotonic clock, as everything in a node that must go on does."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.timer import Timer


def every(period: float, node: Node, callback: Callable[[], None]) -> Timer:
    """Call back every ``period`` [s], independent of the wall clock.

    By default a node's timers follow the wall clock: set back by an hour, they stand still for one.
    """
    return node.create_timer(period, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))
