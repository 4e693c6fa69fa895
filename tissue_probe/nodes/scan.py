"""The scan node: moves the probe from site to site, and says where it is palpating."""

from __future__ import annotations

import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node

from tissue_probe.devices.limits import PALPATION_LEASE
from tissue_probe.estimation.layout import TEST_TIME
from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.leaving import Told
from tissue_probe.nodes.cdr import estimate_from_cdr, samples_from_cdr
from tissue_probe.nodes.conversions import site_to_message
from tissue_probe.nodes.diagnostics import OK, Diagnostics, Health
from tissue_probe.nodes.fused_estimators import FusedEstimators
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.parameters import declare, follow_changes, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import BLOCKS, SCAN_ANNOUNCEMENTS
from tissue_probe.nodes.robot import INTERVAL, NotMoved, Robot, RobotSettings
from tissue_probe.nodes.site_verdicts import SiteVerdicts
from tissue_probe.settings import setting
from tissue_probe.signals import NANOSECONDS, Leaving, PalpationSite, Phase
from tissue_probe_msgs import msg
from tissue_probe_msgs.action import ScanGrid

#: Longest time that the node takes to end a scan when it is told to end itself [s]: ros2 launch
#: kills a process ten seconds after Ctrl-C.
ENDING = 8.0
#: Longest time for the last announcements to reach everyone, and for the result to be sent [s].
DELIVERY = 0.5
#: In the time in which the scan has promised a sign of life it gives so many [-].
SIGNS = 10
#: So many sites without estimate are named in the message; all are in the result.
NAMED = 10


class ScanSettings(RobotSettings, FusedEstimators):
    """How the probe is moved, and how long is waited for whom."""

    lift_height: float = setting(
        0.003, "m", "height above the surface between sites", gt=0.0005, le=0.1
    )
    settle_time: float = setting(
        0.1, "s", "time in contact before a dwell begins", ge=0.02, le=10.0
    )
    samples_timeout: float = setting(0.5, "s", "longest silence of the driver", ge=0.05, le=60.0)
    map_timeout: float = setting(
        2.0, "s", "longest wait for the map to tell of the last site", ge=0.0, le=60.0
    )


#: Settings that topics follow from.
_FIXED = {"robot", "frame_id", "estimators"}


class ScanStopped(RuntimeError):
    """The scan cannot go on; the message says why."""


class ScanCancelled(Exception):
    """Whoever asked for the scan wants it no more."""


#: What a scan can be stopped by; anything else is a fault of ours.
FORESEEN = (ScanStopped, ScanCancelled, NotMoved)


