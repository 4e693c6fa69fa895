"""The recorder node: everything that is said on the graph, into one MCAP file."""

from __future__ import annotations

import importlib
import shutil
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import yaml
from pydantic import BaseModel
from rcl_interfaces.msg import ParameterEvent
from rclpy._rclpy_pybind11 import RCLError
from rclpy.duration import Duration
from rclpy.exceptions import NameValidationException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from tissue_probe.nodes.diagnostics import OK, STALE, WARN, Diagnostics, Health, Rate
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.log_time import LogTime
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.remote_parameters import RemoteParameters
from tissue_probe.nodes.repeats import repeats
from tissue_probe.nodes.timers import every
from tissue_probe.recording.bags.definitions import message_definition, share_folders
from tissue_probe.recording.writing.writer import McapWriter
from tissue_probe.settings import setting
from tissue_probe.signals import NANOSECONDS

#: Time between two looks at the messages that arrived [s]; with the writer's flush it bounds the
#: loss of a killed recorder.
RECORD_LOOK_INTERVAL = 0.1
#: Time between two looks for new topics and nodes [s].
DISCOVERY_INTERVAL = 0.5
#: The quality of service asked for where every publisher offers it; so many messages are kept
#: between two looks.
STRICTEST = QoSProfile(
    depth=4000,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
#: Errors of a topic whose type is not installed, or whose name or type is none of ROS's.
UNUSABLE = (
    *(ImportError, AttributeError, FileNotFoundError, ValueError),
    *(NameValidationException, RCLError),
)
#: Below this the disk is called nearly full [bytes].
LITTLE_SPACE = 500_000_000
#: Below this time left at the present rate, too [s].
LITTLE_TIME = 600.0


class RecorderSettings(BaseModel):
    """Where to record, and whether to replace an existing recording."""

    output: str = setting(
        "", "", "file to write, never overwritten; empty for tissue_probe_<time>.mcap"
    )
    per_sample: bool = setting(
        False,
        "",
        "also record the topics that repeat blocks and estimates value by value: measured_cp, "
        "measured_cf, and the stiffness, damping and covariance_trace of each estimator",
    )


class Recorder(Node):
    """Records every topic of the graph as it was sent, and the parameters of every node.

    Each node's parameters become a metadata record named after the node, with the values in YAML,
    when the node is first seen and whenever they change.
    """

    def __init__(self) -> None:
        super().__init__("recorder")
        declare(self, RecorderSettings)
        settings = read(self, RecorderSettings)
        self._path = Path(settings.output or time.strftime("tissue_probe_%Y%m%d_%H%M%S.mcap"))
        self._per_sample = settings.per_sample
        self._known_topics: set[str] = set()
        self.messages = 0
        self._rate = Rate()
        self._growth = Rate()
        self._failed = False
        self._writer = McapWriter(self._path, {})
        self._inbox = Inbox(self)
        self._log_time = LogTime()
        self._remote_parameters = RemoteParameters(self, self._write_parameters)
        self.create_subscription(
            ParameterEvent, "/parameter_events", self._on_parameter_event, QoSProfile(depth=100)
        )
        every(RECORD_LOOK_INTERVAL, self, self._record)
        every(DISCOVERY_INTERVAL, self, self._discover)
        Diagnostics(self, self._examine)
        self.get_logger().info(f"recording to {self._path}")

    def destroy_node(self) -> None:
        """Record the messages that arrived, close the file, end the node."""
        try:
            if not self._failed:
                self._record()
        finally:
            self._writer.close()
            self._inbox.destroy()
            super().destroy_node()

    def _record(self) -> None:
        try:
            self._log_time.look()
            self.messages += self._inbox.empty()
        except OSError:
            self._failed = True
            raise

    def _discover(self) -> None:
        topics = dict(self.get_topic_names_and_types())
        left_out = set() if self._per_sample else repeats(topics)
        for topic in sorted(topics.keys() - self._known_topics - left_out):
            self._add(topic, topics[topic])
        self._remote_parameters.follow(
            {
                f"{namespace.rstrip('/')}/{name}"
                for name, namespace in self.get_node_names_and_namespaces()
                if not name.startswith("_")
            }
        )

    def _add(self, topic: str, types: Sequence[str]) -> None:
        """Record a topic from now on, unless it is hidden or nobody publishes it."""
        publishers = self.get_publishers_info_by_topic(topic)
        if "/_" in topic or not publishers:
            return
        self._known_topics.add(topic)
        qos = yaml.safe_dump([_as_written(publisher.qos_profile) for publisher in publishers])
        try:
            # The definition first: a name from the network imports nothing without one.
            definition = message_definition(types[0], share_folders())
            message_type = _message_type(types[0])
            write = partial(self._write, self._writer.add_topic(topic, types[0], definition, qos))
            self._inbox.subscribe(message_type, topic, STRICTEST, write, raw=True)
        except UNUSABLE as error:
            self.get_logger().warning(f"{topic} is not recorded: {error}")

    def _write(self, channel: int, data: bytes, info: dict[str, int]) -> None:
        # A foreign sender may give no time, which is negative here, and no time of a recording.
        sent, received = (max(0, info[f"{end}_timestamp"]) for end in ("source", "received"))
        self._writer.write(channel, self._log_time.of(received or sent), sent, data)

    def _on_parameter_event(self, event: ParameterEvent) -> None:
        self._remote_parameters.ask_again(event.node)

    def _write_parameters(self, node_name: str, values: dict[str, object]) -> None:
        self._writer.add_metadata(
            node_name,
            {
                name: yaml.safe_dump(value).removesuffix("...\n").strip()
                for name, value in values.items()
            },
        )

    def _examine(self) -> Health:
        free = shutil.disk_usage(self._path.absolute().parent).free
        size = self._path.stat().st_size
        growth, rate = self._growth(size), self._rate(self.messages)
        time_left = free / growth if growth else float("inf")
        values = {
            "messages recorded": self.messages,
            "achieved rate [messages/s]": f"{rate:.0f}",
            "size [bytes]": size,
            "disk left [bytes]": free,
            "time left on the disk [s]": f"{time_left:.0f}",
        }
        if free < LITTLE_SPACE or time_left < LITTLE_TIME:
            return Health(WARN, f"the disk is nearly full: {free / 1e6:.0f} MB left", values)
        if not rate:
            return Health(STALE, "no messages in the last second", values)
        return Health(OK, f"recording to {self._path}", values)


def _message_type(typename: str) -> type:
    package, _, name = typename.split("/")
    found: type = getattr(importlib.import_module(f"{package}.msg"), name)
    return found


def _as_written(qos: QoSProfile) -> dict[str, object]:
    """Return qualities of service in the form that ``ros2 bag`` writes."""

    def seconds(duration: Duration) -> dict[str, int]:
        whole, nanoseconds = divmod(duration.nanoseconds, NANOSECONDS)
        return {"sec": whole, "nsec": nanoseconds}

    return {
        "history": qos.history.short_key,
        "depth": qos.depth,
        "reliability": qos.reliability.short_key,
        "durability": qos.durability.short_key,
        "deadline": seconds(qos.deadline),
        "lifespan": seconds(qos.lifespan),
        "liveliness": qos.liveliness.short_key,
        "liveliness_lease_duration": seconds(qos.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": qos.avoid_ros_namespace_conventions,
    }


def main() -> int:
    """Run the recorder node."""
    return run(Recorder)


if __name__ == "__main__":
    raise SystemExit(main())
