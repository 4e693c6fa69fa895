"""The sensor node: the wrench that is left of a robot's force sensor, and its identification.

Contents: hearing pose and wrench, publishing the wrench without load, bias, drift and cable, the
service by which the zero is taken anew, the action `identify_sensor`. It commands nothing: another
node moves the robot, and stops it.
"""

from __future__ import annotations

import threading
from collections import Counter, deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped, WrenchStamped
from pydantic import BaseModel, model_validator
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from tissue_probe.errors import TissueProbeError
from tissue_probe.nodes.diagnostics import ERROR, OK, STALE, WARN, Diagnostics, Health, Rate
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.own_time import OwnTime
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import PER_SAMPLE
from tissue_probe.nodes.timers import every
from tissue_probe.recording.robot.settings import UNIT_ROUNDING
from tissue_probe.sensor.cable import MOST_JOINTS
from tissue_probe.sensor.compensation import Compensation, compensation, load_file
from tissue_probe.sensor.free_air import WRENCH_AXES, FreeAir
from tissue_probe.sensor.identify import Identified, identify
from tissue_probe.sensor.live import WINDOW_MIDDLE, Left, LiveCompensation
from tissue_probe.sensor.sensor_tracks import LOWEST_SAMPLE_RATE, Track, stretches
from tissue_probe.settings import SettingsError, setting
from tissue_probe.signals import LONGEST_SILENCE, NANOSECONDS, sound_stamp
from tissue_probe_msgs.action import IdentifySensor
from tissue_probe_msgs.msg import SensorNumber

WRENCH_LOOK_INTERVAL = 0.005
"""Time between two looks at the messages that have come [s]: a period of most controllers."""
RE_ZERO_TIME = 2.0
"""Of so many seconds the mean is the new zero [s]: its noise is then a tenth of a sample's."""
LEAST_ZERO = 1.0
"""Fewer seconds are none [s]: ``noise_of_zero`` is that of the mean of a second, and noise that is
not white makes a shorter mean worse than by their number."""
STEADY = 2.0
"""A zero is refused where the wrench that is left varies by more than so many times its noise. That
of ``LEAST_ZERO`` at 40 Hz varies by 1.4 times at most by chance; the rest is for inertia."""
SHORTEST, LONGEST = 10.0, 300.0
"""Of an identification [s]: two poses; as many samples as fit into some tens of megabytes."""
FIRST_LOOK = 10.0
"""After so many further seconds of free air feedback tells a verdict [s]: each costs seconds of
computing."""
LONGEST_RE_ZERO_WAIT = 3.0
"""An identification ends where it has come to know no more for so long [s]: more than a controller
restarts its topics in. The node's end waits for it as long: `ros2 launch` waits for 5 s."""
NO_OVERLAP = "pose and wrench come, and their stamps do not overlap: use one clock"


class SensorSettings(BaseModel):
    """The topics, the model, and when the wrench is published."""

    pose: str = setting("/robot/measured_cp", "", "topic of the poses of the sensor's frame")
    wrench: str = setting("/robot/measured_cf", "", "topic of the geometry_msgs/WrenchStamped")
    joints: list[str] = setting(
        [], "", "joints that a cable runs along, three at most; empty: none are heard"
    )
    joint_states: str = setting("/joint_states", "", "topic on which these are told")
    model: str = setting("", "", "YAML file of `tissue_probe sensor`; empty: identify first")
    late: float = setting(
        0.0,
        "s",
        "the wrench is published so long after the pose that belongs to it; with 0.06 its inertia "
        "is most exact",
        ge=0.0,
        le=WINDOW_MIDDLE,
    )

    @model_validator(mode="after")
    def _few_joints(self) -> SensorSettings:
        if len(self.joints) > MOST_JOINTS:
            raise ValueError(f"joints names {len(self.joints)}: give {MOST_JOINTS} at most")
        return self


