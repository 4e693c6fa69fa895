"""The parameters ``model`` and ``effects`` of a node, changed while it runs.

Contents: whether a change is accepted, its way until it is in force, and back where it fails.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic

from rclpy.node import Node
from rclpy.parameter import Parameter

from tissue_probe.errors import TissueProbeError
from tissue_probe.nodes.model_process import ModelToCompile, start_compiling
from tissue_probe.nodes.parameters import follow_changes, read
from tissue_probe.nodes.side_process import SideFailed, SideProcess
from tissue_probe.nodes.timers import every
from tissue_probe.one_line import sentence
from tissue_probe.settings import Settings

#: Parameters that may change while the node runs; together where both do.
OF_MODEL = ("model", "effects")
#: Longest wait for a model that is read [s]: on an idle machine it takes about two, and beside
#: processes that want all of it ten times as long.
LONGEST_MODEL_WAIT = 60.0
#: Time between two looks at a model under way [s]: it takes many times as long.
MODEL_LOOK_INTERVAL = 0.25


class ModelChanges(Generic[Settings]):
    """Takes another model while a node runs, which goes on with the old one until then.

    A change is accepted once a process of its own has read and composed the file, which it then
    compiles at low priority. Where another change is accepted meanwhile, that one wins. Where it
    fails, the parameters are put back to the model in force.

    Parameters
    ----------
    node : Node
        Has declared its settings, with ``OF_MODEL`` live.
    settings : type
        Its settings.
    ask : callable
        Returns the question to the process, of given settings.
    take : callable
        Called with settings and the process's result, when they are to be in force; raises a
        TissueProbeError where they cannot be.

    Attributes
    ----------
    failure : str
        Why the last change is not in force; empty where it is, or is under way.
    """

    def __init__(
        self,
        node: Node,
        settings: type[Settings],
        ask: Callable[[Settings], ModelToCompile],
        take: Callable[[Settings, object], None],
    ) -> None:
        self._node, self._settings, self._ask, self._take = node, settings, ask, take
        self._in_force = read(node, settings)
        self._next = self._in_force
        self._read: SideProcess | None = None
        self._under_way: SideProcess | None = None
        self._is_putting_back = False
        self.failure = ""
        follow_changes(node, {"": settings}, self._on_change, examine=self._examine)
        every(MODEL_LOOK_INTERVAL, node, self._look)

    def close(self) -> None:
        """End a process under way."""
        for process in (self._read, self._under_way):
            if process is not None:
                process.close()

    def values(self) -> dict[str, object]:
        """Return what diagnostics say of it."""
        if self._under_way is None:
            return {"model under way": "none"}
        said = f"{self._next_file or 'none'}, since {self._under_way.seconds:.0f} s"
        return {"model under way": said}

    @property
    def _next_file(self) -> str:
        file, _ = (getattr(self._next, name) for name in OF_MODEL)
        return str(file)

    def _examine(self, settings: Settings) -> str:
        """Say why a model cannot be taken; empty where it can."""
        if self._is_putting_back:
            return ""
        process = start_compiling(self._ask(settings))
        try:
            if not process.has_said(LONGEST_MODEL_WAIT):
                process.close()
                return (
                    f"the model was not read within {LONGEST_MODEL_WAIT:g} s: the machine is too "
                    "busy; ask again"
                )
            process.hear()
        except SideFailed as error:
            process.close()
            return str(error)
        process.lower()
        self._read = process
        return ""

    def _on_change(self) -> None:
        if self._is_putting_back:
            return
        if self._under_way is not None:
            self._under_way.close()
        self._under_way, self._read = self._read, None
        self._next, self.failure = read(self._node, self._settings), ""

    def _look(self) -> None:
        """Take a model that is compiled."""
        process = self._under_way
        if process is None or not process.has_said():
            return
        self._under_way = None
        try:
            self._take(self._next, process.hear())
        except TissueProbeError as error:
            self._put_back(error)
        else:
            self._in_force = self._next
        finally:
            process.close()

    def _put_back(self, error: TissueProbeError) -> None:
        self.failure = f"{self._next_file or 'no model'} is not taken: {sentence(error)}"
        self._node.get_logger().error(self.failure)
        old = [Parameter(name, value=_plain(getattr(self._in_force, name))) for name in OF_MODEL]
        self._is_putting_back = True
        try:
            self._node.set_parameters_atomically(old)
        finally:
            self._is_putting_back = False


def _plain(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value
