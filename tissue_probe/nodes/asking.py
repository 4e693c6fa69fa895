"""Ask a service or an action until it answers."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any
from uuid import uuid4

from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.action import ActionClient
from rclpy.client import Client
from rclpy.node import Node
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

#: Two nodes that find each other do so in both directions, one after the other. A request that is
#: sent between the two is lost, and so is an answer, for which Fast DDS waits 100 ms at most. A
#: second request [s later] is sent well after a slow node would have answered the first.
REPEAT = 5.0

#: The state in which each transition of a lifecycle ends when it succeeds.
ENDS_IN = {
    Transition.TRANSITION_CONFIGURE: State.PRIMARY_STATE_INACTIVE,
    Transition.TRANSITION_ACTIVATE: State.PRIMARY_STATE_ACTIVE,
    Transition.TRANSITION_DEACTIVATE: State.PRIMARY_STATE_INACTIVE,
    Transition.TRANSITION_CLEANUP: State.PRIMARY_STATE_UNCONFIGURED,
}

Wait = Callable[[Callable[[], bool]], None]


class Question:
    """A request that is sent again as long as no answer has come.

    The server must bear to be asked twice.

    Parameters
    ----------
    is_ready : callable
        Whether the server can be reached.
    send : callable
        Sends the request; returns the future that holds the answer.
    """

    def __init__(self, is_ready: Callable[[], bool], send: Callable[[], Future]) -> None:
        self._is_ready, self._send = is_ready, send
        self._sent: list[Future] = []
        self._sent_at = float("-inf")

    @property
    def is_repeated(self) -> bool:
        """Whether the server may have heard the request more than once."""
        return len(self._sent) > 1

    def is_answered(self) -> bool:
        """Send the request if it is due, and return whether an answer has come."""
        if any(each.done() for each in self._sent):
            return True
        late = time.monotonic() - self._sent_at > REPEAT
        if late and self._is_ready():
            self._sent_at = time.monotonic()
            self._sent.append(self._send())
        return False

    def answer(self) -> Any:
        """Return the first answer; call it once one has come."""
        return next(each.result() for each in self._sent if each.done())


def to_service(client: Client, request: Any) -> Question:
    """Return a question to a service."""
    return Question(client.service_is_ready, lambda: client.call_async(request))


def to_action(
    client: ActionClient, goal: Any, on_feedback: Callable[[Any], None] | None = None
) -> Question:
    """Return a goal for an action as a question; a server takes a goal of one identity once."""
    identity = UUID(uuid=list(uuid4().bytes))
    return Question(
        client.server_is_ready, lambda: client.send_goal_async(goal, on_feedback, identity)
    )


def ask(node: Node, kind: Any, service: str, request: Any, wait: Wait) -> Any:
    """Ask a service until it answers, and return its answer.

    Parameters
    ----------
    node : rclpy.node.Node
        Asks.
    kind : type
        The service's type.
    service : str
        Its name.
    request : message
        The request; the service must bear to hear it twice.
    wait : callable
        Takes a condition, takes part in the graph until it holds, and raises where it lasts too
        long.
    """
    client = node.create_client(kind, service)
    try:
        question = to_service(client, request)
        wait(question.is_answered)
        return question.answer()
    finally:
        node.destroy_client(client)


class Lifecycle:
    """A lifecycle node of another process: its state, and transitions.

    Parameters
    ----------
    node : rclpy.node.Node
        Asks.
    target : str
        The lifecycle node's name.
    """

    def __init__(self, node: Node, target: str) -> None:
        self._node = node
        self._getter = node.create_client(GetState, f"{target}/get_state")
        self._changer = node.create_client(ChangeState, f"{target}/change_state")

    def close(self) -> None:
        """Let go of the clients."""
        for client in (self._getter, self._changer):
            self._node.destroy_client(client)

    def state(self, wait: Wait) -> int:
        """Return the state, one of the constants of ``State``; ``wait`` as for ``ask``."""
        question = to_service(self._getter, GetState.Request())
        wait(question.is_answered)
        return int(question.answer().current_state.id)

    def change(self, transition: int, wait: Wait) -> bool:
        """Ask for a transition, one of those in ``ENDS_IN``; return whether it was made.

        A second request is refused where the first one was heard and its answer lost: the state
        that the node is in then tells.
        """
        request = ChangeState.Request(transition=Transition(id=transition))
        question = to_service(self._changer, request)
        wait(question.is_answered)
        if question.answer().success or not question.is_repeated:
            return bool(question.answer().success)
        return bool(self.state(wait) == ENDS_IN[transition])


def change_state(node: Node, target: str, transition: int, wait: Wait) -> bool:
    """Ask a lifecycle node for a transition once, as ``Lifecycle.change``."""
    asked = Lifecycle(node, target)
    try:
        return asked.change(transition, wait)
    finally:
        asked.close()


def state_of(node: Node, target: str, wait: Wait) -> int:
    """Return the state of a lifecycle node once, as ``Lifecycle.state``."""
    asked = Lifecycle(node, target)
    try:
        return asked.state(wait)
    finally:
        asked.close()