class KeptTopic:
    """One topic: its stamps and rows while they are kept, and its faults.

    Attributes
    ----------
    kept : list
        Stamps [ns] with rows, while an identification runs.
    faults : Counter
        Messages that were of no use, by the reason.

    Parameters
    ----------
    name : str
        Of the topic.
    now : callable
        Returns the node's own time [s].
    """

    def __init__(self, name: str, now: Callable[[], float]) -> None:
        self.name = name
        self.kept: list[tuple[int, Any]] | None = None
        self.faults: Counter[str] = Counter()
        self.taken = 0
        self._rate = Rate()
        self._now = now
        self._since = now()
        self._same: tuple[int, bytes] = (0, b"")

    def sound(self, header: Any, row: np.ndarray, hangs: bool = False) -> int:
        """Return the stamp of a message [ns]; 0 where it is of no use."""
        stamp = int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)
        try:
            sound_stamp(stamp)
        except ValueError:
            stamp = 0
        if not stamp:
            return self._refuse("has no stamps: its driver must say when it measured")
        if not np.isfinite(row).all():
            return self._refuse("is not finite")
        content = row.tobytes()
        if content != self._same[1]:
            self._same = stamp, content
        elif hangs and row.any() and stamp - self._same[0] > LONGEST_SILENCE:
            return self._refuse("repeats one value to the last bit: does its sensor hang?")
        self.taken += 1
        self._since = self._now()
        if self.kept is not None:
            self.kept.append((stamp, row))
        return stamp

    def _refuse(self, reason: str) -> int:
        self.faults[f"{self.name} {reason}"] += 1
        return 0

    def refuse(self, reason: str) -> None:
        """Count a message that was of no use."""
        self._refuse(reason)

    @property
    def silent(self) -> bool:
        """Whether nothing of use has come for long."""
        return (self._now() - self._since) * NANOSECONDS > LONGEST_SILENCE

    def rate(self) -> float:
        """Return the messages of use a second, since the last call."""
        return self._rate(self.taken)

    def track(self) -> Track:
        """Return the kept rows."""
        kept = list(self.kept or ())
        rows = np.array([row for _, row in kept])
        return Track(np.array([stamp for stamp, _ in kept], dtype=np.int64), rows)


class Growth:
    """Whether an identification comes to know more, in the node's own time."""

    def __init__(self, heard: list[KeptTopic], now: Callable[[], float]) -> None:
        self._heard, self._now = heard, now
        self._known, self._since = 0.0, now()

    def stopped(self, known: float) -> str:
        """Return why the time that is known [s] stands still; nothing before some seconds of it."""
        if known > self._known:
            self._known, self._since = known, self._now()
        if self._now() - self._since < LONGEST_RE_ZERO_WAIT:
            return ""
        if silent := [each.name for each in self._heard if each.silent]:
            return f"nothing of use comes on {' and '.join(silent)}"
        return NO_OVERLAP


