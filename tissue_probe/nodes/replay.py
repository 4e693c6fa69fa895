"""The replay node: a bag's samples on the live topics, where everything runs on them unchanged."""

from __future__ import annotations

import time
from itertools import chain, dropwhile

from pydantic import BaseModel
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_srvs.srv import SetBool

from tissue_probe.nodes.diagnostics import OK, Diagnostics, Health
from tissue_probe.nodes.parameters import declare, follow_changes, read
from tissue_probe.nodes.process import Finished, run
from tissue_probe.nodes.qos import ANNOUNCEMENTS, SAMPLE_BLOCKS
from tissue_probe.nodes.timers import every
from tissue_probe.recording.bags.reader import iterate_raw
from tissue_probe.recording.bags.summary import summarize
from tissue_probe.recording.errors import RecordingError
from tissue_probe.settings import SettingsError, setting
from tissue_probe.signals import NANOSECONDS
from tissue_probe_msgs.msg import PalpationSite, ProbeSamples

#: Time between two looks at the messages that are due [s].
DUE_LOOK_INTERVAL = 0.002
#: Longest wait at the end until every subscriber has everything.
LONGEST_SUBSCRIBER_WAIT = Duration(seconds=5)

SAMPLES, SITE = "tissue_probe_msgs/msg/ProbeSamples", "tissue_probe_msgs/msg/PalpationSite"


class ReplaySettings(BaseModel):
    """The recording to replay, and how."""

    bag: str = setting("", "", "MCAP file to replay")
    rate: float = setting(1.0, "", "speed of the replay over that of the run", gt=0.0, le=1000.0)
    loop: bool = setting(False, "", "begin again at the end")
    start: float = setting(
        0.0, "s", "time after the bag's first message at which to begin", ge=0.0, le=1e6
    )
    subscribers: int = setting(
        0, "", "subscribers of the samples to wait for before the first message", ge=0, le=100
    )
    paused: bool = setting(False, "", "wait for the service ~/pause before the first message")


class Replay(Node):
    """Publishes the recorded samples and palpation sites, byte for byte, in the recorded rhythm.

    Stamps and sequence numbers stay as recorded. The service ``~/pause`` (std_srvs/SetBool)
    pauses and goes on.
    """

    def __init__(self) -> None:
        super().__init__("replay")
        declare(self, ReplaySettings, live=("rate", "loop"))
        self._settings = read(self, ReplaySettings)
        if not self._settings.bag:
            raise SettingsError("parameter bag is empty: give the MCAP file to replay")
        try:
            self._publishers_by_topic = self._make_publishers()
            self._begin()
        except RecordingError as error:
            raise SettingsError(str(error)) from None
        self._paused = self._settings.paused
        self._waiting = True
        follow_changes(self, {"": ReplaySettings}, self._on_change)
        self.create_service(SetBool, "~/pause", self._on_pause)
        every(DUE_LOOK_INTERVAL, self, self._publish_due)
        Diagnostics(self, self._examine)

    def _make_publishers(self) -> dict[str, Publisher]:
        kinds = {
            SAMPLES: (ProbeSamples, "samples", SAMPLE_BLOCKS),
            SITE: (PalpationSite, "palpation_site", ANNOUNCEMENTS),
        }
        found = {
            topic.name: self.create_publisher(*kinds[topic.typename])
            for topic in summarize(self._settings.bag).topics
            if topic.typename in kinds
        }
        if not any(publisher.msg_type is ProbeSamples for publisher in found.values()):
            raise SettingsError(f"{self._settings.bag} has no samples to replay")
        return found

    def _begin(self) -> None:
        """Go to the chosen start of the bag."""
        messages = iterate_raw(self._settings.bag, self._publishers_by_topic.keys())
        first = next(messages)
        begin = first.log_time + round(self._settings.start * NANOSECONDS)
        self._messages = dropwhile(lambda m: m.log_time < begin, chain([first], messages))
        self._next = next(self._messages, None)
        self._bag_time = begin
        self._wall_time = time.monotonic_ns()

    def _on_change(self) -> None:
        self._advance()
        self._settings = read(self, ReplaySettings)

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._advance()
        self._paused = request.data
        response.success = True
        response.message = "paused" if self._paused else "going on"
        return response

    def _advance(self) -> None:
        """Let the bag's time pass with the wall's, unless paused."""
        now = time.monotonic_ns()
        if not (self._paused or self._waiting):
            self._bag_time += round((now - self._wall_time) * self._settings.rate)
        self._wall_time = now

    def _publish_due(self) -> None:
        self._waiting = self._waiting and self._subscribers() < self._settings.subscribers
        self._advance()
        if self._paused or self._waiting:
            return
        while self._next is not None and self._next.log_time <= self._bag_time:
            self._publishers_by_topic[self._next.topic].publish(self._next.data)
            self._next = next(self._messages, None)
        if self._next is None:
            self._end()

    def _subscribers(self) -> int:
        return sum(
            publisher.get_subscription_count()
            for publisher in self._publishers_by_topic.values()
            if publisher.msg_type is ProbeSamples
        )

    def _examine(self) -> Health:
        doing = "paused" if self._paused else "waiting" if self._waiting else "replaying"
        return Health(OK, doing, {"subscribers": self._subscribers()})

    def _end(self) -> None:
        if self._settings.loop:
            self._begin()
            return
        for publisher in self._publishers_by_topic.values():
            publisher.wait_for_all_acked(LONGEST_SUBSCRIBER_WAIT)
        self.get_logger().info("the whole bag is replayed")
        raise Finished


def main() -> int:
    """Run the replay node."""
    return run(Replay)


if __name__ == "__main__":
    raise SystemExit(main())
