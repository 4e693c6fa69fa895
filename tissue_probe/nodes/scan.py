"""The scan node: moves the probe from site to site, and says where it is palpating.

It knows the robot only through CRTK: setpoints out on ``servo_cp``, poses in on ``measured_cp``,
and on ``operating_state``, from a robot that tells it, whether it is ready to move.
"""

from __future__ import annotations

import threading
import time

import numpy as np
from geometry_msgs.msg import PoseStamped, Quaternion
from pydantic import BaseModel
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node

from crtk_msgs.msg import OperatingState
from tissue_probe.mapping.grid import Grid
from tissue_probe.nodes.cdr import samples_from_cdr
from tissue_probe.nodes.conversions import place_from_message, site_to_message
from tissue_probe.nodes.crtk import ENABLED
from tissue_probe.nodes.diagnostics import OK, Diagnostics, Health
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.parameters import declare, follow_changes, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATEST, POSES
from tissue_probe.pacing import Pacer
from tissue_probe.settings import setting
from tissue_probe.signals import NANOSECONDS, FloatArray, PalpationSite, Phase
from tissue_probe_msgs import msg
from tissue_probe_msgs.action import ScanGrid

#: Time between two setpoints [s].
INTERVAL = 0.01


class ScanSettings(BaseModel):
    """How the probe is moved and when it is trusted to have arrived."""

    robot: str = setting("/stage", "", "namespace of the CRTK robot that carries the probe")
    frame_id: str = setting("stage", "", "frame of the robot's poses")
    speed: float = setting(0.04, "m/s", "speed of the probe", gt=0.0, le=0.5)
    lift_height: float = setting(
        0.003, "m", "height above the surface between sites", gt=0.0005, le=0.1
    )
    settle_time: float = setting(
        0.1, "s", "time in contact before a dwell begins", ge=0.02, le=10.0
    )
    tolerance: float = setting(0.0002, "m", "distance at which a site is reached", gt=0.0, le=0.01)
    motion_timeout: float = setting(
        3.0, "s", "longest wait for the robot to arrive after its last setpoint", gt=0.0, le=60.0
    )
    samples_timeout: float = setting(0.5, "s", "longest silence of the driver", ge=0.05, le=60.0)


class ScanStopped(RuntimeError):
    """The scan cannot go on; the message says why."""


class ScanCancelled(Exception):
    """Whoever asked for the scan wants it no more."""


