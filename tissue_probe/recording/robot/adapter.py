"""Messages of a robot, decoded by any library, as samples.

Contents: fields of messages, and the faults that make one unusable.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tissue_probe.recording.clocks.channel import MessageChannel
from tissue_probe.recording.clocks.common_grid import CommonGrid
from tissue_probe.recording.robot.pressing import Pressing, Vector
from tissue_probe.recording.robot.settings import RobotDescription
from tissue_probe.signals import NANOSECONDS, SampleBlock, sound_stamp


class Adapter:
    """Takes the messages of both topics in the order of each; gives samples as they become known.

    A sample is published when two messages of each topic after it have come. A message that cannot
    be used is left out and counted (``Channel.faults``).

    Parameters
    ----------
    settings : RobotDescription
        The user's statements on the robot.

    Attributes
    ----------
    position, force : Channel
        The two topics.
    grid : CommonGrid
        The grid that joins them.
    pressing : Pressing
        Directions, and the zero.
    joints : set of str
        Names heard on the position's topic, where it is one of joints.
    """

    def __init__(self, settings: RobotDescription) -> None:
        self._joint = settings.joint
        self.pressing = Pressing(settings)
        self.position = MessageChannel(settings.position, settings.position_rate, settings.fastest)
        self.force = MessageChannel(settings.force, settings.force_rate, hangs=True)
        self.grid = CommonGrid(round(NANOSECONDS / settings.force_rate), self.position, self.force)
        self._frames = {
            self.position.name: settings.position_frame,
            self.force.name: settings.force_frame,
        }
        self.joints: set[str] = set()

    def take_position(self, message: Any) -> None:
        """Take a ``geometry_msgs/PoseStamped``, or a ``sensor_msgs/JointState`` of a joint."""
        if not self._joint:
            self._take(self.position, message, self._pose_of)
            return
        # Several nodes may tell of their joints on one topic; frames mean nothing there.
        self.joints.update(message.name)
        if self._joint in message.name:
            self._take(self.position, message, self._travel_of, framed=False)

    def take_force(self, message: Any) -> None:
        """Take a ``geometry_msgs/WrenchStamped``."""
        self._take(self.force, message, self._force_of)

    def samples(self) -> list[SampleBlock]:
        """Return the samples that have become known since the last call."""
        return self.grid.take()

    def _take(
        self,
        channel: MessageChannel,
        message: Any,
        values: Callable[[Any], tuple[Vector, Vector]],
        *,
        framed: bool = True,
    ) -> None:
        header = message.header
        frame = header.frame_id
        if framed and frame != (expected := self._frames[channel.name] or frame):
            said = f"comes in frame {frame!r}, not in {expected!r}: left out"
            channel.leave_out("other frames", said)
            return
        stamp = int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)
        try:
            if sound_stamp(stamp) == 0:
                raise ValueError("has no stamps: its driver must say when it measured")
            row, place = values(message)
        except ValueError as error:
            channel.leave_out("unusable", f"{error}; left out")
            return
        self._frames[channel.name] = frame
        channel.take(stamp, row, place)

    def _pose_of(self, message: Any) -> tuple[Vector, Vector]:
        p, q = message.pose.position, message.pose.orientation
        return self.pressing.pose((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))

    def _travel_of(self, message: Any) -> tuple[Vector, Vector]:
        index = list(message.name).index(self._joint)
        if index >= len(message.position):
            raise ValueError(f"tells no position of joint {self._joint}")
        return self.pressing.travel(float(message.position[index]))

    def _force_of(self, message: Any) -> tuple[Vector, Vector]:
        f = message.wrench.force
        return self.pressing.force((f.x, f.y, f.z)), ()