class Sensor(Node):
    """Publishes the wrench that is left, and identifies the sensor on request."""

    def __init__(self) -> None:
        super().__init__("sensor")
        declare(self, SensorSettings)
        self._settings = settings = read(self, SensorSettings)
        self._live: LiveCompensation | None = None
        self._models: deque[LiveCompensation] = deque()  # to be used by the timer's next call
        if settings.model:
            self._take_over(_read_model(settings))
        self._left: deque[Left] = deque()
        self._published = 0
        self._frame = ""
        self._rate = Rate()
        self._told = ""
        self._angles: np.ndarray | None = None
        self._before: Counter[str] = Counter()
        self._end = threading.Event()
        self._busy = threading.Lock()
        self._own_clock, self._own_time = OwnTime(), 0.0
        self._publisher = self.create_publisher(WrenchStamped, "compensated", PER_SAMPLE)
        self._inbox = Inbox(self)
        names = settings.pose, settings.wrench, settings.joint_states
        self._pose, self._wrench, self._joints = (KeptTopic(each, self._now) for each in names)
        if settings.joints:
            self._hear(JointState, settings.joint_states, self._take_joints)
        self._hear(PoseStamped, settings.pose, self._take_pose)
        self._hear(WrenchStamped, settings.wrench, self._take_wrench)
        self.create_service(Trigger, "~/re_zero", self._on_zero)
        self._server = ActionServer(
            self,
            IdentifySensor,
            "identify_sensor",
            self._execute,
            goal_callback=self._judge,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )
        every(WRENCH_LOOK_INTERVAL, self, self._work)
        Diagnostics(self, self._examine)
        self.get_logger().info(
            f"hearing {settings.pose} and {settings.wrench}; nothing is commanded"
        )

    def _hear(self, kind: type, topic: str, take: Any) -> None:
        self._inbox.subscribe(kind, topic, PER_SAMPLE, lambda message, info: take(message))

    def _now(self) -> float:
        """Return the time of the timer that takes the messages [s], from any thread."""
        return self._own_time

    def destroy_node(self) -> None:
        """End an identification, let go of the subscriptions, end the node."""
        self._end.set()
        if self._busy.acquire(timeout=LONGEST_RE_ZERO_WAIT):
            self._busy.release()
        self._server.destroy()
        self._inbox.destroy()
        super().destroy_node()

    def _take_joints(self, message: JointState) -> None:
        places = {name: place for place, name in enumerate(message.name)}
        if set(self._settings.joints) <= set(places):
            if len(message.position) < len(message.name):
                self._joints.refuse("has a joint without a position")
                return
            wanted = [message.position[places[name]] for name in self._settings.joints]
            row = np.array(wanted, dtype=np.float64)
            if self._joints.sound(message.header, row):
                self._angles = row

    def _take_pose(self, message: PoseStamped) -> None:
        p, q = message.pose.position, message.pose.orientation
        row = np.array([p.x, p.y, p.z, q.x, q.y, q.z, q.w])
        if not abs(np.linalg.norm(row[3:]) - 1.0) <= UNIT_ROUNDING and np.isfinite(row).all():
            self._pose.refuse("has an orientation that is none: a quaternion has length 1")
            return
        stamp = self._pose.sound(message.header, row)
        if stamp and self._live:
            if not self._cabled:
                self._live.take_pose(stamp, row)
            elif self._angles is not None:
                self._live.take_pose(stamp, np.append(row, self._angles))

    def _take_wrench(self, message: WrenchStamped) -> None:
        f, t = message.wrench.force, message.wrench.torque
        row = np.array([f.x, f.y, f.z, t.x, t.y, t.z])
        stamp = self._wrench.sound(message.header, row, hangs=True)
        if stamp and self._live:
            self._live.take_wrench(stamp, row)
            self._frame = message.header.frame_id

    @property
    def _cabled(self) -> bool:
        """Whether the model has a cable along joints."""
        cable = self._live.model.cable if self._live else None
        return cable is not None and cable.joints > 0

    def _take_over(self, model: Compensation) -> None:
        """Use another model from the next sample on; from any thread."""
        count = model.cable.joints if model.cable else 0
        if count and count != len(self._settings.joints):
            raise SettingsError(
                f"the model has a cable along {count} joints: name them by parameter joints"
            )
        self._models.append(LiveCompensation(model, self._settings.late))

    def _work(self) -> None:
        """Publish the wrenches that have become known."""
        while self._models:
            self._live = self._models.popleft()
            self._left.clear()  # the rests of the model before are no zero of this one
        self._inbox.empty()
        self._own_time = self._own_clock()
        if self._live is None:
            return
        for left in self._live.take_known():
            self._publisher.publish(self._message(left))
            self._published += 1
            if self._left and left.stamp < self._left[-1].stamp:
                self._left.clear()  # the clock was set back
            self._left.append(left)
        while (
            self._left and self._left[-1].stamp - self._left[0].stamp > RE_ZERO_TIME * NANOSECONDS
        ):
            self._left.popleft()

    def _message(self, left: Left) -> WrenchStamped:
        message = WrenchStamped()
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(left.stamp, NANOSECONDS)
        message.header.frame_id = self._frame
        force, torque = message.wrench.force, message.wrench.torque
        force.x, force.y, force.z, torque.x, torque.y, torque.z = map(float, left.wrench)
        return message

    def _on_zero(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Take the bias anew, in free air."""
        left = list(self._left)
        seconds = (left[-1].stamp - left[0].stamp) / NANOSECONDS if left else 0.0
        if self._live is None or seconds < LEAST_ZERO:
            response.message = f"{seconds:.1f} s of wrench are known: identify, wait, try again"
            return response
        model = self._live.model
        biased = np.array([each.biased for each in left])
        varies = biased.std(axis=0) / model.noise
        if varies.max() > STEADY:
            response.message = (
                f"{WRENCH_AXES[int(varies.argmax())]} varies by {varies.max():.1f} times its "
                "noise: lift the tool off everything, hold it, then take the zero"
            )
            return response
        middle = (left[0].stamp + left[-1].stamp) // 2
        before, _ = model.predict_bias(middle)
        self._live.model = model.with_zero(biased.mean(axis=0), seconds, middle)
        moved = biased.mean(axis=0) - before
        self._left.clear()
        response.success = True
        response.message = "the zero moved by " + ", ".join(
            f"{name} {value:.3g}" for name, value in zip(WRENCH_AXES, moved, strict=True)
        )
        return response

    def _judge(self, goal: IdentifySensor.Goal) -> GoalResponse:
        if not SHORTEST <= goal.seconds <= LONGEST:
            self.get_logger().error(
                f"{goal.seconds:g} s of free air are asked for: give {SHORTEST:g} to {LONGEST:g}"
            )
            return GoalResponse.REJECT
        if self._busy.locked():
            self.get_logger().error("an identification is under way: wait for it, or cancel it")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _execute(self, goal: ServerGoalHandle) -> IdentifySensor.Result:
        result = IdentifySensor.Result()
        if not self._busy.acquire(blocking=False):
            goal.abort()
            result.message = "an identification is under way"
            return result
        heard = [self._pose, self._wrench, *([self._joints] if self._settings.joints else [])]
        try:
            for each in heard:
                each.kept = []
            return self._identified(goal, heard, result)
        except TissueProbeError as error:
            goal.abort()
            result.message = str(error)
            return result
        finally:
            for each in heard:
                each.kept = None
            self._busy.release()

    def _identified(
        self, goal: ServerGoalHandle, heard: list[KeptTopic], result: IdentifySensor.Result
    ) -> IdentifySensor.Result:
        looked, growth = FIRST_LOOK, Growth(heard, self._now)
        while (seconds := _known(heard)) < goal.request.seconds:
            if goal.is_cancel_requested:
                goal.canceled()
                result.message = f"cancelled after {seconds:.1f} s"
                return result
            stopped = "the node ends" if self._end.wait(0.2) else growth.stopped(seconds)
            if stopped:
                goal.abort()
                result.message = f"ended after {seconds:.1f} s: {stopped}"
                return result
            feedback = IdentifySensor.Feedback(seconds=seconds)
            if seconds > looked:
                looked = seconds + FIRST_LOOK
                with suppress(TissueProbeError):  # too little so far is no fault of all of it
                    so_far = identify(_stretches(_tracks(heard)))
                    feedback.verdict, feedback.missing_poses = so_far.verdict, so_far.missing_poses
            goal.publish_feedback(feedback)
        tracks = _tracks(heard)
        origin = int(min(track.stamps[0] for track in tracks))
        runs = _stretches(tracks, origin)
        found = identify(runs)
        model = compensation(found, runs, origin)
        _fill(result, found, model)
        if found.verdict != "cannot tell":
            self._take_over(model)
        used = "used from now on" if found.verdict != "cannot tell" else "not used"
        result.message = f"{found.verdict}, of {_known(heard):.1f} s; the model is {used}"
        goal.succeed()
        return result

    def _examine(self) -> Health:
        rate, poses = self._rate(self._published), self._pose.rate()
        level, message = self._judged(rate, poses)
        faults = self._pose.faults + self._wrench.faults + self._joints.faults
        new = [f"{reason}; left out" for reason in faults if faults[reason] > self._before[reason]]
        self._before = Counter(faults)
        if new and level == OK:
            level = WARN
        if message != self._told and level != OK:
            self.get_logger().warning(message)
        self._told = message
        values: dict[str, object] = {
            "publishers": self._inbox.publishers(),
            "published": self._published,
            "wrenches [messages/s]": f"{rate:.0f}",
            f"{self._pose.name} [messages/s]": f"{poses:.0f}",
            f"{self._wrench.name} [messages/s]": f"{self._wrench.rate():.0f}",
        }
        if self._left:
            for name, each in zip(WRENCH_AXES, self._left[-1].deviation, strict=True):
                values[f"deviation of {name}"] = f"{each:.3g}"
        return Health(level, "; ".join([message, *new]), values)

    def _judged(self, rate: float, poses: float) -> tuple[bytes, str]:
        needed = [self._pose, self._wrench, *([self._joints] if self._cabled else [])]
        silent = [each.name for each in needed if each.silent]
        if silent:
            return STALE, f"nothing of use comes on {' and '.join(silent)}"
        if self._live is None:
            return WARN, "there is no model: identify the sensor, or give parameter model"
        if not rate and poses < LOWEST_SAMPLE_RATE:
            return (
                ERROR,
                f"poses come {poses:.3g} times a second: {LOWEST_SAMPLE_RATE:g} or more are needed",
            )
        if not rate:
            return ERROR, NO_OVERLAP
        if self._left:
            over = self._left[-1].moved / self._live.model.range
            if over.max() > 1.0:
                return WARN, f"the arm moves {over.max():.1f} times as fast as when identified"
        return OK, "compensating"


def _read_model(settings: SensorSettings) -> Compensation:
    try:
        return load_file(settings.model)
    except TissueProbeError as error:
        raise SettingsError(f"parameter model: {error}") from None


def _known(heard: list[KeptTopic]) -> float:
    """Return how long all topics have been heard [s]."""
    spans = [each.kept for each in heard]
    if not all(spans):
        return 0.0
    first = max(span[0][0] for span in spans if span)
    return max(0.0, (min(span[-1][0] for span in spans if span) - first) / NANOSECONDS)


def _tracks(heard: list[KeptTopic]) -> list[Track]:
    return [each.track() for each in heard]


def _stretches(tracks: list[Track], origin: int | None = None) -> list[FreeAir]:
    poses, wrenches, *joints = tracks
    return stretches(poses, wrenches, joints[0] if joints else None, origin)


def _fill(result: IdentifySensor.Result, found: Identified, model: Compensation) -> None:
    result.verdict = found.verdict
    result.numbers = [
        SensorNumber(
            name=each.name,
            unit=each.unit,
            value=each.value,
            deviation=each.deviation,
            told=bool(each.told),
        )
        for each in found.numbers
    ]
    result.noise = found.noise.tolist()
    result.missing_effects = found.missing_effects
    result.missing_poses = found.missing_poses
    result.one_function = found.one_function
    result.model = model.text()


def main() -> int:
    """Run the sensor node."""
    # One thread for an identification, others for its cancelling and for the wrench meanwhile.
    return run(Sensor, partial(MultiThreadedExecutor, num_threads=3))


if __name__ == "__main__":
    raise SystemExit(main())
