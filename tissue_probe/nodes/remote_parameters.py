"""The parameters of other nodes, without waiting for them."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence

from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.task import Future

from tissue_probe.nodes.timers import every

#: Time between two looks whether those that are to be asked can be [s].
NODE_LOOK_INTERVAL = 0.1
#: Time without an answer after which a node is asked once more [s].
REPEAT_AFTER = 3.0

#: Called with a node's full name and the values of all its parameters by name.
Told = Callable[[str, dict[str, object]], None]


class RemoteParameters:
    """Asks nodes for all their parameters, each until it has answered.

    A node is known by its name before its services are: a request made too early reaches nobody,
    and an answer may miss a client that has only just asked.
    """

    def __init__(self, node: Node, on_values: Told) -> None:
        self._node, self._on_values = node, on_values
        self._questions: dict[str, _Question] = {}
        every(NODE_LOOK_INTERVAL, node, self._pursue)

    def follow(self, nodes: Collection[str]) -> None:
        """Ask those of ``nodes``, by full name, that were not there before; forget all others."""
        for gone in self._questions.keys() - set(nodes):
            self._questions.pop(gone).end()
        for name in nodes:
            if name not in self._questions:
                self._questions[name] = _Question(self._node, name, self._on_values)

    def ask_again(self, name: str) -> None:
        """Ask a node that is followed once more, since its parameters have changed."""
        question = self._questions.get(name)
        # Many change together, and it is asked for all of them.
        if question is not None and question.asked:
            question.end()
            self._questions[name] = _Question(self._node, name, self._on_values)

    def _pursue(self) -> None:
        for question in list(self._questions.values()):
            question.pursue()


class _Question:
    """One node, asked for the names and values of all its parameters."""

    def __init__(self, node: Node, target: str, on_values: Told) -> None:
        self._node, self._target, self._on_values = node, target, on_values
        self._lister: Client = node.create_client(ListParameters, f"{target}/list_parameters")
        self._getter: Client = node.create_client(GetParameters, f"{target}/get_parameters")
        self._asked_at = float("-inf")
        self._ended = False

    @property
    def asked(self) -> bool:
        """Whether the target may have seen the question."""
        return self._asked_at > float("-inf")

    def pursue(self) -> None:
        """Ask if that has not been done lately, and the target can be reached."""
        if self._ended or time.monotonic() - self._asked_at < REPEAT_AFTER:
            return
        if self._lister.service_is_ready() and self._getter.service_is_ready():
            self._asked_at = time.monotonic()
            answer = self._lister.call_async(ListParameters.Request())
            answer.add_done_callback(self._on_names)

    def end(self) -> None:
        """Let go of the target; an answer under way is not told any more."""
        if not self._ended:
            self._ended = True
            self._node.destroy_client(self._lister)
            self._node.destroy_client(self._getter)

    def _on_names(self, answer: Future) -> None:
        if self._ended:
            return
        names = list(answer.result().result.names)
        values = self._getter.call_async(GetParameters.Request(names=names))
        values.add_done_callback(lambda answer: self._on_values_of(names, answer.result().values))

    def _on_values_of(self, names: list[str], values: Sequence[ParameterValue]) -> None:
        # Another number of values is the answer of a node that has changed meanwhile, and a type
        # that is none of ROS's that of a stranger: it is asked again.
        if not self._ended and len(values) == len(names) and all(map(_is_known, values)):
            self.end()
            found = map(parameter_value_to_python, values)
            self._on_values(self._target, dict(zip(names, found, strict=True)))


def _is_known(value: ParameterValue) -> bool:
    return bool(value.type <= ParameterType.PARAMETER_STRING_ARRAY)
