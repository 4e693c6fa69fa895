"""The scan node: moves the probe from site to site, and says where it is palpating."""

from __future__ import annotations

import math
import threading
import time
import traceback
from collections.abc import Callable
from functools import partial
from typing import Any, Literal

import numpy as np
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import SetBool

from tissue_probe.devices.limits import PALPATION_LEASE
from tissue_probe.errors import TissueProbeError
from tissue_probe.estimation.layout import TEST_TIME
from tissue_probe.mapping.leaving import DwellEvidence
from tissue_probe.mapping.touch import Touch
from tissue_probe.nodes.cdr import estimate_from_cdr, samples_from_cdr
from tissue_probe.nodes.contact import ContactSettings, NotTouched, lower_to_contact
from tissue_probe.nodes.conversions import site_to_message
from tissue_probe.nodes.diagnostics import OK, Diagnostics, Health
from tissue_probe.nodes.erring_sites import ErringSites
from tissue_probe.nodes.exploration import ExploredSites
from tissue_probe.nodes.fused_estimators import FusedEstimators
from tissue_probe.nodes.hearing import DISCOVERY_TIME
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.own_time import OwnTime
from tissue_probe.nodes.parameters import declare, follow_changes, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import SAMPLE_BLOCKS, SCAN_ANNOUNCEMENTS
from tissue_probe.nodes.robot import SETPOINT_INTERVAL, NotMoved, Robot, RobotSettings
from tissue_probe.nodes.scan_sources import (
    Choosing,
    GivenSites,
    GridSites,
    Site,
    Source,
    SourceKind,
)
from tissue_probe.nodes.site_outcomes import SiteOutcomes
from tissue_probe.settings import setting
from tissue_probe.signals import NANOSECONDS, FloatArray, Leaving, PalpationSite, Phase
from tissue_probe_msgs import msg

#: Longest time that the node takes to end a scan when it is told to end itself [s]: ros2 launch
#: kills a process ten seconds after Ctrl-C.
ENDING = 8.0
#: Longest time for the last announcements to reach everyone, and for the result to be sent [s].
LONGEST_ANNOUNCEMENT_WAIT = 0.5
#: In the time in which the scan has promised a sign of life it gives so many [-].
SIGNS = 10
#: Whose sites a scan may palpate: each has an action of its own.
SOURCES: tuple[SourceKind, ...] = (GridSites, GivenSites, ExploredSites)


class ScanSettings(ContactSettings, RobotSettings, FusedEstimators, ErringSites):
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
    explore_for: Literal["edge", "find", "both"] = setting(
        "both", "", "purpose of explore's sites: edges, inclusions unseen yet, both in turn"
    )
    most_again: float = setting(
        0.1,
        "",
        "share of its sites that scan_sites palpates again at most, a little aside, where an "
        "inclusion hangs on one site and `outliers` says that sites err",
        ge=0.0,
        le=1.0,
    )


#: Settings that topics follow from.
_FIXED = {"robot", "frame_id", "estimators"}


class ScanStopped(RuntimeError):
    """The scan cannot go on; the message says why."""


class ScanCancelled(Exception):
    """The client of the scan has cancelled it."""


#: Errors by which a scan can be stopped; any other is a fault of ours.
SCAN_FAILURES = (ScanStopped, ScanCancelled, NotMoved, NotTouched, TissueProbeError)


