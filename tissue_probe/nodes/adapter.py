"""The adapter node: samples of any robot that carries a force sensor, out of its pose and wrench.

Contents: hearing the two topics, publishing, telling faults. It commands nothing: the mover of the
robot also stops it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState

from tissue_probe.nodes.cdr import samples_to_cdr
from tissue_probe.nodes.diagnostics import ERROR, OK, STALE, WARN, Diagnostics, Health, Rate
from tissue_probe.nodes.hearing import LOOK_INTERVAL, Hearing
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.own_time import OwnTime
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import PER_SAMPLE, SAMPLE_BLOCKS
from tissue_probe.nodes.timers import every
from tissue_probe.recording.clocks.channel import Fault, MessageChannel
from tissue_probe.recording.robot.adapter import Adapter
from tissue_probe.recording.robot.settings import RobotDescription
from tissue_probe.settings import setting
from tissue_probe.signals import LONGEST_SILENCE, NANOSECONDS
from tissue_probe_msgs.msg import ProbeSamples

#: Time between two looks at the messages that have come [s]: a look costs as much as some tens of
#: messages, and estimates wait no longer than two periods of the fastest pose that a robot
#: controller sends.
MESSAGE_LOOK_INTERVAL = 0.01
#: By how much a rate may differ from that stated before it is told: jitter of a second's count is
#: less, and at more messages are bridged or left out that should not be.
OFF_RATE = 0.2
#: Time until the log tells a fault of the same kind again [s]; /diagnostics tells every one.
LOG_AGAIN = 10.0


class AdapterSettings(RobotDescription):
    """The node's settings beside those of the robot."""

    frame_id: str = setting("probe", "", "frame of the samples")


class HeardTopic:
    """One of the two topics: how it is heard, and how it goes with it.

    Attributes
    ----------
    found : float
        Messages of use a second.
    faults : list of str
        The faults since it was last examined, a sentence for each kind.
    """

    def __init__(self, channel: MessageChannel, hearing: Hearing, rate: float) -> None:
        self.channel = channel
        self._hearing = hearing
        self._stated = rate
        self._now = OwnTime()
        self._taken, self._since, self._silence = 0, 0.0, 0.0
        self._rate = Rate()
        self._before: dict[str, Fault] = {}
        self._new: dict[str, str] = {}
        self.found = 0.0
        self.faults: list[str] = []
        self._logged: dict[str, float] = {}

    def look(self) -> None:
        """Note whether anything of use has come."""
        now = self._now()
        if self.channel.taken != self._taken:
            self._taken, self._since = self.channel.taken, now
        self._silence = now - self._since

    def examine(self) -> None:
        """Find rate and faults since the last time; once a second."""
        self.found = self._rate(self.channel.taken)
        faults = dict(self.channel.faults)
        self._new = {k: v.sentence for k, v in faults.items() if v != self._before.get(k)}
        self.faults = list(self._new.values())
        self._before = faults

    def untold(self) -> list[str]:
        """Return of these faults those whose kind is not in the log already, or long ago."""
        now = time.monotonic()
        kinds = [k for k in self._new if now - self._logged.get(k, -LOG_AGAIN) >= LOG_AGAIN]
        self._logged |= dict.fromkeys(kinds, now)
        return [self._new[kind] for kind in kinds]

    def why_silent(self) -> str:
        """Say that nothing of use comes, and why; nothing where it does."""
        if self._silence * NANOSECONDS <= LONGEST_SILENCE:
            return ""
        why = "" if self.faults else f": {self._hearing.why_silent()}"
        return f"nothing of use comes on {self.channel.name}{why}"

    def off_rate(self) -> str:
        """Say that the rate is not as stated; nothing where it is."""
        if abs(self.found - self._stated) <= OFF_RATE * self._stated:
            return ""
        return (
            f"{self.channel.name} comes {self.found:.0f} times a second, not {self._stated:g}: "
            "state its rate"
        )


