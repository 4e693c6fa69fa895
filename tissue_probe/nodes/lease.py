"""A topic whose publisher must show that it is alive, heard by a node that acts where it does not.

The publisher asserts the liveliness of its messages (DDS: manual by topic) from the loop that does
the work. DDS tells here that it ceased, whether its process died, was stopped, or its loop hangs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import (
    QoSLivelinessChangedInfo,
    QoSRequestedIncompatibleQoSInfo,
    SubscriptionEventCallbacks,
)
from rclpy.node import Node
from rclpy.subscription import Subscription

from tissue_probe.nodes.qos import announcement_quality


class Lease:
    """Hears messages, and that signs of life have ceased.

    Parameters
    ----------
    node : Node
        Whose executor serves it.
    message_type : type
        Of the messages.
    topic : str
        Relative to the node's names.
    timeout : float
        Longest silence [s].
    on_message : callable
        Called with each message.
    on_loss : callable
        Called where a publisher has been silent for longer, or is gone.
    on_no_promise : callable, optional
        Called where a publisher does not promise a sign within the timeout; it is not heard.
    """

    def __init__(
        self,
        node: Node,
        message_type: Any,
        topic: str,
        timeout: float,
        on_message: Callable[[Any], None],
        on_loss: Callable[[], None],
        on_no_promise: Callable[[QoSRequestedIncompatibleQoSInfo], None] | None = None,
    ) -> None:
        self._node, self._type, self._topic = node, message_type, topic
        self._on_message, self._on_loss, self._on_no_promise = on_message, on_loss, on_no_promise
        self._subscriptions: list[Subscription] = []
        self.timeout = timeout
        self._subscribe()

    @property
    def topic_name(self) -> str:
        """The topic's full name."""
        return str(self._subscriptions[-1].topic_name)

    def change_timeout(self, timeout: float) -> None:
        """Allow another silence [s] from now on; who is watched stays watched."""
        if timeout != self.timeout:
            self.timeout = timeout
            self._subscribe()

    def _subscribe(self) -> None:
        """Ask for the present timeout: a subscription's own cannot be changed.

        The one before watches on until the new one has found a publisher that is alive.
        """

        def on_liveliness(event: QoSLivelinessChangedInfo) -> None:
            if event.alive_count_change > 0:
                self._forget_before(subscription)
            elif event.alive_count_change < 0:
                self._on_loss()

        subscription = self._node.create_subscription(
            self._type,
            self._topic,
            self._on_message,
            announcement_quality(self.timeout),
            event_callbacks=SubscriptionEventCallbacks(
                liveliness=on_liveliness, incompatible_qos=self._on_no_promise
            ),
        )
        self._subscriptions.append(subscription)

    def _forget_before(self, subscription: Subscription) -> None:
        while subscription in self._subscriptions[1:]:
            self._node.destroy_subscription(self._subscriptions.pop(0))