class Scan(Node):
    """Palpates grids on demand, as the action ``scan_grid``; one at a time.

    Each site is announced on ``palpation_site``: APPROACH when the way to it begins, DWELL with
    the time at which the dwell will begin (``settle_time`` ahead, so that everyone hears of it in
    time), LIFTED when the robot has shown that the probe is up, with the time at which the dwell
    ended and why. Times are those of the samples' stamps, not of this machine's clock. A dwell ends
    when the estimators have told enough (``mapping.leaving``), at last after the goal's time.

    Whatever ends a scan, the probe is lifted first, then others are told. From APPROACH to LIFTED
    the loop that moves the probe asserts the liveliness of the announcements; where that ceases,
    or the node ends without LIFTED, the driver puts the coil at zero (``scan_watch``).
    """

    def __init__(self) -> None:
        super().__init__("scan")
        declare(self, ScanSettings, live=ScanSettings.model_fields.keys() - _FIXED)
        self._settings = read(self, ScanSettings)
        # A scan goes on as it began: it takes new values when the next one begins.
        follow_changes(self, {"": ScanSettings}, on_change=lambda: None)
        self._heard_samples = -np.inf
        self._sample_time = 0
        self._dwell_began = 0
        self._told: Told | None = None
        self._malformed = 0
        self._busy = threading.Lock()
        self._told_to_end = threading.Event()
        self._last_sign = -np.inf
        self._sites = self.create_publisher(msg.PalpationSite, "palpation_site", SCAN_ANNOUNCEMENTS)
        # Emptied by the scan itself at each step.
        self._inbox = Inbox(self)
        self._inbox.subscribe(msg.ProbeSamples, "samples", BLOCKS, self._on_samples, raw=True)
        for name in self._settings.estimators:
            topic = f"{name}/estimate"
            self._inbox.subscribe(msg.TissueEstimate, topic, BLOCKS, self._on_estimate, raw=True)
        self._robot = Robot(self, self._inbox, self._settings, self._show_alive)
        self._verdicts = SiteVerdicts(self, self._inbox)
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
        """Lift the probe and end the scan under way, then the action server, then the node."""
        self._end()
        self._server.destroy()
        self._inbox.destroy()
        super().destroy_node()

    def _end(self) -> None:
        """Let the scan under way lift the probe and tell its end; no other begins."""
        self._told_to_end.set()
        was_scanning = self._busy.locked()
        if not self._busy.acquire(timeout=ENDING):
            self.get_logger().fatal(f"the scan did not end within {ENDING:g} s: look at the probe")
        elif was_scanning and self.context.ok():
            self._sites.wait_for_all_acked(Duration(seconds=DELIVERY))
            deadline = time.monotonic() + DELIVERY
            while time.monotonic() < deadline:  # the result is sent by the executor
                self.executor.spin_once(timeout_sec=INTERVAL)

    def _on_samples(self, message: bytes, info: dict) -> None:
        try:
            block, _ = samples_from_cdr(message)
        except ValueError as error:
            self._leave_out("a block", error)
            return
        self._heard_samples = time.monotonic()
        self._sample_time = block.end
        if self._told is not None:
            self._told.add_samples(block)

    def _on_estimate(self, message: bytes, info: dict) -> None:
        if self._told is None:
            return
        try:
            self._told.add_estimate(*estimate_from_cdr(message))
        except ValueError as error:
            self._leave_out("an estimate", error)

    def _leave_out(self, what: str, why: ValueError) -> None:
        self._malformed += 1
        self.get_logger().error(f"{what} is left out: {why}", throttle_duration_sec=1.0)

    def _judge(self, goal: ScanGrid.Goal) -> GoalResponse:
        try:
            _grid_of(goal)
            _sites_of(goal)
        except ValueError as error:
            self.get_logger().error(f"the scan is refused: {error}")
            return GoalResponse.REJECT
        if self._busy.locked():
            self.get_logger().error("the scan is refused: another one is under way")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _execute(self, goal_handle: ServerGoalHandle) -> ScanGrid.Result:
        if not self._busy.acquire(blocking=False):  # two goals may be accepted at the same time
            goal_handle.abort()
            return ScanGrid.Result(message="refused: another scan is under way, or the node ends")
        try:
            return self._scan(goal_handle)
        finally:
            self._busy.release()

    def _scan(self, goal_handle: ServerGoalHandle) -> ScanGrid.Result:
        """Palpate the sites; return how it ended, once the probe is lifted."""
        goal = goal_handle.request
        grid, sites = _grid_of(goal), _sites_of(goal)
        self._settings = self._robot.settings = read(self, ScanSettings)
        visited: list[int] = []
        try:
            self._wait_for_robot_and_driver(goal_handle)
            for site in sites:
                self._palpate(goal_handle, grid, site, len(visited), len(sites))
                visited.append(site)
            self._wait_for_map(goal_handle, [grid.position(site) for site in visited])
            end, how = goal_handle.succeed, f"all {len(sites)} sites are palpated"
        except ScanCancelled as reason:
            end, how = goal_handle.canceled, str(reason)
        except Exception as reason:  # whatever it was, someone must hear of it
            end, how = goal_handle.abort, f"stopped: {_told(reason)}"
            if not isinstance(reason.__cause__ or reason, FORESEEN):
                self.get_logger().error(traceback.format_exc())
        if len(visited) < len(sites):
            how += f" ({len(visited)} of {len(sites)} sites are palpated)"
        result = self._result(grid, visited, how)
        end()
        self.get_logger().info(result.message)
        return result

    def _result(self, grid: Grid, visited: list[int], how: str) -> ScanGrid.Result:
        """Say how the scan ended, and which sites have an estimate as far as the map tells.

        A site of which nothing is known counts as one without: to palpate it again does no harm.
        """
        without = [s for s in visited if not self._verdicts.estimated(grid.position(s))]
        if not visited:
            told = ""
        elif unknown := self._verdicts.unknown():
            told = f"; whether there are estimates is unknown: {unknown}"
        elif without:
            told = f"; {len(without)} of {len(visited)} have no estimate: {_listed(without)}"
        else:
            told = f"; {len(visited)} of {len(visited)} have an estimate"
        return ScanGrid.Result(
            sites_visited=len(visited),
            sites_estimated=len(visited) - len(without),
            sites_without_estimate=without,
            message=how + told,
        )

    def _wait_for_robot_and_driver(self, goal_handle: ServerGoalHandle) -> None:
        """Give those who have only just been found the time to be heard."""
        self._inbox.empty()  # what came before the scan is old
        self._robot.forget()
        self._heard_samples = -np.inf
        patience = max(self._settings.motion_timeout, self._settings.samples_timeout)
        deadline = time.monotonic() + patience
        while self._missing() and time.monotonic() < deadline:
            self._check_wanted(goal_handle)
            time.sleep(INTERVAL)
        self._check(goal_handle)
        self._robot.hold_orientation()

    def _wait_for_map(
        self, goal_handle: ServerGoalHandle, positions: Sequence[tuple[float, float, float]]
    ) -> None:
        """Give estimators and mapper the time to judge the last site, while the node may."""
        deadline = time.monotonic() + self._settings.map_timeout
        while time.monotonic() < deadline and not self._verdicts.nobody_maps():
            self._inbox.empty()
            if goal_handle.is_cancel_requested or self._told_to_end.is_set():
                return
            if self._verdicts.is_final(positions, self._dwell_began):
                return
            time.sleep(INTERVAL)

    def _palpate(
        self, goal_handle: ServerGoalHandle, grid: Grid, site: int, visited: int, total: int
    ) -> None:
        """Approach one site, dwell, and lift; lift too if anything stops the scan in between.

        ``visited`` of ``total`` sites were palpated before.
        """
        surface = np.array(grid.position(site))
        above = surface + np.array([0.0, 0.0, self._settings.lift_height])
        settle_time, dwell_time = self._settings.settle_time, goal_handle.request.dwell_time
        check = partial(self._check, goal_handle)

        def announce(
            phase: Phase, stamp: int, done: int = 0, why: Leaving = Leaving.UNTOLD
        ) -> None:
            announcement = PalpationSite(stamp, site, grid.position(site), phase, why)
            message = site_to_message(announcement, self._settings.frame_id)
            self._sites.publish(message)
            goal_handle.publish_feedback(
                ScanGrid.Feedback(sites_visited=visited + done, sites_total=total, site=message)
            )

        check()
        try:
            announce(Phase.APPROACH, self._now())
            self._robot.move(above, check)
            self._robot.move(surface, check)
            begin = self._dwell_began = self._now() + round(settle_time * NANOSECONDS)
            self._told = Told(begin, TEST_TIME)
            announce(Phase.DWELL, begin)
            end, why = self._dwell(begin + round(dwell_time * NANOSECONDS), check)
        except BaseException as reason:
            self._told = None
            end = self._now()
            self._lift(above[2], reason)
            announce(Phase.LIFTED, end, why=Leaving.STOPPED)
            raise
        self._told = None
        self._lift(above[2])
        announce(Phase.LIFTED, end, done=1, why=why)

    def _dwell(self, end: int, check: Callable[[], None]) -> tuple[int, Leaving]:
        """Stay until enough is told, or the samples have reached the time ``end`` [ns].

        Return when the dwell ended, and why. Where the driver is late, its samples show the tip
        where it is now, under an earlier stamp.

        Raises
        ------
        ScanStopped
            If the samples fall behind by ``samples_timeout``.
        """
        patience = self._settings.samples_timeout
        latest = time.monotonic() + (end - self._now()) / NANOSECONDS + patience
        enough: int | None = None

        def is_over() -> bool:
            nonlocal enough
            enough = self._told.enough()
            if enough is not None and enough < end:
                return True
            if self._sample_time < end and time.monotonic() > latest:
                raise ScanStopped(
                    f"the samples on {self.resolve_topic_name('samples')} are more than "
                    f"{patience:g} s late: is the driver's machine too busy?"
                )
            return self._sample_time >= end

        self._robot.hold(is_over, check)
        if enough is not None and enough < end:
            return enough, Leaving.TOLD_ENOUGH
        return end, Leaving.LONGEST

    def _lift(self, height: float, reason: BaseException | None = None) -> None:
        """Lift the probe, before anything else; ``reason`` is why the scan stops, if it does.

        Raises
        ------
        ScanStopped
            If the probe is not seen to be up; then LIFTED is not said, and the driver stops the
            coil.
        """
        try:
            self._robot.lift(height)
        except Exception as error:
            told = [_told(each) for each in (reason, error) if each is not None]
            raise ScanStopped(
                f"{', and '.join(dict.fromkeys(told))}; the probe is not known to be lifted, so "
                "the driver stops the coil: look at it"
            ) from (reason or error)

    def _show_alive(self) -> None:
        """Assert liveliness, from the loop that moves the probe: if that hangs, this ceases."""
        now = time.monotonic()
        if now - self._last_sign >= PALPATION_LEASE / SIGNS:
            self._sites.assert_liveliness()
            self._last_sign = now

    def _check(self, goal_handle: ServerGoalHandle) -> None:
        self._check_wanted(goal_handle)
        if missing := self._missing():
            raise ScanStopped(missing)

    def _check_wanted(self, goal_handle: ServerGoalHandle) -> None:
        if goal_handle.is_cancel_requested:
            raise ScanCancelled("cancelled")
        if self._told_to_end.is_set():
            raise ScanStopped("the scan node is told to end")

    def _missing(self) -> str:
        """Say which part that a scan needs is silent; nothing if all are heard."""
        self._inbox.empty()
        if missing := self._robot.missing():
            return missing
        silence = time.monotonic() - self._heard_samples
        if silence > self._settings.samples_timeout:
            return (
                f"no samples for {self._settings.samples_timeout:g} s on "
                f"{self.resolve_topic_name('samples')}: is the driver running and active?"
            )
        return ""

    def _examine(self) -> Health:
        doing = "scanning" if self._busy.locked() else "waiting for a goal"
        values = {
            "subscribers": self._sites.get_subscription_count(),
            "messages malformed": self._malformed + self._robot.malformed,
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


def _sites_of(goal: ScanGrid.Goal) -> list[int]:
    """Return the numbers of the sites to palpate, in the order of the way over the grid."""
    count, sites = len(_grid_of(goal)), list(goal.sites)
    if beyond := [site for site in sites if site >= count]:
        raise ValueError(
            f"sites has {_listed(beyond)}; the grid's {count} sites are numbered from 0 to "
            f"{count - 1}"
        )
    if twice := sorted(site for site, n in Counter(sites).items() if n > 1):
        raise ValueError(f"sites has {_listed(twice)} more than once; give each site once")
    return sorted(sites) or list(range(count))


def _listed(sites: Sequence[int]) -> str:
    """Name sites; of many the first ones."""
    named = ", ".join(map(str, sites[:NAMED]))
    return f"{named} and {len(sites) - NAMED} more" if len(sites) > NAMED else named


def _told(reason: BaseException) -> str:
    """Say why a scan stops."""
    if isinstance(reason, FORESEEN):
        return str(reason)
    return f"a fault of the scan node, {type(reason).__name__}: {reason}"


def main() -> int:
    """Run the scan node."""
    # One thread for the scan, others for its cancelling and whatever else is asked meanwhile.
    return run(Scan, partial(MultiThreadedExecutor, num_threads=3))


if __name__ == "__main__":
    raise SystemExit(main())
