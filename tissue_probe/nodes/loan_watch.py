"""The watch of a loan: who has changed the excitation for a record must show that it is alive.

A node that drives the coil by an excitation of its own says before on `excitation_loan` which one
is to hold again, and says nothing (an empty text) when it holds. If the node dies or hangs between
the two, the driver is told here, which puts the coil at zero and that excitation back.
"""

from __future__ import annotations

from collections.abc import Callable

from pydantic import ValidationError
from rclpy.node import Node
from std_msgs.msg import String

from tissue_probe.nodes.lease import Lease
from tissue_probe.settings import Settings, SettingsError

#: Characters of a message that the log quotes: more than an excitation has.
MOST_QUOTED = 200


class LoanWatch:
    """Calls ``on_silence`` with the excitation to be put back if its borrower falls silent.

    Parameters
    ----------
    node : Node
        Whose executor serves the watch, and relative to whose names the topic is.
    settings : type
        The settings of an excitation.
    timeout : float
        Longest silence [s].
    on_silence : callable
        Called once for each silence: with the reason, and the settings.
    """

    def __init__(
        self,
        node: Node,
        settings: type[Settings],
        timeout: float,
        on_silence: Callable[[str, Settings], None],
    ) -> None:
        self._node, self._settings, self._on_silence = node, settings, on_silence
        self._lent: Settings | None = None
        self._lease = Lease(node, String, "excitation_loan", timeout, self._on_loan, self._on_loss)

    def change_timeout(self, timeout: float) -> None:
        """Allow another silence [s] from now on; a loan stays watched."""
        self._lease.change_timeout(timeout)

    def _on_loan(self, message: String) -> None:
        self._lent = None
        if not message.data:
            return
        try:
            self._lent = self._settings.model_validate_json(message.data)
        except (ValidationError, SettingsError):
            self._node.get_logger().error(
                f"a message on {self._lease.topic_name} is no excitation, and is passed over: "
                f"{message.data[:MOST_QUOTED]!r}"
            )

    def _on_loss(self) -> None:
        if self._lent is None:
            return
        lent, self._lent = self._lent, None
        self._on_silence(
            "the node that had changed the excitation for a record fell silent: it died, or hangs "
            f"(for {self._lease.timeout:g} s)",
            lent,
        )
