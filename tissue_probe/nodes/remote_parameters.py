"""Another node's parameters, without waiting for them."""

from __future__ import annotations

from collections.abc import Callable

from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python


def fetch_parameters(
    node: Node, target: str, on_answer: Callable[[dict[str, object]], None]
) -> None:
    """Ask node ``target`` (its full name) for all its parameters.

    ``on_answer`` is called once with the values by name; never, if the target does not answer.
    """
    lister = node.create_client(ListParameters, f"{target}/list_parameters")
    getter = node.create_client(GetParameters, f"{target}/get_parameters")

    def on_names(future) -> None:
        names = list(future.result().result.names)
        got = getter.call_async(GetParameters.Request(names=names))
        got.add_done_callback(lambda future: on_values(names, future.result().values))

    def on_values(names: list[str], values) -> None:
        on_answer(dict(zip(names, map(parameter_value_to_python, values), strict=True)))
        node.destroy_client(lister)
        node.destroy_client(getter)

    lister.call_async(ListParameters.Request()).add_done_callback(on_names)
