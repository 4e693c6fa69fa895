"""The robot that carries the probe, as a scan knows it: through CRTK alone.

Setpoints go out on ``servo_cp``, poses come in on ``measured_cp``, and on ``operating_state``, from
a robot that tells it, whether it is ready to move.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np
from geometry_msgs.msg import PoseStamped, Quaternion
from pydantic import BaseModel
from rclpy.node import Node

from crtk_msgs.msg import OperatingState
from tissue_probe.nodes.conversions import place_from_message
from tissue_probe.nodes.crtk import ENABLED, STATES
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.other_scans import are_known, other_scans
from tissue_probe.nodes.own_time import OwnTime
from tissue_probe.nodes.qos import POSES
from tissue_probe.pacing import Pacer
from tissue_probe.settings import setting
from tissue_probe.signals import FloatArray

#: Time between two setpoints [s].
SETPOINT_INTERVAL = 0.01


class RobotSettings(BaseModel):
    """Which robot carries the probe, how it is moved, and when it is trusted to have arrived."""

    robot: str = setting("/stage", "", "namespace of the CRTK robot that carries the probe")
    frame_id: str = setting("stage", "", "frame of the robot's poses")
    speed: float = setting(0.04, "m/s", "speed of the probe", gt=0.0, le=0.5)
    tolerance: float = setting(0.0002, "m", "distance at which a site is reached", gt=0.0, le=0.01)
    motion_timeout: float = setting(
        3.0, "s", "longest wait for the robot to arrive after its last setpoint", gt=0.0, le=60.0
    )
    # Thirty poses at 100 Hz: with the lift that follows, a scan has ended within half a second.
    poses_timeout: float = setting(
        0.3, "s", "longest silence of the robot, by the arrival of its poses", ge=0.05, le=60.0
    )


class NotMoved(RuntimeError):
    """The robot is not where it was sent to, or cannot be sent; the message says why."""


class Robot:
    """Hears the robot and sends it setpoints, one every ``SETPOINT_INTERVAL``.

    Parameters
    ----------
    node : Node
        Whose names the topics are relative to.
    inbox : Inbox
        Where poses and states are kept until the owner empties it.
    settings : RobotSettings
        ``robot`` holds for ever, the others until they are replaced.
    on_step : callable
        Called with each setpoint, in the thread that moves.
    own_time : OwnTime
        By which the robot's silence is measured.

    Attributes
    ----------
    settings : RobotSettings
        How it is moved from the next motion on.
    malformed : int
        How many poses and states were left out.
    """

    def __init__(
        self,
        node: Node,
        inbox: Inbox,
        settings: RobotSettings,
        on_step: Callable[[], None],
        own_time: OwnTime,
    ) -> None:
        self.settings = settings
        self._own_time = own_time
        self.name = settings.robot.rstrip("/")
        self._node = node
        self._on_step = on_step
        self._inbox = inbox
        self._setpoints = node.create_publisher(PoseStamped, f"{self.name}/servo_cp", POSES)
        # Only the latest of each that can be used counts: one that cannot must not push it out. Of
        # a pose counts when it came: a clock of the robot's own may be wrong, and a pose that waits
        # here is new.
        poses, states = f"{self.name}/measured_cp", f"{self.name}/operating_state"
        self._poses = inbox.subscribe(PoseStamped, poses, POSES, self._on_pose)
        self._states = inbox.subscribe(OperatingState, states, POSES, self._on_state)
        self._state: OperatingState | None = None
        self.malformed = 0
        self.forget()

    def forget(self) -> None:
        """Count as silent until a pose comes, and as not yet moved."""
        self._position: FloatArray | None = None
        self._orientation = Quaternion()
        self._heard = -np.inf
        self._setpoint: FloatArray | None = None
        self._unusable, self._unusable_came = "", -np.inf

    def hold_orientation(self) -> None:
        """Keep the tool turned as it is now: setpoints move it, and do not turn it."""
        self._held = self._orientation

    def others(self) -> list[str]:
        """Return the names of other scan nodes that palpate with this robot, if there are any."""
        return other_scans(self._node, self._setpoints.topic_name)

    def others_are_known(self) -> bool:
        """Whether the graph tells the names of all nodes that could move this robot."""
        return are_known(self._node, self._setpoints.topic_name)

    def missing(self) -> str:
        """Say why the robot cannot be moved; nothing if it can."""
        if self._is_long_ago(self._heard):
            return self._why_no_pose()
        if self._state is None and (mismatch := self._states.mismatch()):
            return f"the robot {self.name} is not heard on {self.name}/operating_state: {mismatch}"
        if self._state is not None and self._state.state != ENABLED:
            return (
                f"the robot {self.name} is {self._state.state}: it moves only when it is {ENABLED}"
            )
        if self._state is not None and not self._state.is_homed:
            return f"the robot {self.name} is not homed"
        return ""

    def _why_no_pose(self) -> str:
        if not self._is_long_ago(self._unusable_came):
            return self._unusable
        topic, why = f"{self.name}/measured_cp", self._poses.why_silent()
        if self._position is None:
            return f"the robot {self.name} is not heard on {topic}: {why}"
        return (
            f"the robot {self.name} fell silent: no pose for {self.settings.poses_timeout:g} s "
            f"on {topic}: {why}"
        )

    def _is_long_ago(self, moment: float) -> bool:
        return self._own_time() - moment > self.settings.poses_timeout

    def height(self, surface: FloatArray, normal: FloatArray) -> float:
        """Return how far the probe is above a plane [m], by the latest pose.

        Parameters
        ----------
        surface, normal : array, shape (3,)
            A place on the plane [m], and its normal of length 1.
        """
        return float((self._place() - surface) @ normal)

    def _place(self) -> FloatArray:
        """Return where the latest pose has the probe [m]; NotMoved where none came."""
        if self._position is None:
            raise NotMoved(self._why_no_pose())
        return self._position

    def move(
        self,
        target: FloatArray,
        check: Callable[[], None],
        speed: float | None = None,
        is_enough: Callable[[], bool] = lambda: False,
    ) -> bool:
        """Go straight to ``target`` [m], but first up to its height, and wait until it is reached.

        Parameters
        ----------
        target : array, shape (3,)
            Where to [m].
        check : callable
            Called before each setpoint; empties the inbox, and raises if the motion is to end.
        speed : float, optional
            Of the setpoints [m/s]; by default that of the settings.
        is_enough : callable
            Asked before each setpoint whether the motion ends there, short of the target.

        Returns
        -------
        bool
            Whether it was enough.

        Raises
        ------
        NotMoved
            If the target is not reached within ``motion_timeout`` after the last setpoint.
        """
        start = self._place() if self._setpoint is None else self._setpoint
        pacer, step = Pacer(SETPOINT_INTERVAL), 0
        speed = speed or self.settings.speed
        for step, position in enumerate(self._way(start, target, speed), start=1):
            pacer.wait_for(step)
            check()
            if is_enough():
                return True
            self._command(position)
        deadline = time.monotonic() + self.settings.motion_timeout
        while np.linalg.norm(self._place() - target) > self.settings.tolerance:
            if time.monotonic() > deadline:
                raise NotMoved(
                    f"the robot {self.name} did not reach {_millimetres(target)} within "
                    f"{self.settings.motion_timeout:g} s; it is at {_millimetres(self._place())}"
                )
            step += 1
            pacer.wait_for(step)
            check()
            if is_enough():
                return True
            self._command(target)
        return False

    def hold(self, is_over: Callable[[], bool], check: Callable[[], None]) -> None:
        """Stay at the latest setpoint until ``is_over``; ``check`` as in ``move``."""
        pacer, tick = Pacer(SETPOINT_INTERVAL), 0
        while not is_over():
            tick += 1
            pacer.wait_for(tick)
            check()
            if self._setpoint is not None:
                self._command(self._setpoint)

    def lift(self, surface: FloatArray, normal: FloatArray, height: float) -> None:
        """Go along the normal to a height [m] above the surface, and see it there.

        The way begins at the latest setpoint: it asks nothing of the robot that may not come,
        even if that is elsewhere. A probe that was never moved is left where it is.

        Parameters
        ----------
        surface, normal : array, shape (3,)
            A place on the tissue [m], and the outward normal there, of length 1.
        height : float
            Above the tissue's plane there [m].

        Raises
        ------
        NotMoved
            If the robot has not shown that it is up, or cannot be heard or moved.
        """
        if self._setpoint is None:
            return
        began = self._own_time()
        lower_by = height - float((self._setpoint - surface) @ normal)
        above = self._setpoint + max(lower_by, 0.0) * normal
        pacer, step = Pacer(SETPOINT_INTERVAL), 0
        speed = self.settings.speed
        for step, position in enumerate(self._line(self._setpoint, above, speed), start=1):
            self._command(position)
            pacer.wait_for(step)
        deadline = time.monotonic() + self.settings.motion_timeout
        while not self._is_up(surface, normal, height, began):
            if missing := self.missing():
                raise NotMoved(missing)
            if time.monotonic() > deadline:
                raise NotMoved(
                    f"the robot {self.name} was not lifted by {1e3 * height:.2f} mm within "
                    f"{self.settings.motion_timeout:g} s; it is at {_millimetres(self._place())}"
                )
            self._command(above)
            step += 1
            pacer.wait_for(step)

    def _is_up(self, surface: FloatArray, normal: FloatArray, height: float, since: float) -> bool:
        """Whether a pose that came later than ``since`` shows the probe at a height [m]."""
        self._inbox.empty()
        if self._position is None or self._heard <= since:
            return False
        return bool((self._position - surface) @ normal >= height - self.settings.tolerance)

    def _way(self, start: FloatArray, target: FloatArray, speed: float) -> Iterator[FloatArray]:
        """Yield the setpoints from ``start`` to ``target`` at the speed [m/s], at least one.

        A probe that stands lower than its target goes up first: it may be in the tissue, and is not
        drawn through it.
        """
        if start[2] < target[2]:
            corner = np.array([*start[:2], target[2]])
            yield from self._line(start, corner, speed)
            start = corner
        yield from self._line(start, target, speed)

    def _line(self, start: FloatArray, end: FloatArray, speed: float) -> Iterator[FloatArray]:
        distance = np.linalg.norm(end - start)
        count = max(1, int(np.ceil(distance / (speed * SETPOINT_INTERVAL))))
        for step in range(1, count + 1):
            yield start + (end - start) * (step / count)

    def _command(self, position: FloatArray) -> None:
        setpoint = PoseStamped()
        setpoint.header.stamp = self._node.get_clock().now().to_msg()
        setpoint.header.frame_id = self.settings.frame_id
        point = setpoint.pose.position
        point.x, point.y, point.z = map(float, position)
        setpoint.pose.orientation = self._held
        self._setpoints.publish(setpoint)
        self._setpoint = position
        self._on_step()

    def _on_pose(self, message: PoseStamped, info: dict[str, int]) -> None:
        try:
            position = np.array(place_from_message(message))
        except ValueError as error:
            self._unusable = f"a pose of the robot {self.name} is left out: {error}"
            self._unusable_came = self._own_time()
            self._leave_out(self._unusable)
            return
        self._position, self._heard = position, self._own_time()
        self._orientation = message.pose.orientation

    def _on_state(self, message: OperatingState, info: dict[str, int]) -> None:
        if message.state in STATES:
            self._state = message
        else:
            told = f"a state of the robot {self.name} is left out: {message.state!r} is none of "
            self._leave_out(told + ", ".join(STATES))

    def _leave_out(self, told: str) -> None:
        self.malformed += 1
        self._node.get_logger().error(told, throttle_duration_sec=1.0)


def _millimetres(position: FloatArray) -> str:
    return "(" + ", ".join(f"{1e3 * value:.2f}" for value in position) + ") mm"