class AdapterNode(Node):
    """Publishes ``samples`` of a robot's poses, or of a joint, and of its wrench."""

    def __init__(self) -> None:
        super().__init__("adapter")
        declare(self, AdapterSettings)
        settings = read(self, AdapterSettings)
        self._frame_id = settings.frame_id
        self._adapter = adapter = Adapter(settings)
        self._publisher = self.create_publisher(ProbeSamples, "samples", SAMPLE_BLOCKS)
        self._inbox = Inbox(self)
        kind = JointState if settings.joint else PoseStamped
        position = self._hear(kind, settings.position, adapter.take_position)
        force = self._hear(WrenchStamped, settings.force, adapter.take_force)
        self._heard = (
            HeardTopic(adapter.position, position, settings.position_rate),
            HeardTopic(adapter.force, force, settings.force_rate),
        )
        self._joint = settings.joint
        self._looked = time.monotonic()
        self._others = self._withheld = 0
        self._rate = Rate()
        self._told = ""
        self._zero_told = False
        every(MESSAGE_LOOK_INTERVAL, self, self._adapt)
        Diagnostics(self, self._examine)
        self.get_logger().info(
            f"hearing {settings.position} and {settings.force}; nothing is commanded"
        )

    def _hear(self, kind: type, topic: str, take: Callable[[Any], None]) -> Hearing:
        return self._inbox.subscribe(kind, topic, PER_SAMPLE, lambda message, info: take(message))

    def destroy_node(self) -> None:
        """Let go of the subscriptions, end the node."""
        self._inbox.destroy()
        super().destroy_node()

    def _adapt(self) -> None:
        """Publish the samples that have become known."""
        self._inbox.empty()
        self._look_for_others()
        for block in self._adapter.samples():
            if self._others:
                self._withheld += len(block)
            else:
                self._publisher.publish(samples_to_cdr(block, self._frame_id))
        for heard in self._heard:
            heard.look()
        self._tell_zero()

    def _look_for_others(self) -> None:
        """Look whether another node publishes samples: mixed, they would be nobody's."""
        if time.monotonic() - self._looked > LOOK_INTERVAL:
            self._looked = time.monotonic()
            self._others = max(0, self.count_publishers("samples") - 1)

    def _tell_zero(self) -> None:
        zero = self._adapter.pressing.zero
        if zero is not None and not self._zero_told:
            self._zero_told = True
            self.get_logger().info(f"the position is zero at {list(zero)} (parameter zero)")

    def _examine(self) -> Health:
        faults = []
        for heard in self._heard:
            heard.examine()
            faults += heard.faults
            for sentence in heard.untold():
                self.get_logger().warning(sentence)
        rate = self._rate(self._adapter.grid.samples)
        level, message = self._judged(rate)
        if message != self._told and level in (ERROR, STALE):
            self.get_logger().error(message)
        self._told = message
        if faults and level == OK:
            level, message = WARN, "some messages are of no use"
        return Health(level, "; ".join([message, *faults]), self._values(rate))

    def _values(self, rate: float) -> dict[str, object]:
        grid = self._adapter.grid
        values: dict[str, object] = {
            "subscribers": self._publisher.get_subscription_count(),
            "publishers": self._inbox.publishers(),
            "samples": grid.samples,
            "samples withheld": self._withheld,
            "runs": grid.runs,
            "achieved rate [samples/s]": f"{rate:.0f}",
            "zero [m]": list(self._adapter.pressing.zero or ()),
        }
        for heard in self._heard:
            name = heard.channel.name
            values[f"{name} [messages/s]"] = f"{heard.found:.0f}"
            values |= {f"{name}: {k}": fault.count for k, fault in heard.channel.faults.items()}
        return values

    def _judged(self, rate: float) -> tuple[bytes, str]:
        """Return how it goes, in a level and a sentence."""
        if self._others:
            return ERROR, "another node publishes samples: end it; until then none are published"
        if silent := [said for heard in self._heard if (said := heard.why_silent())]:
            joints = ", ".join(sorted(self._adapter.joints - {self._joint}))
            if self._joint not in self._adapter.joints and joints:
                silent.append(f"no message has joint {self._joint}; there are {joints}")
            return STALE, "; ".join(silent)
        if not rate:
            return ERROR, self._apart()
        off = [said for heard in self._heard if (said := heard.off_rate())]
        if off:
            return WARN, "; ".join(off)
        return OK, "adapting"

    def _apart(self) -> str:
        """Say why both topics make no samples."""
        if self._adapter.grid.clocks_apart:
            return "the clock of one topic alone was set back: start the adapter anew"
        position, force = (heard.channel for heard in self._heard)
        if position.latest is None or force.latest is None:
            return "no two messages have come of both topics yet"
        ahead = (position.latest.stamp - force.latest.stamp) / NANOSECONDS
        return (
            f"both topics come, and no samples: the stamps of {position.name} are {ahead:.1f} s "
            f"ahead of those of {force.name}; set both clocks by one, and state the rates"
        )


def main() -> int:
    """Run the adapter node."""
    return run(AdapterNode)


if __name__ == "__main__":
    raise SystemExit(main())
