"""The driver of another process: its state and its excitation, put back as they were found."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from lifecycle_msgs.msg import State, Transition
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from std_msgs.msg import String

from tissue_probe.devices.calibration import Calibration
from tissue_probe.devices.limits import Limits
from tissue_probe.nodes.asking import Lifecycle, Wait, to_service
from tissue_probe.nodes.driver import ExcitationSettings
from tissue_probe.nodes.qos import LOANS
from tissue_probe.settings import build

READY = (State.PRIMARY_STATE_INACTIVE, State.PRIMARY_STATE_ACTIVE)
EXCITATION, LIMITS = "excitation.", "limits."


class DriverUnwilling(RuntimeError):
    """The driver does not do what it is asked for; the message says what, and why."""


@dataclass(frozen=True)
class DriverState:
    """How a driver was found.

    Attributes
    ----------
    active : bool
        Whether the coil is driven.
    excitation : mapping
        Its parameters of the excitation, by name without the prefix.
    limits : Limits
        Its limits.
    current_per_volt : float
        By its calibration [A/V].
    """

    active: bool
    excitation: Mapping[str, object]
    limits: Limits
    current_per_volt: float


class RemoteDriver:
    """Asks a driver, each question until it is answered or ``wait`` raises.

    Parameters
    ----------
    node : Node
        Asks; its executor runs in other threads.
    name : str
        The driver's name, relative to the node's namespace.
    """

    def __init__(self, node: Node, name: str) -> None:
        # Made once: a client that has only just been made may miss its first answer.
        self._getter = node.create_client(GetParameters, f"{name}/get_parameters")
        self._setter = node.create_client(
            SetParametersAtomically, f"{name}/set_parameters_atomically"
        )
        self._lifecycle = Lifecycle(node, name)
        self._loans = node.create_publisher(String, "excitation_loan", LOANS)
        self._stopped_here = False

    def look(self, wait: Wait) -> DriverState:
        """Return its state.

        Raises
        ------
        DriverUnwilling
            If it is not configured.
        """
        state = self._look_state(wait)
        if state not in READY:
            raise DriverUnwilling("the driver is not configured: configure it, then ask again")
        excitation = self._read(EXCITATION, list(ExcitationSettings.model_fields), wait)
        limits = self._read(LIMITS, list(Limits.model_fields), wait)
        calibration = self._read("", ["calibration"], wait)["calibration"]
        return DriverState(
            state == State.PRIMARY_STATE_ACTIVE,
            excitation,
            build(Limits, limits, LIMITS),
            Calibration.parse(str(calibration)).current_per_volt,
        )

    @contextmanager
    def excite(
        self, found: DriverState, excitation: Mapping[str, object], wait: Wait, put_back: Wait
    ) -> Iterator[None]:
        """Drive the coil by an excitation; at any end put the driver back as it was found.

        Who uses it must call ``show_alive`` several times in ``PALPATION_LEASE``: where that ceases
        the driver puts the coil at zero and the excitation back by itself.

        Parameters
        ----------
        found : DriverState
            As it is to be again.
        excitation : mapping
            Parameters of the excitation to be changed, by name without the prefix.
        wait, put_back : callable
            Wait for the driver's answers: before, and while it is put back.

        Raises
        ------
        DriverUnwilling
            If it refuses the excitation, or cannot be put back.
        """
        is_new = any(found.excitation[name] != value for name, value in excitation.items())
        if found.active and not is_new:
            yield
            return
        self._stopped_here = False
        lent = build(ExcitationSettings, dict(found.excitation)).model_dump_json()
        # Unheard, the driver could not put it back if this process died.
        wait(lambda: bool(self._loans.get_subscription_count()))
        self._loans.publish(String(data=lent))
        try:
            self._change(found.active, {**found.excitation, **excitation}, True, wait)
            yield
        finally:
            self._put_back(found, put_back)
            self._loans.publish(String())

    def show_alive(self) -> None:
        """Show the driver that this process is alive."""
        self._loans.assert_liveliness()

    def _put_back(self, found: DriverState, wait: Wait) -> None:
        """Stop the coil, restore the excitation, activate again what was active.

        But not what a fault, or somebody else, has stopped meanwhile: the coil stays at zero.
        """
        runs = self._look_state(wait) == State.PRIMARY_STATE_ACTIVE
        again = found.active and (runs or self._stopped_here)
        self._change(runs, found.excitation, again, wait)

    def _change(
        self, active: bool, excitation: Mapping[str, object], activate: bool, wait: Wait
    ) -> None:
        if active:
            self._stopped_here = True
            self._transit(Transition.TRANSITION_DEACTIVATE, "deactivate", wait)
        self._write(excitation, wait)
        if activate:
            self._stopped_here = False
            self._transit(Transition.TRANSITION_ACTIVATE, "activate", wait)

    def _transit(self, transition: int, word: str, wait: Wait) -> None:
        if not self._lifecycle.change(transition, self._show_alive_while(wait)):
            raise DriverUnwilling(f"the driver did not {word}: its log says why")

    def _look_state(self, wait: Wait) -> int:
        return self._lifecycle.state(self._show_alive_while(wait))

    def _ask(self, client: Client, request: Any, wait: Wait) -> Any:
        """Return the answer of a service, which may hear the request twice."""
        question = to_service(client, request)
        self._show_alive_while(wait)(question.is_answered)
        return question.answer()

    def _show_alive_while(self, wait: Wait) -> Wait:
        def wait_alive(condition: Callable[[], bool]) -> None:
            def is_met() -> bool:
                self.show_alive()
                return condition()

            wait(is_met)

        return wait_alive

    def _read(self, prefix: str, names: list[str], wait: Wait) -> dict[str, Any]:
        request = GetParameters.Request(names=[prefix + name for name in names])
        answer = self._ask(self._getter, request, wait)
        values = map(parameter_value_to_python, answer.values)
        return dict(zip(names, values, strict=True))

    def _write(self, excitation: Mapping[str, object], wait: Wait) -> None:
        parameters = [
            Parameter(EXCITATION + name, value=value).to_parameter_msg()
            for name, value in excitation.items()
        ]
        request = SetParametersAtomically.Request(parameters=parameters)
        answer = self._ask(self._setter, request, wait).result
        if not answer.successful:
            raise DriverUnwilling(f"the driver refuses the excitation: {answer.reason}")
