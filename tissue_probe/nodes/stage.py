"""The simulated stage: carries the probe over the phantom, and speaks CRTK as a robot does."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import PoseStamped
from pydantic import BaseModel
from rclpy.node import Node

from tissue_probe.nodes.crtk import ENABLED, TRANSITIONS, OperatingStateInterface
from tissue_probe.nodes.diagnostics import OK, WARN, Diagnostics, Health
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import POSES
from tissue_probe.nodes.timers import every
from tissue_probe.settings import setting


class StageSettings(BaseModel):
    """How the stage moves, and where it stands at first."""

    speed: float = setting(0.05, "m/s", "fastest motion", gt=0.0, le=1.0)
    rate: float = setting(100.0, "Hz", "poses a second", ge=1.0, le=1000.0)
    x: float = setting(0.0, "m", "first x", ge=-1.0, le=1.0)
    y: float = setting(0.0, "m", "first y", ge=-1.0, le=1.0)
    z: float = setting(0.01, "m", "first height", ge=-1.0, le=1.0)
    frame_id: str = setting("stage", "", "frame of the poses")


class Stage(Node):
    """Follows ``servo_cp`` at limited speed and tells where it is on ``measured_cp``.

    It moves only while its CRTK state is ENABLED, in which it begins.
    """

    def __init__(self) -> None:
        super().__init__("stage")
        declare(self, StageSettings)
        settings = read(self, StageSettings)
        self._step = settings.speed / settings.rate
        self._position = np.array([settings.x, settings.y, settings.z])
        self._setpoint = self._position.copy()
        self._pose = PoseStamped()
        self._pose.header.frame_id = settings.frame_id
        self._state = ENABLED
        self._crtk = OperatingStateInterface(
            self, lambda: (self._state, self._is_moving()), self._on_command
        )
        self._publisher = self.create_publisher(PoseStamped, "measured_cp", POSES)
        self.create_subscription(PoseStamped, "servo_cp", self._on_setpoint, POSES)
        every(1.0 / settings.rate, self, self._move)
        Diagnostics(self, self._examine)

    def _on_command(self, command: str) -> None:
        after = TRANSITIONS.get((self._state, command))
        if after is None:
            self.get_logger().error(f"'{command}' is no command for a stage that is {self._state}")
            return
        self._state = after
        self._setpoint = self._position.copy()  # it stays where it is

    def _is_moving(self) -> bool:
        return not np.array_equal(self._setpoint, self._position)

    def _on_setpoint(self, message: PoseStamped) -> None:
        position = message.pose.position
        setpoint = np.array([position.x, position.y, position.z])
        if not np.isfinite(setpoint).all():
            self.get_logger().error("a setpoint that is not finite is ignored")
            return
        if self._state == ENABLED:
            self._setpoint = setpoint

    def _move(self) -> None:
        way = self._setpoint - self._position
        distance = float(np.linalg.norm(way))
        if distance > 0.0:
            self._position += way * min(1.0, self._step / distance)
        self._pose.header.stamp = self.get_clock().now().to_msg()
        point = self._pose.pose.position
        point.x, point.y, point.z = map(float, self._position)
        self._publisher.publish(self._pose)

    def _examine(self) -> Health:
        doing = "moving" if self._is_moving() else "at rest"
        level = OK if self._state == ENABLED else WARN
        values = {"subscribers": self._publisher.get_subscription_count()}
        return Health(level, f"{self._state}, {doing}", values)


def main() -> int:
    """Run the simulated stage."""
    return run(Stage)


if __name__ == "__main__":
    raise SystemExit(main())