class Scan(Node):
    """Palpates grids on demand, as the action ``scan_grid``; one at a time.

    Each site is announced on ``palpation_site``: APPROACH when the way to it begins, DWELL with
    the time at which the dwell will begin (``settle_time`` ahead, so that everyone hears of it in
    time), LIFTED with the time at which it ended. Times are those of the samples' stamps, not of
    this machine's clock. Whatever ends a scan, the probe is lifted.
    """

    def __init__(self) -> None:
        super().__init__("scan")
        declare(self, ScanSettings, live=ScanSettings.model_fields.keys() - {"robot", "frame_id"})
        self._settings = read(self, ScanSettings)
        # A scan goes on as it began: it takes new values when the next one begins.
        follow_changes(self, {"": ScanSettings}, on_change=lambda: None)
        robot = self._settings.robot.rstrip("/")
        self._position: FloatArray | None = None
        self._orientation = Quaternion()
        self._state: OperatingState | None = None
        self._heard_samples = -np.inf
        self._sample_time = 0
        self._malformed = 0
        self._busy = threading.Lock()
        self._sites = self.create_publisher(msg.PalpationSite, "palpation_site", ANNOUNCEMENTS)
        self._setpoints = self.create_publisher(PoseStamped, f"{robot}/servo_cp", POSES)
        # Emptied by the scan itself at each step: only the latest pose counts, and of the samples
        # that they come, and when.
        self._inbox = Inbox(self)
        self._inbox.subscribe(PoseStamped, f"{robot}/measured_cp", LATEST, self._on_pose)
        self._inbox.subscribe(OperatingState, f"{robot}/operating_state", LATEST, self._on_state)
        self._inbox.subscribe(msg.ProbeSamples, "samples", LATEST, self._on_samples, raw=True)
        self._server = ActionServer(
            self,
            ScanGrid,
            "scan_grid",
            execute_callback=self._execute,
            goal_callback=self._judge,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )
        Diagnostics(self, self._examine)

    def destroy_node(self) -> None:
        """End the action server, then the node."""
        self._server.destroy()
        self._inbox.destroy()
        super().destroy_node()

    def _on_pose(self, message: PoseStamped, info: dict) -> None:
        try:
            self._position = np.array(place_from_message(message))
        except ValueError as error:
            self._leave_out("a pose of the robot", error)
            return
        self._orientation = message.pose.orientation

    def _on_state(self, message: OperatingState, info: dict) -> None:
        self._state = message

    def _on_samples(self, message: bytes, info: dict) -> None:
        try:
            block, _ = samples_from_cdr(message)
        except ValueError as error:
            self._leave_out("a block", error)
            return
        self._heard_samples = time.monotonic()
        self._sample_time = block.end

    def _leave_out(self, what: str, why: ValueError) -> None:
        self._malformed += 1
        self.get_logger().error(f"{what} is left out: {why}", throttle_duration_sec=1.0)

    def _judge(self, goal: ScanGrid.Goal) -> GoalResponse:
        try:
            _grid_of(goal)
        except ValueError as error:
            self.get_logger().error(f"the scan is refused: {error}")
            return GoalResponse.REJECT
        if self._busy.locked():
            self.get_logger().error("the scan is refused: another one is under way")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _execute(self, goal_handle: ServerGoalHandle) -> ScanGrid.Result:
        with self._busy:
            grid, dwell_time = _grid_of(goal_handle.request), goal_handle.request.dwell_time
            result = ScanGrid.Result()
            self._settings = read(self, ScanSettings)
            try:
                self._wait_for_robot_and_driver(goal_handle)
                for site in range(len(grid)):
                    self._palpate(goal_handle, grid, site, dwell_time)
                    result.sites_visited = site + 1
                result.message = f"all {len(grid)} sites are palpated"
                goal_handle.succeed()
            except ScanCancelled:
                result.message = _ended("cancelled", result.sites_visited, grid)
                goal_handle.canceled()
            except ScanStopped as reason:
                result.message = _ended(f"stopped: {reason}", result.sites_visited, grid)
                goal_handle.abort()
            self.get_logger().info(result.message)
            return result

    def _wait_for_robot_and_driver(self, goal_handle: ServerGoalHandle) -> None:
        """Give those who have only just been found the time to be heard."""
        self._inbox.empty()  # what came before the scan is old
        self._position, self._heard_samples = None, -np.inf
        patience = max(self._settings.motion_timeout, self._settings.samples_timeout)
        deadline = time.monotonic() + patience
        while self._missing() and time.monotonic() < deadline:
            time.sleep(INTERVAL)
        self._check(goal_handle)
        # The robot holds the probe as it does now: setpoints move it, and do not turn it.
        self._held = self._orientation

    def _palpate(self, goal_handle, grid: Grid, site: int, dwell_time: float) -> None:
        """Approach one site, dwell, and lift; lift too if anything stops the scan in between."""
        surface = np.array(grid.position(site))
        above = surface + np.array([0.0, 0.0, self._settings.lift_height])

        def announce(phase: Phase, stamp: int) -> None:
            announcement = PalpationSite(stamp, site, grid.position(site), phase)
            message = site_to_message(announcement, self._settings.frame_id)
            self._sites.publish(message)
            goal_handle.publish_feedback(
                ScanGrid.Feedback(
                    sites_visited=site + (phase == Phase.LIFTED),
                    sites_total=len(grid),
                    site=message,
                )
            )

        self._check(goal_handle)
        announce(Phase.APPROACH, self._now())
        self._move(goal_handle, above)
        try:
            self._move(goal_handle, surface)
            begin = self._now() + round(self._settings.settle_time * NANOSECONDS)
            announce(Phase.DWELL, begin)
            end = begin + round(dwell_time * NANOSECONDS)
            self._dwell(goal_handle, surface, self._settings.settle_time + dwell_time)
        except (ScanCancelled, ScanStopped):
            end = self._now()
            raise
        finally:
            announce(Phase.LIFTED, end)
            self._lift(above)

    def _dwell(self, goal_handle, position: FloatArray, duration: float) -> None:
        pacer = Pacer(INTERVAL)
        for tick in range(1, round(duration / INTERVAL) + 1):
            pacer.wait_for(tick)
            self._check(goal_handle)
            self._command(position)

    def _move(self, goal_handle, target: FloatArray) -> None:
        """Send setpoints along the straight line to ``target``, and wait until it is reached."""
        start = self._position
        steps = int(np.ceil(np.linalg.norm(target - start) / (self._settings.speed * INTERVAL)))
        pacer = Pacer(INTERVAL)
        for step in range(1, steps + 1):
            pacer.wait_for(step)
            self._check(goal_handle)
            self._command(start + (target - start) * (step / steps))
        deadline = time.monotonic() + self._settings.motion_timeout
        while np.linalg.norm(self._position - target) > self._settings.tolerance:
            if time.monotonic() > deadline:
                raise ScanStopped(
                    f"the robot {self._settings.robot} did not reach {_millimetres(target)} within "
                    f"{self._settings.motion_timeout:g} s; it is at {_millimetres(self._position)}"
                )
            steps += 1
            pacer.wait_for(steps)
            self._check(goal_handle)
            self._command(target)

    def _lift(self, above: FloatArray) -> None:
        """Send the probe straight up, whatever the robot says meanwhile."""
        start = self._position
        steps = int(np.ceil(np.linalg.norm(above - start) / (self._settings.speed * INTERVAL)))
        pacer = Pacer(INTERVAL)
        for step in range(1, steps + 1):
            pacer.wait_for(step)
            self._command(start + (above - start) * (step / steps))

    def _check(self, goal_handle: ServerGoalHandle) -> None:
        if goal_handle.is_cancel_requested:
            raise ScanCancelled
        if missing := self._missing():
            raise ScanStopped(missing)

    def _missing(self) -> str:
        """Say which part that a scan needs is silent; nothing if all are heard."""
        self._inbox.empty()
        if self._position is None:
            return f"the robot says nothing on {self._settings.robot}/measured_cp"
        if self._state is not None and self._state.state != ENABLED:
            return (
                f"the robot {self._settings.robot} is {self._state.state}: it moves only when it "
                f"is {ENABLED}"
            )
        if self._state is not None and not self._state.is_homed:
            return f"the robot {self._settings.robot} is not homed"
        silence = time.monotonic() - self._heard_samples
        if silence > self._settings.samples_timeout:
            return (
                f"no samples for {self._settings.samples_timeout:g} s on "
                f"{self.resolve_topic_name('samples')}: is the driver running and active?"
            )
        return ""

    def _command(self, position: FloatArray) -> None:
        if not self.context.ok():
            raise ScanStopped("the node is shut down")
        setpoint = PoseStamped()
        setpoint.header.stamp = self.get_clock().now().to_msg()
        setpoint.header.frame_id = self._settings.frame_id
        point = setpoint.pose.position
        point.x, point.y, point.z = map(float, position)
        setpoint.pose.orientation = self._held
        self._setpoints.publish(setpoint)

    def _examine(self) -> Health:
        doing = "scanning" if self._busy.locked() else "waiting for a goal"
        values = {
            "subscribers": self._sites.get_subscription_count(),
            "messages malformed": self._malformed,
        }
        return Health(OK, doing, values)

    def _now(self) -> int:
        """Return the time as the samples' stamps tell it: no clock's step or offset matters."""
        since = time.monotonic() - self._heard_samples
        return self._sample_time + round(since * NANOSECONDS)


def _grid_of(goal: ScanGrid.Goal) -> Grid:
    if not 0.0 < goal.dwell_time <= 3600.0:
        raise ValueError(f"dwell_time is {goal.dwell_time} s; give a time up to 3600 s")
    origin = (goal.origin.x, goal.origin.y, goal.origin.z)
    return Grid(origin, goal.spacing, goal.rows, goal.columns)


def _ended(how: str, visited: int, grid: Grid) -> str:
    return f"{how} ({visited} of {len(grid)} sites are palpated)"


def _millimetres(position: FloatArray) -> str:
    return "(" + ", ".join(f"{1e3 * value:.2f}" for value in position) + ") mm"


def main() -> int:
    """Run the scan node."""
    return run(Scan, MultiThreadedExecutor)


if __name__ == "__main__":
    raise SystemExit(main())
