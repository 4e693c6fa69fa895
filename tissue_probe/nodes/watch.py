"""A listener beside the suite: what its nodes say, for whoever shows it; what it asks of them.

What belongs here: subscriptions and commands of a watcher. What does not: showing (``workbench``).

It hears samples and estimates best-effort: a writer never waits for, nor repeats anything to, a
reader that has not promised to keep up, so that a watcher that is slow, stopped or killed costs the
nodes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import String
from std_srvs.srv import Trigger

from crtk_msgs.msg import OperatingState
from tissue_probe.estimation import ESTIMATORS
from tissue_probe.mapping.verdict import Verdict
from tissue_probe.nodes.cdr import estimate_values_from_cdr, samples_from_cdr
from tissue_probe.nodes.conversions import ESTIMATE_VALUES
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.signals import SampleBlock
from tissue_probe_msgs.action import ScanGrid
from tissue_probe_msgs.msg import ProbeSamples, StiffnessMap, TissueEstimate

#: Half a second of blocks and estimates.
HEARD = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
#: Longest wait for an answer to a command [s].
ANSWER = 10.0
TRANSITIONS = {
    "configure": Transition.TRANSITION_CONFIGURE,
    "start": Transition.TRANSITION_ACTIVATE,
    "stop": Transition.TRANSITION_DEACTIVATE,
}
TRIGGERS = ("emergency_stop", "reset", "tare")


class CommandError(RuntimeError):
    """A command was not obeyed; the message says which and why."""


class Watch:
    """Hears the suite of one namespace, in a context of its own.

    Parameters
    ----------
    namespace : str
        That of the suite.

    Attributes
    ----------
    blocks : list of SampleBlock
        Heard since they were last taken away.
    estimates : dict of str to list
        By the estimator: rows of stamp [ns], status, and ``ESTIMATE_VALUES``; likewise.
    map : dict or None
        The newest map: its places [m] and values.
    fault, state : str
        The newest of both; empty before any.
    health : dict
        Level (0 to 3) and message of each node, by its name.
    """

    def __init__(self, namespace: str = "/probe") -> None:
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node("watch", namespace=namespace, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self.blocks: list[SampleBlock] = []
        self.estimates: dict[str, list[tuple[float, ...]]] = {}
        self.map: dict[str, Any] | None = None
        self.fault = self.state = ""
        self.health: dict[str, tuple[int, str]] = {}
        self._inbox = Inbox(self._node)
        hear = self._inbox.subscribe
        hear(ProbeSamples, "samples", HEARD, self._on_samples, raw=True)
        for name in ESTIMATORS:
            hear(TissueEstimate, f"{name}/estimate", HEARD, self._on_estimate, raw=True)
        hear(StiffnessMap, "stiffness_map", LATCHED, self._on_map)
        hear(String, "fault", LATCHED, self._on_fault)
        hear(OperatingState, "operating_state", LATCHED, self._on_state)
        hear(DiagnosticArray, "/diagnostics", HEARD, self._on_health)

    def hear(self) -> None:
        """Take all messages that have come: in bulk, since waking up for each costs more."""
        self._inbox.empty()

    def command(self, name: str, given: Mapping[str, Any]) -> str:
        """Ask something of the nodes; return what they say of it.

        Parameters
        ----------
        name : str
            ``configure``, ``start`` or ``stop`` the driver; ``emergency_stop``, ``reset``,
            ``tare``; ``excite`` (parameters of the excitation, while stopped); ``scan`` (origin,
            spacing, rows, columns, dwell_time).
        given : mapping
            What belongs to it.

        Raises
        ------
        CommandError
            If nobody answers, or it is refused.
        """
        if name in TRANSITIONS:
            return self._change_state(name)
        if name in TRIGGERS:
            return self._trigger(name)
        if name == "excite":
            return self._excite(given)
        if name == "scan":
            return self._scan(given)
        raise CommandError(f"there is no command {name}")

    def close(self) -> None:
        """Leave the graph."""
        self._inbox.destroy()
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()

    def _change_state(self, name: str) -> str:
        client = self._node.create_client(ChangeState, "driver/change_state")
        request = ChangeState.Request()
        request.transition.id = TRANSITIONS[name]
        answer = self._answer(client, request, "driver")
        if not answer.success:
            raise CommandError(f"the driver did not {name}; its log and /diagnostics say why")
        return f"{name}: done"

    def _trigger(self, name: str) -> str:
        client = self._node.create_client(Trigger, name)
        answer = self._answer(client, Trigger.Request(), name)
        if not answer.success:
            raise CommandError(f"{name}: {answer.message}")
        return str(answer.message) or f"{name}: done"

    def _excite(self, given: Mapping[str, Any]) -> str:
        client = AsyncParameterClient(self._node, "driver")
        self._until(client.services_are_ready, "the driver")
        changes = [Parameter(f"excitation.{key}", value=value) for key, value in given.items()]
        asked = client.set_parameters_atomically(changes)
        self._until(asked.done, "the driver")
        result = asked.result().result
        if not result.successful:
            raise CommandError(f"the excitation stays as it is: {result.reason}")
        return "the excitation holds from the next start on"

    def _scan(self, given: Mapping[str, Any]) -> str:
        client = ActionClient(self._node, ScanGrid, "scan_grid")
        try:
            self._until(client.server_is_ready, "the scan node")
            goal = ScanGrid.Goal(
                spacing=float(given["spacing"]),
                rows=int(given["rows"]),
                columns=int(given["columns"]),
                dwell_time=float(given["dwell_time"]),
            )
            goal.origin.x, goal.origin.y, goal.origin.z = map(float, given["origin"])
            accepted = client.send_goal_async(goal)
            self._until(accepted.done, "the scan node")
            if not accepted.result().accepted:
                raise CommandError("the scan was refused; the scan node's log says why")
            return f"{goal.rows * goal.columns} sites are palpated"
        except (KeyError, TypeError, ValueError, AssertionError) as error:
            raise CommandError(f"the scan is not described as it must be: {error}") from None
        finally:
            client.destroy()

    def _answer(self, client: Any, request: Any, who: str) -> Any:
        try:
            self._until(client.service_is_ready, who)
            asked = client.call_async(request)
            self._until(asked.done, who)
            return asked.result()
        finally:
            self._node.destroy_client(client)

    def _until(self, condition: Callable[[], bool], who: str) -> None:
        """Take part in the graph until a condition holds; go on hearing meanwhile."""
        left = ANSWER
        while not condition():
            if left <= 0.0:
                raise CommandError(f"{who} does not answer")
            self._executor.spin_once(timeout_sec=0.02)
            self._inbox.empty()
            left -= 0.02

    def _on_samples(self, message: bytes, info: dict) -> None:
        try:
            self.blocks.append(samples_from_cdr(message)[0])
        except ValueError:
            return  # the estimators tell of it

    def _on_estimate(self, message: bytes, info: dict) -> None:
        try:
            name, status, stamp, values = estimate_values_from_cdr(message)
        except ValueError:
            return  # the mapper tells of it
        self.estimates.setdefault(name, []).append((stamp, status, *values))

    def _on_map(self, message: StiffnessMap, info: dict) -> None:
        names = ("stiffness", "damping", "stiffness_stddev")
        cells = [
            {
                "x": message.origin.x + column * message.spacing,
                "y": message.origin.y + row * message.spacing,
                **{n: getattr(message, n)[row * message.columns + column] for n in names},
                "verdict": Verdict(message.verdict[row * message.columns + column]).name.lower(),
            }
            for row in range(message.rows)
            for column in range(message.columns)
        ]
        self.map = {
            "x": [message.origin.x + n * message.spacing for n in range(message.columns)],
            "y": [message.origin.y + n * message.spacing for n in range(message.rows)],
            "cells": cells,
        }

    def _on_fault(self, message: String, info: dict) -> None:
        self.fault = message.data

    def _on_state(self, message: OperatingState, info: dict) -> None:
        self.state = message.state

    def _on_health(self, message: DiagnosticArray, info: dict) -> None:
        for status in message.status:
            self.health[status.name] = (status.level[0], status.message)


#: Where each value stands in a row of ``Watch.estimates``.
PLACES = {name: 2 + place for place, name in enumerate(ESTIMATE_VALUES)}
