"""A listener beside the suite: its nodes' messages, for a display; and requests to them.

Contents: subscriptions and commands of a watcher.

It hears samples and estimates best-effort: a writer never waits for, nor repeats anything to, a
reader that has not promised to keep up, so that a watcher that is slow, stopped or killed costs the
nodes nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from numpy.typing import NDArray
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String
from std_srvs.srv import Trigger

from crtk_msgs.msg import OperatingState
from tissue_probe.estimation import ESTIMATORS
from tissue_probe.mapping.verdict import CellVerdict
from tissue_probe.nodes.asking import ask, change_state, to_action
from tissue_probe.nodes.cdr import estimate_values_from_cdr, samples_from_cdr
from tissue_probe.nodes.conversions import ESTIMATE_VALUES
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.signals import SampleBlock
from tissue_probe_msgs.action import ScanGrid
from tissue_probe_msgs.msg import (
    Inclusion,
    Inclusions,
    ModelVerdict,
    ProbeSamples,
    SiteResult,
    SiteResults,
    TissueEstimate,
)

#: Half a second of blocks and estimates.
HEARD = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
#: Longest wait for an answer to a command [s].
LONGEST_COMMAND_WAIT = 10.0
LIFECYCLE_COMMANDS = {
    "configure": Transition.TRANSITION_CONFIGURE,
    "start": Transition.TRANSITION_ACTIVATE,
    "stop": Transition.TRANSITION_DEACTIVATE,
}
TRIGGERS = ("emergency_stop", "reset", "tare")


class CommandError(RuntimeError):
    """A command was not obeyed; the message says which and why."""


@dataclass(frozen=True)
class WatchedMap:
    """The mapper's messages on a scan, in SI units; each part comes by itself.

    Attributes
    ----------
    sites, inclusions : list of dict
        Each by its values' names; the boundaries of inclusions are lists of x and y.
    background : float
        Stiffness between the inclusions [N/m]; NaN before any map.
    notes : list of str
        Notes on the map.
    surface : array or None
        Points of the surface, with the cloud's fields.
    """

    sites: list[dict[str, Any]] = field(default_factory=list)
    inclusions: list[dict[str, Any]] = field(default_factory=list)
    background: float = math.nan
    notes: list[str] = field(default_factory=list)
    surface: NDArray[Any] | None = None


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
    map : WatchedMap
        The newest map; another object whenever something of it is new.
    fault, state : str
        The newest of both; empty before any.
    health : dict
        Level (0 to 3) and message of each node, by its name.
    verdict : dict
        The monitor's newest verdict on the model; empty before any.
    """

    def __init__(self, namespace: str = "/probe") -> None:
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node("watch", namespace=namespace, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self.blocks: list[SampleBlock] = []
        self.estimates: dict[str, list[tuple[float, ...]]] = {}
        self.map = WatchedMap()
        self.fault = self.state = ""
        self.health: dict[str, tuple[int, str]] = {}
        self.verdict: dict[str, Any] = {}
        self._inbox = Inbox(self._node)
        hear = self._inbox.subscribe
        hear(ProbeSamples, "samples", HEARD, self._on_samples, raw=True)
        for name in ESTIMATORS:
            hear(TissueEstimate, f"{name}/estimate", HEARD, self._on_estimate, raw=True)
        hear(SiteResults, "sites", LATCHED, self._on_sites)
        hear(Inclusions, "inclusions", LATCHED, self._on_inclusions)
        hear(PointCloud2, "stiffness_cloud", LATCHED, self._on_cloud)
        hear(ModelVerdict, "model_verdict", LATCHED, self._on_verdict)
        hear(String, "fault", LATCHED, self._on_fault)
        hear(OperatingState, "operating_state", LATCHED, self._on_state)
        hear(DiagnosticArray, "/diagnostics", HEARD, self._on_health)

    def hear(self) -> None:
        """Take all messages that have come: in bulk, since waking up for each costs more."""
        self._inbox.empty()

    def command(self, name: str, given: Mapping[str, Any]) -> str:
        """Send a command to the nodes; return their answer.

        Parameters
        ----------
        name : str
            ``configure``, ``start`` or ``stop`` the driver; ``emergency_stop``, ``reset``,
            ``tare``; ``excite`` (parameters of the excitation, while stopped); ``scan`` (origin,
            spacing, rows, columns, dwell_time).
        given : mapping
            Its arguments.

        Raises
        ------
        CommandError
            If nobody answers, or it is refused.
        """
        if name in LIFECYCLE_COMMANDS:
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
        def wait(condition: Callable[[], bool]) -> None:
            self._until(condition, "driver")

        if not change_state(self._node, "driver", LIFECYCLE_COMMANDS[name], wait):
            raise CommandError(f"the driver did not {name}; its log and /diagnostics say why")
        return f"{name}: done"

    def _trigger(self, name: str) -> str:
        def wait(condition: Callable[[], bool]) -> None:
            self._until(condition, name)

        answer = ask(self._node, Trigger, name, Trigger.Request(), wait)
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
            goal = ScanGrid.Goal(
                spacing=float(given["spacing"]),
                rows=int(given["rows"]),
                columns=int(given["columns"]),
                dwell_time=float(given["dwell_time"]),
            )
            goal.origin.x, goal.origin.y, goal.origin.z = map(float, given["origin"])
            wanted = to_action(client, goal)
            self._until(wanted.is_answered, "the scan node")
            if not wanted.answer().accepted:
                raise CommandError("the scan was refused; the scan node's log says why")
            return f"{goal.rows * goal.columns} sites are palpated"
        except (KeyError, TypeError, ValueError, AssertionError) as error:
            raise CommandError(f"the scan is not described as it must be: {error}") from None
        finally:
            client.destroy()

    def _until(self, condition: Callable[[], bool], who: str) -> None:
        """Take part in the graph until a condition holds; go on hearing meanwhile."""
        left = LONGEST_COMMAND_WAIT
        while not condition():
            if left <= 0.0:
                raise CommandError(f"{who} does not answer")
            self._executor.spin_once(timeout_sec=0.02)
            self._inbox.empty()
            left -= 0.02

    def _on_samples(self, message: bytes, info: dict[str, int]) -> None:
        try:
            self.blocks.append(samples_from_cdr(message)[0])
        except ValueError:
            return  # the estimators tell of it

    def _on_estimate(self, message: bytes, info: dict[str, int]) -> None:
        try:
            name, status, stamp, values = estimate_values_from_cdr(message)
        except ValueError:
            return  # the mapper tells of it
        self.estimates.setdefault(name, []).append((stamp, status, *values))

    def _on_sites(self, message: SiteResults, info: dict[str, int]) -> None:
        self.map = replace(self.map, sites=[_site(each) for each in message.results])

    def _on_inclusions(self, message: Inclusions, info: dict[str, int]) -> None:
        inclusions = [_inclusion(each) for each in message.inclusions]
        self.map = replace(
            self.map,
            inclusions=inclusions,
            background=message.background,
            notes=list(message.notes),
        )

    def _on_cloud(self, message: PointCloud2, info: dict[str, int]) -> None:
        fields = [(each.name, "<f4") for each in message.fields]
        self.map = replace(self.map, surface=np.frombuffer(bytes(message.data), np.dtype(fields)))

    def _on_verdict(self, message: ModelVerdict, info: dict[str, int]) -> None:
        self.verdict = {
            "verdict": message.verdict,
            "effects": list(zip(message.effects, message.probabilities, strict=False)),
            "error_current": _finite(message.error_current),
            "error_proposed": _finite(message.error_proposed),
            "unseen": list(message.unseen),
            "experiment": message.experiment,
        }

    def _on_fault(self, message: String, info: dict[str, int]) -> None:
        self.fault = message.data

    def _on_state(self, message: OperatingState, info: dict[str, int]) -> None:
        self.state = message.state

    def _on_health(self, message: DiagnosticArray, info: dict[str, int]) -> None:
        for status in message.status:
            self.health[status.name] = (status.level[0], status.message)


def _finite(value: float) -> float | None:
    """Return a number as pages are told it: JSON knows no NaN."""
    return value if math.isfinite(value) else None


def _site(result: SiteResult) -> dict[str, Any]:
    return {
        "site": result.site,
        "x": result.position.x,
        "y": result.position.y,
        "stiffness": result.stiffness,
        "stiffness_sd": result.stiffness_stddev,
        "verdict": CellVerdict(result.verdict).name.lower().replace("_", " "),
    }


def _inclusion(told: Inclusion) -> dict[str, Any]:
    lines = {
        name: [[point.x, point.y] for point in getattr(told, name)]
        for name in ("boundary_50", "boundary_95")
    }
    return {
        "x": told.position.x,
        "y": told.position.y,
        "probability": told.probability,
        "stiffness": told.stiffness,
        "stiffness_sd": told.stiffness_stddev,
        "contrast": told.contrast,
        **lines,
    }


#: Where each value stands in a row of ``Watch.estimates``.
PLACES = {name: 2 + place for place, name in enumerate(ESTIMATE_VALUES)}