class Scan(Node):
    """Palpates sites on demand, one scan at a time.

    Three actions ask for one: ``scan_grid`` for a grid, ``scan_sites`` for a list, ``explore`` for
    sites that are chosen on the way. The service ``~/pause`` (std_srvs/SetBool) holds the scan
    under way between two sites, with the probe up, and lets it go on.

    Each site is announced on ``palpation_site``: APPROACH when the way to it begins, DWELL with
    the time at which the dwell will begin (``settle_time`` ahead, so that everyone hears of it in
    time), LIFTED when the robot has shown that the probe is up, with the time at which the dwell
    ended and why. Times are those of the samples' stamps, not of this machine's clock. A dwell ends
    when the estimators have told enough (``mapping.leaving``), at last after the goal's time.

    At any end of a scan the probe is lifted first, then others are told. From APPROACH to LIFTED
    the loop that moves the probe asserts the liveliness of the announcements; where that ceases,
    or the node ends without LIFTED, the driver puts the coil at zero (``scan_watch``).
    """

    def __init__(self) -> None:
        super().__init__("scan")
        declare(self, ScanSettings, live=ScanSettings.model_fields.keys() - _FIXED)
        self._settings = read(self, ScanSettings)
        # A scan goes on as it began: it takes new values when the next one begins.
        follow_changes(self, {"": ScanSettings}, on_change=lambda: None)
        self._created = time.monotonic()
        self._own_time = OwnTime()
        self._forget_samples()
        self._sample_time = 0
        self._paused = threading.Event()
        self._told: DwellEvidence | None = None
        self._touch: Touch | None = None
        self._malformed = 0
        self._busy = threading.Lock()
        self._told_to_end = threading.Event()
        self._last_sign = -np.inf
        self._sites = self.create_publisher(msg.PalpationSite, "palpation_site", SCAN_ANNOUNCEMENTS)
        # Emptied by the scan itself at each step.
        self._inbox = Inbox(self)
        self._samples = self._inbox.subscribe(
            msg.ProbeSamples, "samples", SAMPLE_BLOCKS, self._on_samples, raw=True
        )
        for name in self._settings.estimators:
            topic = f"{name}/estimate"
            self._inbox.subscribe(
                msg.TissueEstimate, topic, SAMPLE_BLOCKS, self._on_estimate, raw=True
            )
        self._robot = Robot(self, self._inbox, self._settings, self._show_alive, self._own_time)
        self._outcomes = SiteOutcomes(self, self._inbox)
        self._servers = [
            ActionServer(
                self,
                kind.ACTION,
                kind.NAME,
                execute_callback=partial(self._execute, kind),
                goal_callback=partial(self._judge, kind),
                cancel_callback=lambda goal: CancelResponse.ACCEPT,
                callback_group=ReentrantCallbackGroup(),
            )
            for kind in SOURCES
        ]
        self.create_service(
            SetBool, "~/pause", self._pause, callback_group=ReentrantCallbackGroup()
        )
        Diagnostics(self, self._examine)

    def destroy_node(self) -> None:
        """Lift the probe and end the scan under way, then the action servers, then the node."""
        self._end()
        for server in self._servers:
            server.destroy()
        self._inbox.destroy()
        super().destroy_node()

    def _end(self) -> None:
        """Let the scan under way lift the probe and tell its end; no other begins."""
        self._told_to_end.set()
        was_scanning = self._busy.locked()
        if not self._busy.acquire(timeout=ENDING):
            self.get_logger().fatal(f"the scan did not end within {ENDING:g} s: look at the probe")
        elif was_scanning and self.context.ok():
            self._sites.wait_for_all_acked(Duration(seconds=LONGEST_ANNOUNCEMENT_WAIT))
            deadline, executor = time.monotonic() + LONGEST_ANNOUNCEMENT_WAIT, self.executor
            while executor is not None and time.monotonic() < deadline:  # it sends the result
                executor.spin_once(timeout_sec=SETPOINT_INTERVAL)

    def _on_samples(self, message: bytes, info: dict[str, int]) -> None:
        try:
            block, _ = samples_from_cdr(message)
        except ValueError as error:
            self._leave_out("a block", error)
            return
        self._heard_samples, self._samples_heard = time.monotonic(), self._own_time()
        self._sample_time = block.end
        if self._told is not None:
            self._told.add_samples(block)
        if self._touch is not None:
            self._touch.add_samples(block)

    def _on_estimate(self, message: bytes, info: dict[str, int]) -> None:
        if self._told is None:
            return
        try:
            estimator, status, estimate, _ = estimate_from_cdr(message)
            self._told.add_estimate(estimator, status, estimate)
        except ValueError as error:
            self._leave_out("an estimate", error)

    def _leave_out(self, what: str, why: ValueError) -> None:
        self._malformed += 1
        self.get_logger().error(f"{what} is left out: {why}", throttle_duration_sec=1.0)

    def _pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        (self._paused.set if request.data else self._paused.clear)()
        doing = "holds before the next site" if request.data else "goes on"
        response.success = self._busy.locked()
        response.message = f"the scan {doing}" if response.success else "no scan is under way"
        return response

    def _judge(self, kind: SourceKind, goal: Any) -> GoalResponse:
        # First, since a goal's imports would hold up the scan under way.
        if self._busy.locked():
            self.get_logger().error("the scan is refused: another one is under way")
            return GoalResponse.REJECT
        try:
            kind(goal, self._outcomes)
        except ValueError as error:
            self.get_logger().error(f"the scan is refused: {error}")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _execute(self, kind: SourceKind, goal_handle: ServerGoalHandle) -> Any:
        if not self._busy.acquire(blocking=False):  # two goals may be accepted at the same time
            goal_handle.abort()
            told = "refused: another scan is under way, or the node ends"
            return kind.ACTION.Result(message=told)
        try:
            self._paused.clear()
            return self._scan(kind(goal_handle.request, self._outcomes), goal_handle)
        finally:
            self._busy.release()

    def _scan(self, source: Source, goal_handle: ServerGoalHandle) -> Any:
        """Palpate the sites; return how it ended, once the probe is lifted."""
        self._settings = self._robot.settings = read(self, ScanSettings)
        source.choosing = Choosing(
            self._settings.explore_for, self._settings.outliers, self._settings.most_again
        )
        wait = partial(self._wait, partial(self._check, goal_handle))
        try:
            self._refuse_second_scan()
            source.prepare(partial(self._wait, partial(self._check_wanted, goal_handle)))
            self._wait_for_robot_and_driver(goal_handle)
            while (site := source.next(wait)) is not None:
                wait(lambda: not self._paused.is_set(), math.inf)
                self._visit(goal_handle, source, site)
            if source.begins:
                self._settle(source, goal_handle)
            end, how = goal_handle.succeed, source.ended()
        except ScanCancelled as reason:
            end, how = goal_handle.canceled, str(reason)
        except Exception as reason:  # someone must hear of any error
            end, how = goal_handle.abort, f"stopped: {_told(reason)}"
            if not isinstance(reason.__cause__ or reason, SCAN_FAILURES):
                self.get_logger().error(traceback.format_exc())
        if end != goal_handle.succeed and (so_far := source.so_far()):
            how += f" ({so_far})"
        result = source.result(how)
        end()
        self.get_logger().info(result.message)
        return result

    def _visit(self, goal_handle: ServerGoalHandle, source: Source, site: Site) -> None:
        """Palpate a site; one without a surface, or that is not reached, may be left out."""
        try:
            self._palpate(goal_handle, source, site)
        except NotTouched as reason:
            self.get_logger().warning(f"site {site.number} is left: {reason}")
            if not source.not_touched(site):
                raise
        except NotMoved:
            if not source.not_reached(site):
                raise

    def _wait(
        self, check: Callable[[], None], condition: Callable[[], bool], timeout: float
    ) -> bool:
        """Wait until a condition holds, at most so long [s], unless ``check`` raises."""
        deadline = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > deadline:
                return False
            check()
            time.sleep(SETPOINT_INTERVAL)
        return True

    def _wait_for_robot_and_driver(self, goal_handle: ServerGoalHandle) -> None:
        """Give those who have only just been found the time to be heard."""
        self._inbox.empty()  # messages from before the scan are old
        self._robot.forget()
        self._forget_samples()
        patience = max(self._settings.motion_timeout, self._settings.samples_timeout)
        deadline = time.monotonic() + patience
        while self._missing() and time.monotonic() < deadline:
            self._check_wanted(goal_handle)
            time.sleep(SETPOINT_INTERVAL)
        self._check(goal_handle)
        self._robot.hold_orientation()

    def _settle(self, source: Source, goal_handle: ServerGoalHandle) -> None:
        """Give estimators and mapper the time to judge the last site, while the node may."""
        deadline = time.monotonic() + self._settings.map_timeout
        while time.monotonic() < deadline and not source.is_judged():
            self._inbox.empty()
            if goal_handle.is_cancel_requested or self._told_to_end.is_set():
                return
            time.sleep(SETPOINT_INTERVAL)

    def _palpate(self, goal_handle: ServerGoalHandle, source: Source, site: Site) -> None:
        """Approach one site, dwell, and lift; lift too if anything ends it in between.

        Where contact is searched, the site's position is the measured one from the dwell on.
        """
        surface, normal = np.array(site.position), np.array(site.normal)
        above = surface + self._settings.lift_height * normal
        check = partial(self._check, goal_handle)

        def announce(phase: Phase, stamp: int, why: Leaving = Leaving.UNTOLD) -> None:
            announced = PalpationSite(stamp, site.number, site.position, phase, why, site.normal)
            message = site_to_message(announced, self._settings.frame_id)
            self._sites.publish(message)
            goal_handle.publish_feedback(source.feedback(message))

        check()
        try:
            announce(Phase.APPROACH, self._now())
            self._robot.move(above, check)
            surface = self._lower(surface, normal, check)
            x, y, z = map(float, surface)
            site = site._replace(position=(x, y, z))
            begin = self._now() + round(self._settings.settle_time * NANOSECONDS)
            self._told = told = DwellEvidence(begin, TEST_TIME)
            announce(Phase.DWELL, begin)
            source.dwelling(site, begin)
            longest = begin + round(source.dwell_time * NANOSECONDS)
            end, why = self._dwell(told, longest, check)
        except BaseException as reason:
            self._told = None
            end = self._now()
            self._lift(surface, normal, reason)
            why = reason.leaving if isinstance(reason, NotTouched) else Leaving.STOPPED
            announce(Phase.LIFTED, end, why)
            raise
        self._told = None
        self._lift(surface, normal)
        source.palpated(site)
        announce(Phase.LIFTED, end, why)

    def _lower(
        self, surface: FloatArray, normal: FloatArray, check: Callable[[], None]
    ) -> FloatArray:
        """Go down to the surface, as given or as felt; return where it is [m]."""
        if not self._settings.contact_search:
            self._robot.move(surface, check)
            return surface
        self._touch = Touch(self._settings.contact_force)
        try:
            return lower_to_contact(
                self._robot, self._touch, surface, normal, self._settings, check, self._now
            )
        finally:
            self._touch = None

    def _dwell(
        self, told: DwellEvidence, end: int, check: Callable[[], None]
    ) -> tuple[int, Leaving]:
        """Stay until enough is told, or the samples have reached the time ``end`` [ns].

        Return when the dwell ended, and why. Where the driver is late, its samples show the tip
        where it is now, under an earlier stamp.

        Raises
        ------
        ScanStopped
            If the samples fall behind by ``samples_timeout``.
        """
        patience = self._settings.samples_timeout
        left = (end - self._now()) / NANOSECONDS
        due, latest = time.monotonic() + left, self._own_time() + left + patience
        enough: int | None = None

        def is_over() -> bool:
            nonlocal enough
            enough = told.enough()
            if enough is not None and enough < end:
                return True
            if self._sample_time < end and self._own_time() > latest:
                late = time.monotonic() - due + (end - self._sample_time) / NANOSECONDS
                raise ScanStopped(
                    f"the samples on {self.resolve_topic_name('samples')} are {late:.2f} s late, "
                    f"more than {patience:g} s: is the driver's machine too busy?"
                )
            return self._sample_time >= end

        self._robot.hold(is_over, check)
        if enough is not None and enough < end:
            return enough, Leaving.TOLD_ENOUGH
        return end, Leaving.LONGEST

    def _lift(
        self, surface: FloatArray, normal: FloatArray, reason: BaseException | None = None
    ) -> None:
        """Lift the probe, before anything else; ``reason`` is why the scan stops, if it does.

        Raises
        ------
        ScanStopped
            If the probe is not seen to be up; then LIFTED is not said, and the driver stops the
            coil.
        """
        try:
            self._robot.lift(surface, normal, self._settings.lift_height)
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
        if self._own_time() - self._samples_heard > self._settings.samples_timeout:
            silence = time.monotonic() - self._heard_samples
            last = f", the last {silence:.2f} s ago" if math.isfinite(silence) else ""
            return (
                f"no samples for {self._settings.samples_timeout:g} s on "
                f"{self.resolve_topic_name('samples')}{last} ({self._samples.why_silent()}): is "
                "the driver running and active?"
            )
        return ""

    def _forget_samples(self) -> None:
        """Count the driver as silent until samples come."""
        self._heard_samples = self._samples_heard = -np.inf

    def _refuse_second_scan(self) -> None:
        # A node that has only just started has not heard of all the others.
        time.sleep(max(0.0, self._created + DISCOVERY_TIME - time.monotonic()))
        until = time.monotonic() + DISCOVERY_TIME  # nor has one that another has only just joined
        while not self._robot.others_are_known() and time.monotonic() < until:
            time.sleep(DISCOVERY_TIME / 20)
        if others := self._robot.others():
            raise ScanStopped(
                f"{', '.join(others)} could palpate with the robot {self._robot.name} too: two "
                "scan nodes would draw one probe to and fro; stop the other"
            )

    def _examine(self) -> Health:
        doing = "scanning" if self._busy.locked() else "waiting for a goal"
        values: dict[str, object] = {
            "subscribers": self._sites.get_subscription_count(),
            "messages malformed": self._malformed + self._robot.malformed,
        }
        return Health(OK, doing, values)

    def _now(self) -> int:
        """Return the time as the samples' stamps tell it: no clock's step or offset matters."""
        since = time.monotonic() - self._heard_samples
        return self._sample_time + round(since * NANOSECONDS)


def _told(reason: BaseException) -> str:
    """Say why a scan stops."""
    if isinstance(reason, SCAN_FAILURES):
        return str(reason)
    return f"a fault of the scan node, {type(reason).__name__}: {reason}"


def main() -> int:
    """Run the scan node."""
    # One thread for the scan, others for its cancelling and further requests meanwhile.
    return run(Scan, partial(MultiThreadedExecutor, num_threads=3))


if __name__ == "__main__":
    raise SystemExit(main())
