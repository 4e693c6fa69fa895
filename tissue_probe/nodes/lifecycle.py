"""A lifecycle node that outlives a wrong request."""

from __future__ import annotations

from lifecycle_msgs.srv import ChangeState
from rclpy._rclpy_pybind11 import RCLError
from rclpy.lifecycle import LifecycleNode


class SturdyLifecycleNode(LifecycleNode):
    """Refuses a transition that the present state does not have; rclpy's own would end instead."""

    def _LifecycleNodeMixin__on_change_state(  # noqa: N802 - rclpy has no public name for it
        self, request: ChangeState.Request, response: ChangeState.Response
    ) -> ChangeState.Response:
        try:
            own = super()._LifecycleNodeMixin__on_change_state  # type: ignore[misc]  # is mangled
            answer: ChangeState.Response = own(request, response)
            return answer
        except RCLError:
            _, state = self._state_machine.current_state
            wanted = request.transition.label or f"number {request.transition.id}"
            self.get_logger().error(f"refused: there is no transition {wanted} while {state}")
            response.success = False
            return response
