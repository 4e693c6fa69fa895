"""The simulated stage: carries the probe over the phantom, and speaks CRTK as a robot does."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import PoseStamped
from pydantic import BaseModel, model_validator
from rclpy.node import Node

from tissue_probe.nodes.conversions import place_from_message
from tissue_probe.nodes.crtk import ENABLED, STATE_AFTER_COMMAND, OperatingStateInterface
from tissue_probe.nodes.diagnostics import OK, WARN, Diagnostics, Health
from tissue_probe.nodes.hearing import hear
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import POSES
from tissue_probe.nodes.timers import every
from tissue_probe.settings import setting

#: z to which the stock stage may press the tip [m]. The tip touches at z = 0, and the tissue pushes
#: back with its stiffness times the depth: over the stock phantom's stiffest place, 1300 N/m, with
#: half of the load cell's limit of 8 N; the coil's own motion takes the other half.
DEEPEST_PRESS = -0.003


class StageSettings(BaseModel):
    """How the stage moves, and where it stands at first."""

    speed: float = setting(0.05, "m/s", "fastest motion", gt=0.0, le=1.0)
    rate: float = setting(100.0, "Hz", "poses a second", ge=1.0, le=1000.0)
    x: float = setting(0.0, "m", "first x", ge=-1.0, le=1.0)
    y: float = setting(0.0, "m", "first y", ge=-1.0, le=1.0)
    z: float = setting(0.01, "m", "first height", ge=-1.0, le=1.0)
    lowest: float = setting(
        DEEPEST_PRESS,
        "m",
        "lowest z of its workspace, 0 the tissue's surface; a setpoint below is refused",
        ge=-1.0,
        le=1.0,
    )
    frame_id: str = setting("stage", "", "frame of the poses")

    @model_validator(mode="after")
    def _begins_in_workspace(self) -> StageSettings:
        if self.z < self.lowest:
            raise ValueError(f"z is {self.z:g} m, below the workspace: give {self.lowest:g} up")
        return self


class Stage(Node):
    """Follows ``servo_cp`` at limited speed and tells where it is on ``measured_cp``.

    It moves only while its CRTK state is ENABLED, in which it begins, and never below its
    workspace: a setpoint there is refused as a whole, not moved to where it would be allowed.
    """

    def __init__(self) -> None:
        super().__init__("stage")
        declare(self, StageSettings)
        settings = read(self, StageSettings)
        self._step = settings.speed / settings.rate
        self._lowest = settings.lowest
        self._refused = 0
        self._position = np.array([settings.x, settings.y, settings.z])
        self._setpoint = self._position.copy()
        self._pose = PoseStamped()
        self._pose.header.frame_id = settings.frame_id
        self._state = ENABLED
        self._crtk = OperatingStateInterface(
            self, lambda: (self._state, self._is_moving()), self._on_command
        )
        self._publisher = self.create_publisher(PoseStamped, "measured_cp", POSES)
        hear(self, PoseStamped, "servo_cp", self._on_setpoint, POSES)
        every(1.0 / settings.rate, self, self._move)
        Diagnostics(self, self._examine)

    def _on_command(self, command: str) -> None:
        after = STATE_AFTER_COMMAND.get((self._state, command))
        if after is None:
            self.get_logger().error(f"'{command}' is no command for a stage that is {self._state}")
            return
        self._state = after
        self._setpoint = self._position.copy()  # it stays where it is

    def _is_moving(self) -> bool:
        return not np.array_equal(self._setpoint, self._position)

    def _on_setpoint(self, message: PoseStamped) -> None:
        try:
            setpoint = np.array(place_from_message(message))
        except ValueError as error:
            self.get_logger().error(f"a setpoint is left out: {error}", throttle_duration_sec=1.0)
            return
        if setpoint[2] < self._lowest:
            self._refused += 1
            self.get_logger().error(
                f"a setpoint at z = {1e3 * setpoint[2]:.2f} mm is refused: the workspace ends at "
                f"{1e3 * self._lowest:.2f} mm (parameter lowest)",
                throttle_duration_sec=1.0,
            )
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
        values: dict[str, object] = {
            "subscribers": self._publisher.get_subscription_count(),
            "setpoints refused": self._refused,
        }
        return Health(level, f"{self._state}, {doing}", values)


def main() -> int:
    """Run the simulated stage."""
    return run(Stage)


if __name__ == "__main__":
    raise SystemExit(main())
