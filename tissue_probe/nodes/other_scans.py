"""Other scan nodes on the same robot: two would draw one probe to and fro."""

from __future__ import annotations

from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.node import Node, NodeNameNonExistentError

from tissue_probe.nodes.hearing import node_name

ACTIONS = "tissue_probe_msgs/action/"


def other_scans(node: Node, setpoints: str) -> list[str]:
    """Return the names of the other nodes that could move the robot, and take goals of a scan.

    A console that only could move it, as every client of CRTK, is none; nor is a replay.

    Parameters
    ----------
    node : Node
        The scan node that asks.
    setpoints : str
        Full name of the topic of the robot's setpoints.
    """
    infos = node.get_publishers_info_by_topic(setpoints)
    names = [(info.node_name, info.node_namespace) for info in infos]
    me = (node.get_name(), node.get_namespace())
    if me in names:
        names.remove(me)
    elif len(names) == 1:
        return []  # ourselves, even where the graph has not learnt our name yet
    return sorted(
        f"{where.rstrip('/')}/{name}" for name, where in names if _takes_goals(node, name, where)
    )


def are_known(node: Node, setpoints: str) -> bool:
    """Whether the graph tells the nodes of all that could move the robot."""
    infos = node.get_publishers_info_by_topic(setpoints)
    return len(infos) < 2 or all(map(node_name, infos))


def _takes_goals(node: Node, name: str, namespace: str) -> bool:
    if not namespace.startswith("/"):  # it is no ROS node, or not known yet
        return False
    try:
        actions = get_action_server_names_and_types_by_node(node, name, namespace)
    except NodeNameNonExistentError:  # it has gone, or no ROS node made the publisher
        return False
    return any(each.startswith(ACTIONS) for _, types in actions for each in types)
