"""Subscriptions outside the executor: emptied now and then, or waited for in a thread.

An rclpy executor spends 60-100 us on each message, since it looks at everything the node has;
taking a message from a subscription costs a tenth of that. Nodes that need not react at once
(recorder, mapper) take messages in bulk; an estimator waits for its samples and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import rclpy
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from tissue_probe.nodes.hearing import Hearing
from tissue_probe.signals import NANOSECONDS

#: Called with a message (its CDR bytes if raw) and rclpy's message info (a dictionary).
Handler = Callable[[Any, dict[str, int]], None]


class Inbox:
    """Subscriptions of ``owner`` that no executor waits for.

    They belong to a hidden node beside the owner, since an executor waits for everything of a
    node that it was given; names are resolved and remapped as the owner's.
    """

    def __init__(self, owner: Node) -> None:
        self._owner = owner
        self._node = rclpy.create_node(
            f"_{owner.get_name()}_inbox",
            namespace=owner.get_namespace(),
            context=owner.context,
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self._heard: dict[str, tuple[Hearing, Handler]] = {}
        self._in_use: dict[str, ExitStack] = {}
        self._wait_set: Any = None

    def subscribe(
        self,
        message_type: type,
        topic: str,
        qos: QoSProfile,
        handler: Handler,
        *,
        raw: bool = False,
    ) -> Hearing:
        """Keep messages of a topic until ``empty``; at most the depth of ``qos`` of them.

        The quality of service asked for is at most ``qos``, and at most that of the publishers
        (``Hearing``).
        """
        name = self._owner.resolve_topic_name(topic)
        hearing = Hearing(self._node, message_type, name, lambda message: None, qos, raw=raw)
        self._heard[topic] = hearing, handler
        self._use(topic)
        return hearing

    def publishers(self) -> int:
        """Return how many publishers the subscriptions hear, all together.

        Who publishes may count a subscription a while before it hears anything.
        """
        return sum(
            hearing.subscription.get_publisher_count() for hearing, _ in self._heard.values()
        )

    def empty(self, topic: str | None = None) -> int:
        """Hand every message that has arrived to its handler, topic by topic; return how many.

        With a ``topic``, only the messages that arrived there: for a handler to which another
        topic's messages matter that may have come while it was busy.
        """
        wanted = list(self._heard) if topic is None else [topic]
        return sum(self._empty(each) for each in wanted)

    def wait(self, timeout: float) -> None:
        """Wait until a message has arrived, at most ``timeout`` [s].

        All topics must have been subscribed to before the first call.
        """
        if self._wait_set is None:
            # As rclpy.wait_for_message does it, the only public example of a wait without executor.
            self._wait_set = rclpy_implementation.WaitSet(
                len(self._heard), 0, 0, 0, 0, 0, self._owner.context.handle
            )
        self._wait_set.clear_entities()
        for hearing, _ in self._heard.values():
            self._wait_set.add_subscription(hearing.subscription.handle)
        self._wait_set.wait(round(timeout * NANOSECONDS))

    def destroy(self) -> None:
        """Let go of the subscriptions."""
        for each in self._in_use.values():
            each.close()
        self._heard.clear()
        self._node.destroy_node()

    def _empty(self, topic: str) -> int:
        """Empty one topic, and ask for it anew where its publishers have changed."""
        hearing, handler = self._heard[topic]
        count = _taken(hearing.subscription, handler)
        if hearing.is_due():
            self._in_use.pop(topic).close()
            hearing.ask_anew()
            self._use(topic)
        return count

    def _use(self, topic: str) -> None:
        """Take a handle into use once, as rclpy asks: it takes as long as a message."""
        self._in_use[topic] = ExitStack()
        self._in_use[topic].enter_context(self._heard[topic][0].subscription.handle)


def _taken(subscription: Subscription, handler: Handler) -> int:
    """Hand on every message that has arrived; return how many."""
    count = 0
    take = subscription.handle.take_message
    while (taken := take(subscription.msg_type, subscription.raw)) is not None:
        handler(*taken)
        count += 1
    return count
