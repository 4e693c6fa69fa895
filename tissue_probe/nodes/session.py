"""A whole suite on this machine: its processes, run through a scan, and ended.

The PyPI wheels bring no ``launch``; on a full ROS 2 install the files in ``launch/`` do the same.
"""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from subprocess import DEVNULL, STDOUT, Popen, TimeoutExpired
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Point32
from lifecycle_msgs.msg import Transition
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from tissue_probe.configuration import stock_configuration
from tissue_probe.mapping.grid import Grid
from tissue_probe.nodes.asking import change_state, to_action
from tissue_probe_msgs.action import Explore, ScanGrid

#: Longest wait for all processes to find one another [s]; a first start compiles the filters.
START_TIMEOUT = 90.0
#: Longest wait for an answer of a running node [s].
ANSWER_TIMEOUT = 20.0
#: Longest wait for a process to end after Ctrl-C, before it is killed [s].
END_TIMEOUT = 15.0

#: Announces new processes for longer, so that they are found at once.
PROFILES = "discovery.xml"


class SessionError(RuntimeError):
    """The suite could not be started or broke down; the message says which part and why."""


@dataclass(frozen=True)
class NodeProcess:
    """How to start one node: its module in ``tissue_probe.nodes``, name, namespace, parameters."""

    module: str
    name: str
    namespace: str = "/probe"
    parameters: dict[str, object] = field(default_factory=dict)

    def command(self, parameter_file: Path) -> list[str]:
        """Return the command line."""
        settings = [f"{key}:={_yaml(value)}" for key, value in self.parameters.items()]
        # Nodes are named after their modules; a new name would go to every node in a process.
        rename = [] if self.name == self.module else ["-r", f"__node:={self.name}"]
        return [
            *(sys.executable, "-m", f"tissue_probe.nodes.{self.module}", "--ros-args"),
            *(*rename, "-r", f"__ns:={self.namespace}"),
            *("--params-file", str(parameter_file)),
            *(word for setting in settings for word in ("-p", setting)),
        ]


def simulation(
    estimators: Sequence[str], recording: Path, phantom: Path | None = None
) -> list[NodeProcess]:
    """Return the processes of the suite on the simulated probe; the recorder ends last.

    The estimators share a process, which takes and decodes each block of samples once.
    """
    chosen: dict[str, object] = {"simulated.phantom": str(phantom)} if phantom else {}
    return [
        NodeProcess("scan", "scan", parameters={"estimators": list(estimators)}),
        NodeProcess("driver", "driver", parameters=chosen),
        NodeProcess("stage", "stage", "/stage"),
        NodeProcess("estimators", "estimators", parameters={"estimators": list(estimators)}),
        NodeProcess("mapper", "mapper", parameters={"estimators": list(estimators)}),
        NodeProcess("recorder", "recorder", parameters={"output": str(recording)}),
    ]


