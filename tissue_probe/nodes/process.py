"""How a node's process starts, and how it ends: in order, for any reason."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from pathlib import Path

import rclpy
import rclpy.utilities
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import uninstall_signal_handlers

from tissue_probe.one_line import sentence
from tissue_probe.settings import SettingsError


class Finished(Exception):
    """Raised by a node in a callback when it has done all that it was started for."""


#: Errors that a user can mend; told in one line, without a traceback.
MISTAKES = (SettingsError, OSError)


def run(
    make_node: Callable[[], Node], executor: Callable[[], Executor] = SingleThreadedExecutor
) -> int:
    """Make a node and spin it until Ctrl-C, SIGTERM, or a failure; return the exit status.

    The node's ``destroy_node`` is called in every case, while the node can still publish and be
    spun by its executor: it may have to bring something to an end. Words on the command line that
    are not for ROS are answered with help instead.
    """
    return run_together(lambda: [make_node()], executor)


def run_together(
    make_nodes: Callable[[], Sequence[Node]],
    executor: Callable[[], Executor] = SingleThreadedExecutor,
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
        _spin(spinner)
    except (KeyboardInterrupt, ExternalShutdownException, Finished):
        pass
    except MISTAKES as error:
        print(f"{Path(sys.argv[0]).stem}: {sentence(error)}", file=sys.stderr)
        return 1
    except Exception:
        # Where the context was shut down under running code, the error is its consequence.
        if rclpy.ok():
            raise
    finally:
        # Ctrl-C under ros2 launch comes twice, from the terminal and from launch: end in order.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


def _spin(executor: Executor) -> None:
    """Spin until SIGINT or SIGTERM, which rclpy itself would answer by ending the context.

    Python's handlers run in the main thread alone, which waits for messages then. So the signal
    goes through a pipe to a thread, and as a task from there to the executor.
    """
    ended = threading.Event()
    receiver, sender = os.pipe()
    os.set_blocking(sender, False)

    def hear() -> None:
        if os.read(receiver, 1):
            ended.set()
            executor.create_task(lambda: None)

    listener = threading.Thread(target=hear, name="signals")
    listener.start()
    uninstall_signal_handlers()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: None)
    signal.set_wakeup_fd(sender)
    try:
        while not ended.is_set() and rclpy.ok():
            executor.spin_once()
    finally:
        signal.set_wakeup_fd(-1)
        os.close(sender)  # which ends the thread
        listener.join()
        os.close(receiver)


def _tell_unknown_parameters(nodes: Sequence[Node]) -> None:
    """Warn of parameters that no node has declared, most likely misspelt: ROS ignores them."""
    # rclpy has no public name for given parameters. One that a node does not know is another's.
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
    """Answer words on the command line that are not for ROS: help, or the right words."""
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
