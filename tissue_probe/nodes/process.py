"""How a node's process starts, and how it ends: in order, whatever ends it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import rclpy
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from tissue_probe.settings import SettingsError, sentence


class Finished(Exception):
    """Raised by a node in a callback when it has done all that it was started for."""


#: What a user can mend; told in one line, without a traceback.
MISTAKES = (SettingsError, OSError)


def run(make_node: Callable[[], Node], executor: type[Executor] = SingleThreadedExecutor) -> int:
    """Make a node and spin it until Ctrl-C, SIGTERM, or a failure; return the exit status.

    The node's ``destroy_node`` is called in every case.
    """
    rclpy.init()
    node = None
    try:
        node = make_node()
        spinner = executor()
        spinner.add_node(node)
        spinner.spin()
    except (KeyboardInterrupt, ExternalShutdownException, Finished):
        pass
    except MISTAKES as error:
        print(f"{Path(sys.argv[0]).stem}: {sentence(error)}", file=sys.stderr)
        return 1
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0
