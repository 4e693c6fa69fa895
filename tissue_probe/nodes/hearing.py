"""A subscription that asks for no more than its publishers offer, so that it hears all of them.

DDS hands nothing from who publishes best effort to who asks for reliable delivery, and nothing from
who keeps no messages to who asks for kept ones. Many drivers of robots publish so. Here is asked
for the strictest that is wanted and that each publisher offers, anew when the publishers change;
and the graph shows here why nothing is heard.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)
from rclpy.topic_endpoint_info import TopicEndpointInfo

from tissue_probe.nodes.timers import every

#: Time between two looks at who publishes [s]: a look takes a tenth of a millisecond, and found out
#: so late a publisher has lost no more than discovery may take anyway.
LOOK_INTERVAL = 0.5

#: Within this time of its start a node hears of the others [s].
DISCOVERY_TIME = 1.0


class Hearing:
    """One topic, heard from all who publish it with its type.

    Parameters
    ----------
    node : Node
        Whose subscription it is.
    message_type : type
        Of the messages.
    topic : str
        Its full name, remapped already.
    callback : callable
        Called with each message where an executor serves the node.
    wanted : QoSProfile
        The strictest qualities that are of use; without a publisher these are asked for.
    raw : bool
        Whether messages come as their CDR bytes.

    Attributes
    ----------
    subscription : Subscription
        The present one.
    """

    def __init__(
        self,
        node: Node,
        message_type: type,
        topic: str,
        callback: Callable[[Any], None],
        wanted: QoSProfile,
        *,
        raw: bool = False,
    ) -> None:
        self._node, self._type, self._topic, self._raw = node, message_type, topic, raw
        self._callback = callback
        self._wanted = wanted
        self._type_name = f"{message_type.__module__.split('.')[0]}/msg/{message_type.__name__}"
        self._looked = time.monotonic()
        self._asked = find_offered_quality(wanted, self._offers())
        self.subscription = self._subscribe()

    def is_due(self) -> bool:
        """Whether it is time to look again at who publishes, and whether that asks for a change."""
        if time.monotonic() - self._looked < LOOK_INTERVAL:
            return False
        self._looked = time.monotonic()
        return self._should_ask_anew(self._offers())

    def ask_anew(self) -> None:
        """Replace the subscription by one that all hear who publish now."""
        before = self.subscription
        self._asked = find_offered_quality(self._wanted, self._offers())
        self.subscription = self._subscribe()
        self._node.destroy_subscription(before)

    def follow(self) -> None:
        """Ask anew where that is due; for a node's timer."""
        if self.is_due():
            self.ask_anew()

    def mismatch(self) -> str:
        """Say which other type the topic has, where it has no publisher of the right one.

        Nothing if it has one, or none at all.
        """
        publishers = self._node.get_publishers_info_by_topic(self._topic)
        others = [info for info in publishers if info.topic_type != self._type_name]
        if not others or len(others) < len(publishers):
            return ""
        types = ", ".join(sorted({info.topic_type for info in others}))
        return f"{_names(others)} publishes it as {types}, not as {self._type_name}"

    def why_silent(self) -> str:
        """Say by the graph which publishers could be heard, where none was."""
        if mismatch := self.mismatch():
            return mismatch
        if offers := self._offers():
            return f"{_names(offers)} is known to publish it, but nothing comes"
        return "no node publishes it"

    def _subscribe(self) -> Any:
        # rclpy's own callbacks warn of publishers that are not heard: they will be.
        return self._node.create_subscription(
            self._type,
            self._topic,
            self._callback,
            self._asked,
            raw=self._raw,
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
        )

    def _offers(self) -> list[TopicEndpointInfo]:
        publishers = self._node.get_publishers_info_by_topic(self._topic)
        return [info for info in publishers if info.topic_type == self._type_name]

    def _should_ask_anew(self, offers: Sequence[TopicEndpointInfo]) -> bool:
        """Whether someone is not heard, or more could be asked for.

        A kept message comes again to a new subscription, and is taken as new: that is borne only
        where a publisher would not be heard otherwise.
        """
        if not offers:
            return False
        wanted = find_offered_quality(self._wanted, offers)
        if _qualities(wanted) == _qualities(self._asked):
            return False
        unheard = any(
            qos_check_compatible(info.qos_profile, self._asked)[0] == QoSCompatibility.ERROR
            for info in offers
        )
        return unheard or wanted.durability != DurabilityPolicy.TRANSIENT_LOCAL


def hear(
    node: Node,
    message_type: type,
    topic: str,
    callback: Callable[[Any], None],
    wanted: QoSProfile,
) -> Hearing:
    """Hear a topic by the node's executor, as ``Hearing``; names are relative to the node's."""
    hearing = Hearing(node, message_type, node.resolve_topic_name(topic), callback, wanted)
    every(LOOK_INTERVAL, node, hearing.follow)
    return hearing


def find_offered_quality(wanted: QoSProfile, offers: Sequence[TopicEndpointInfo]) -> QoSProfile:
    """Return the strictest qualities up to ``wanted`` that every publisher offers."""
    offered = [info.qos_profile for info in offers]
    best_effort = any(qos.reliability == ReliabilityPolicy.BEST_EFFORT for qos in offered)
    kept = wanted.durability == DurabilityPolicy.TRANSIENT_LOCAL and not any(
        qos.durability == DurabilityPolicy.VOLATILE for qos in offered
    )
    return QoSProfile(
        depth=wanted.depth,
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else wanted.reliability,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if kept else DurabilityPolicy.VOLATILE,
    )


def node_name(info: TopicEndpointInfo) -> str:
    """Return the name of a publisher's node with its namespace; empty while it is not known."""
    # Publishers of DDS without ROS have no node; rmw_fastrtps says so by this name.
    if info.node_name.startswith(("_NODE_NAME_UNKNOWN", "_CREATED_BY_BARE_DDS_APP")):
        return ""
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"


def _names(publishers: Sequence[TopicEndpointInfo]) -> str:
    return ", ".join(sorted({node_name(info) or "a node without a name" for info in publishers}))


def _qualities(qos: QoSProfile) -> tuple[ReliabilityPolicy, DurabilityPolicy]:
    return qos.reliability, qos.durability
