"""How a node's process starts, and how it ends: in order, whatever ends it."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import rclpy
import rclpy.utilities
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from tissue_probe.settings import SettingsError, sentence


class Finished(Exception):
    """Raised by a node in a callback when it has done all that it was started for."""


#: What a user can mend; told in one line, without a traceback.
MISTAKES = (SettingsError, OSError)


def run(make_node: Callable[[], Node], executor: type[Executor] = SingleThreadedExecutor) -> int:
    """Make a node and spin it until Ctrl-C, SIGTERM, or a failure; return the exit status.

    The node's ``destroy_node`` is called in every case. Words on the command line that are not for
    ROS are answered with help instead.
    """
    return run_together(lambda: [make_node()], executor)


def run_together(
    make_nodes: Callable[[], Sequence[Node]],
    executor: type[Executor] = SingleThreadedExecutor,
) -> int:
    """Do as ``run`` does, with several nodes in one process; they end in the order given."""
    if arguments := rclpy.utilities.remove_ros_args(sys.argv)[1:]:
        return _explain(arguments)
    rclpy.init()
    nodes: Sequence[Node] = []
    try:
        nodes = make_nodes()
        _tell_unknown_parameters(nodes)
        spinner = executor()
        for node in nodes:
            spinner.add_node(node)
        spinner.spin()
    except (KeyboardInterrupt, ExternalShutdownException, Finished):
        pass
    except MISTAKES as error:
        print(f"{Path(sys.argv[0]).stem}: {sentence(error)}", file=sys.stderr)
        return 1
    except Exception:
        # SIGTERM ends the context under whatever runs: what is raised then is its consequence.
        if rclpy.ok():
            raise
    finally:
        # Ctrl-C under ros2 launch comes twice, from the terminal and from launch: end in order.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


def _tell_unknown_parameters(nodes: Sequence[Node]) -> None:
    """Warn of parameters that no node has declared, most likely misspelt: ROS ignores them."""
    # rclpy has no public name for what is given. What one node does not know is another's.
    given = {name for node in nodes for name in node._parameter_overrides}
    unknown = sorted(
        name
        for name in given
        if not any(node.has_parameter(name) for node in nodes)
        and not name.startswith(("qos_overrides.", "use_sim_time"))
    )
    if unknown:
        known = {name for node in nodes for name in node.get_parameters_by_prefix("")}
        nodes[0].get_logger().warning(
            f"no parameter {', '.join(unknown)}; there are {', '.join(sorted(known))}"
        )


def _explain(arguments: list[str]) -> int:
    """Answer words on the command line that are not for ROS: help, or what to write instead."""
    name = Path(sys.argv[0]).stem
    wants_help = bool({"-h", "--help"} & set(arguments))
    stream = sys.stdout if wants_help else sys.stderr
    if not wants_help:
        print(f"{name}: cannot read {' '.join(arguments)}", file=stream)
    print(
        f"Start it with: ros2 run tissue_probe {name} --ros-args -p NAME:=VALUE\n"
        f"Its parameters, while it runs: ros2 param list /probe/{name} and "
        f"ros2 param describe /probe/{name} NAME",
        file=stream,
    )
    return 0 if wants_help else 2
