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

from tissue_probe.signals import NANOSECONDS

#: Called with a message (its CDR bytes if raw) and rclpy's message info (a dictionary).
Handler = Callable[[Any, dict], None]


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
        self._subscriptions: dict[str, tuple[Any, Handler]] = {}
        self._in_use = ExitStack()
        self._wait_set: Any = None

    def subscribe(
        self,
        message_type: type,
        topic: str,
        qos: QoSProfile,
        handler: Handler,
        *,
        raw: bool = False,
    ) -> None:
        """Keep messages of a topic until ``empty``; at most the depth of ``qos`` of them."""
        subscription = self._node.create_subscription(
            message_type, self._owner.resolve_topic_name(topic), lambda message: None, qos, raw=raw
        )
        # What rclpy asks of whoever uses a handle; once here, since it takes as long as a message.
        self._in_use.enter_context(subscription.handle)
        self._subscriptions[topic] = subscription, handler

    def publishers(self) -> int:
        """Return how many publishers the subscriptions hear, all together.

        Who publishes may count a subscription a while before it hears anything.
        """
        return sum(each.get_publisher_count() for each, _ in self._subscriptions.values())

    def empty(self, topic: str | None = None) -> int:
        """Hand every message that has arrived to its handler, topic by topic; return how many.

        With a ``topic``, only what has arrived there: for a handler to which another topic's
        messages matter that may have come while it was busy.
        """
        count = 0
        wanted = self._subscriptions.values() if topic is None else [self._subscriptions[topic]]
        for subscription, handler in wanted:
            take = subscription.handle.take_message
            while (taken := take(subscription.msg_type, subscription.raw)) is not None:
                handler(*taken)
                count += 1
        return count

    def wait(self, timeout: float) -> None:
        """Wait until a message has arrived, at most ``timeout`` [s].

        All subscriptions must have been made before the first call.
        """
        if self._wait_set is None:
            # As rclpy.wait_for_message does it, the only public example of a wait without executor.
            self._wait_set = rclpy_implementation.WaitSet(
                len(self._subscriptions), 0, 0, 0, 0, 0, self._owner.context.handle
            )
        self._wait_set.clear_entities()
        for subscription, _ in self._subscriptions.values():
            self._wait_set.add_subscription(subscription.handle)
        self._wait_set.wait(round(timeout * NANOSECONDS))

    def destroy(self) -> None:
        """Let go of the subscriptions."""
        self._in_use.close()
        self._subscriptions.clear()
        self._node.destroy_node()
