"""CRTK's operating state: whether a robot is ready, told and commanded as the dVRK does it.

https://crtk-robotics.readthedocs.io: the states, and which command leads from which to which.
"""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node

from crtk_msgs.msg import OperatingState, StringStamped
from tissue_probe.nodes.hearing import hear
from tissue_probe.nodes.qos import LATCHED, POSES
from tissue_probe.nodes.timers import every

DISABLED, ENABLED, PAUSED, FAULT = STATES = ("DISABLED", "ENABLED", "PAUSED", "FAULT")

#: The state after a command in a state; other commands are invalid there, and change nothing.
STATE_AFTER_COMMAND = {
    (DISABLED, "enable"): ENABLED,
    (DISABLED, "disable"): DISABLED,
    (ENABLED, "enable"): ENABLED,
    (ENABLED, "disable"): DISABLED,
    (ENABLED, "pause"): PAUSED,
    (PAUSED, "disable"): DISABLED,
    (PAUSED, "pause"): PAUSED,
    (PAUSED, "resume"): ENABLED,
}


class OperatingStateInterface:
    """Publishes ``operating_state`` when it changes and once a second, hears ``state_command``.

    Reliable both; the state is kept for late joiners, and repeated for those who did not ask for
    kept messages, as CRTK's own client does not.

    Parameters
    ----------
    node : Node
        Whose names the topics are relative to.
    state : callable
        Returns the state now, and whether a motion is under way.
    on_command : callable
        Called with each command, a word.
    """

    def __init__(
        self,
        node: Node,
        state: Callable[[], tuple[str, bool]],
        on_command: Callable[[str], None],
    ) -> None:
        self._node = node
        self._state = state
        self._on_command = on_command
        self._publisher = node.create_publisher(OperatingState, "operating_state", LATCHED)
        hear(node, StringStamped, "state_command", self._hear, POSES)
        every(1.0, node, self.publish)
        self.publish()

    def publish(self) -> None:
        """Tell the state now."""
        state, is_busy = self._state()
        message = OperatingState(state=state, is_homed=True, is_busy=is_busy)
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)

    def _hear(self, command: StringStamped) -> None:
        self._on_command(command.string.strip().lower())
        self.publish()
