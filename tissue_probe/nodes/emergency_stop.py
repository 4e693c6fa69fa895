"""How others stop the coil, hear why it stopped, and allow it to move again."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger

from tissue_probe.devices.interlock import Interlock
from tissue_probe.nodes.hearing import hear
from tissue_probe.nodes.qos import LATCHED, POSES


class EmergencyStop:
    """Services ``emergency_stop`` and ``reset``, topics ``emergency_stop`` and ``fault``.

    Anyone who publishes true on ``emergency_stop`` stops the coil; false does nothing, since only
    ``reset`` arms again. ``fault`` tells the reason, empty while armed, to late joiners too.

    Parameters
    ----------
    node : Node
        Whose names these are relative to.
    interlock : Interlock
        The interlock that is shown, and reset.
    trip : callable
        Puts the coil at zero and trips the interlock, given the reason.
    is_running : callable
        Whether samples are still taken; no reset before they ended.
    """

    def __init__(
        self,
        node: Node,
        interlock: Interlock,
        trip: Callable[[str], None],
        is_running: Callable[[], bool],
    ) -> None:
        self._interlock = interlock
        self._trip = trip
        self._is_running = is_running
        self._publisher = node.create_publisher(String, "fault", LATCHED)
        self._told: str | None = None
        node.create_service(Trigger, "emergency_stop", self._on_service)
        node.create_service(Trigger, "reset", self._on_reset)
        hear(node, Bool, "emergency_stop", self._on_topic, POSES)
        self.publish()

    def publish(self) -> None:
        """Tell the reason, if it changed."""
        if self._told != self._interlock.reason:
            self._told = self._interlock.reason
            self._publisher.publish(String(data=self._told))

    def _on_service(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._stop("the service emergency_stop was called")
        response.success = True
        response.message = f"the coil is at zero: {self._interlock.reason}"
        return response

    def _on_topic(self, message: Bool) -> None:
        if message.data:
            self._stop("true came on the topic emergency_stop")

    def _stop(self, reason: str) -> None:
        self._trip(f"{reason}: the coil is at zero until the service reset is called")
        self.publish()

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = not self._is_running()
        if response.success:
            was = self._interlock.reason or "nothing"
            self._interlock.reset()
            self.publish()
            response.message = f"reset after: {was}"
        else:
            response.message = "refused: the driver is active; deactivate it first"
        return response