class Session:
    """Processes that are started together and ended together in every case.

    Use it as a context manager. While it is open this process takes part in the graph with a node
    of its own.

    Parameters
    ----------
    processes : sequence of NodeProcess
        The last one ends when all others have: a recorder misses nothing there.
    parameter_file : path
        YAML file with parameters of the nodes; the stock simulation's if not given.

    Attributes
    ----------
    node : rclpy.node.Node
        This process's own node.
    processes : dict
        The processes by name.
    health : dict
        The values that each node last told in /diagnostics, by its full name.
    """

    def __init__(
        self, processes: Sequence[NodeProcess], parameter_file: Path | None = None
    ) -> None:
        self._descriptions = processes
        self.parameter_file = parameter_file or stock_configuration("simulation.yaml")
        self._logs = tempfile.TemporaryDirectory(prefix="tissue_probe_")
        self._context = rclpy.Context()
        self.processes: dict[str, Popen[bytes]] = {}
        self.health: dict[str, dict[str, str]] = {}
        self._before: Any = None

    def __enter__(self) -> Session:
        # Nobody outside this machine is to hear of a demonstration, nor to command its coil.
        os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        os.environ.setdefault("FASTRTPS_DEFAULT_PROFILES_FILE", str(stock_configuration(PROFILES)))
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self.node = rclpy.create_node("session", namespace="/probe", context=self._context)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_health, 100)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        try:
            self._before = _heard(signal.SIGTERM, _leave)
            for description in self._descriptions:
                self._start(description)
        except BaseException:  # Ctrl-C between two starts, too
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        # A second Ctrl-C is not heard: it would leave behind processes that have not ended yet.
        before = _heard(signal.SIGINT, signal.SIG_IGN)
        self._end()
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()
        self._logs.cleanup()
        _heard(signal.SIGINT, before)
        _heard(signal.SIGTERM, self._before)

    def activate(
        self, subscribers: dict[str, int], publishers: dict[str, int] | None = None
    ) -> None:
        """Configure the driver, wait until everyone is heard, activate the driver.

        Parameters
        ----------
        subscribers : dict
            How many subscriptions each node's publishers must reach, by the node's full
            name, as the nodes tell in /diagnostics.
        publishers : dict, optional
            How many publishers each node must hear, likewise: one may reach a subscription that
            does not hear it yet. Nothing is lost from then on.

        Raises
        ------
        SessionError
            If a process ends, or they do not find one another.
        """
        self._change_state(Transition.TRANSITION_CONFIGURE, "configure", START_TIMEOUT)
        self.wait_for_subscribers(subscribers)
        self.wait_for_publishers(publishers or {})
        self._change_state(Transition.TRANSITION_ACTIVATE, "activate", ANSWER_TIMEOUT)

    def wait_for_subscribers(self, counts: dict[str, int]) -> None:
        """Wait until each node reaches so many subscriptions, by the node's full name.

        Raises
        ------
        SessionError
            If they do not find one another in time, or a process ended meanwhile.
        """
        self._wait_for("subscribers", counts)

    def wait_for_publishers(self, counts: dict[str, int]) -> None:
        """Wait until each node hears so many publishers, by the node's full name.

        Raises
        ------
        SessionError
            If they do not find one another in time, or a process ended meanwhile.
        """
        self._wait_for("publishers", counts)

    def deactivate(self) -> None:
        """Put the coil at zero.

        Raises
        ------
        SessionError
            If the driver does not answer.
        """
        self._change_state(Transition.TRANSITION_DEACTIVATE, "deactivate", ANSWER_TIMEOUT)

    def scan(
        self, grid: Grid, dwell_time: float, on_feedback: Callable[[ScanGrid.Feedback], None]
    ) -> ScanGrid.Result:
        """Palpate a grid; on Ctrl-C, cancel the scan before going on.

        Parameters
        ----------
        grid : Grid
            The sites.
        dwell_time : float
            Time in contact at each [s].
        on_feedback : callable
            Called with the scan's feedback at each announcement.

        Raises
        ------
        SessionError
            If the scan is refused, or a process ends.
        """
        goal = ScanGrid.Goal(
            spacing=grid.spacing, rows=grid.rows, columns=grid.columns, dwell_time=dwell_time
        )
        goal.origin.x, goal.origin.y, goal.origin.z = grid.origin
        return self._act(ScanGrid, "scan_grid", goal, on_feedback)

    def explore(
        self,
        corners: Sequence[tuple[float, float]],
        most_sites: int,
        dwell_time: float,
        on_feedback: Callable[[Explore.Feedback], None],
    ) -> Explore.Result:
        """Explore an area at z = 0, of corners [m], by so many sites; else as ``scan``."""
        goal = Explore.Goal(most_sites=most_sites, dwell_time=dwell_time)
        goal.area.points = [Point32(x=x, y=y) for x, y in corners]
        return self._act(Explore, "explore", goal, on_feedback)

    def _act(self, kind: Any, name: str, goal: Any, on_feedback: Callable[[Any], None]) -> Any:
        client = ActionClient(self.node, kind, name)
        wanted = to_action(client, goal, lambda message: on_feedback(message.feedback))
        self.wait_until(wanted.is_answered, "the scan to be accepted")
        handle = wanted.answer()
        if not handle.accepted:
            raise SessionError(f"the scan was refused: {self.log('scan')}")
        result = handle.get_result_async()
        try:
            self.wait_until(result.done, "the scan", timeout=float("inf"))
        except KeyboardInterrupt:
            handle.cancel_goal_async()
            self.wait_until(result.done, "the scan to end")
        client.destroy()
        return result.result().result

    def wait_until(
        self, condition: Callable[[], bool], what: str, timeout: float = START_TIMEOUT
    ) -> None:
        """Take part in the graph until the condition holds.

        Raises
        ------
        SessionError
            If it does not hold in time, or a process ended meanwhile.
        """
        deadline = time.monotonic() + timeout
        while not condition():
            self._executor.spin_once(timeout_sec=0.05)
            for name, process in self.processes.items():
                if process.poll() is not None:
                    raise SessionError(f"{name} has ended: {self.log(name)}")
            if time.monotonic() > deadline:
                raise SessionError(f"waited {timeout:g} s in vain for {what}")

    def whole_log(self, name: str) -> str:
        """Return all that a process has written."""
        return (Path(self._logs.name) / name).read_text(errors="replace")

    def log(self, name: str) -> str:
        """Return the last line that a process wrote, or the last lines of a traceback."""
        lines = self.whole_log(name).strip().splitlines()
        is_traceback = any(line.startswith("Traceback") for line in lines)
        return "\n".join(lines[-12:] if is_traceback else lines[-1:]) or "it said nothing"

    def _wait_for(self, value: str, counts: dict[str, int]) -> None:
        """Wait until each node tells that it has found so many."""
        self.wait_until(
            lambda: all(
                int(self.health.get(node, {}).get(value, 0)) >= count
                for node, count in counts.items()
            ),
            f"the nodes to find one another ({value})",
        )

    def _on_health(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.health[status.name] = {value.key: value.value for value in status.values}

    def _start(self, description: NodeProcess) -> None:
        with (Path(self._logs.name) / description.name).open("wb") as log:
            self.processes[description.name] = Popen(
                description.command(self.parameter_file),
                stdin=DEVNULL,
                stdout=log,
                stderr=STDOUT,
                # Ctrl-C reaches this process alone, which then ends the others.
                start_new_session=True,
            )

    def _change_state(self, transition: int, name: str, timeout: float) -> None:
        def wait(condition: Callable[[], bool]) -> None:
            self.wait_until(condition, f"the driver to {name}", timeout)

        if not change_state(self.node, "driver", transition, wait):
            raise SessionError(f"the driver did not {name}: {self.log('driver')}")

    def _end(self) -> None:
        """End the processes as Ctrl-C does, by force if one does not listen.

        A scan ends first, since it lifts the probe and needs the robot for it; the last one last.
        """
        scans = {each.name for each in self._descriptions if each.module == "scan"}
        lifting = [each for name, each in self.processes.items() if name in scans]
        others = [each for name, each in self.processes.items() if name not in scans]
        for together in (lifting, others[:-1], others[-1:]):
            for process in together:
                process.send_signal(signal.SIGINT)
            for process in together:
                _wait_or_kill(process)


def _heard(number: signal.Signals, handler: Any) -> Any:
    """Hear a signal by another handler, where this thread may; return the one before."""
    if threading.current_thread() is not threading.main_thread():
        return None
    return signal.signal(number, handler) if handler is not None else None


def _leave(number: int, frame: object) -> None:
    """End this process as an error would: processes that it started end with it."""
    raise SystemExit(128 + number)


def _wait_or_kill(process: Popen[bytes]) -> None:
    try:
        process.wait(END_TIMEOUT)
    except TimeoutExpired:
        process.kill()
        process.wait()


def _yaml(value: object) -> str:
    """Return a parameter's value as --ros-args reads it."""
    if isinstance(value, list):
        return "[" + ", ".join(map(str, value)) + "]"
    return str(value).lower() if isinstance(value, bool) else str(value)
