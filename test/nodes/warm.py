"""Nodes' processes as forks of one that has imported everything: a start skips a second of imports.

Each is a process of its own, with the command line, environment, log and signals that ``Session``
gives it; `test_demo` and `test_start` start them from nothing.
"""

from __future__ import annotations

import importlib
import multiprocessing
import multiprocessing.connection
import multiprocessing.forkserver
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from typing import IO, Any

import pytest

PREFIX = "tissue_probe.nodes."

_server = multiprocessing.get_context("forkserver")
_server.set_forkserver_preload(["warm_up"])


class WarmProcess:
    """What ``subprocess.Popen`` returns for a node, as far as ``Session`` and the tests use it."""

    def __init__(
        self, module: str, words: Sequence[str], log: str, environment: Mapping[str, str]
    ) -> None:
        self.args = [module, *words]
        described = (module, list(words), log, dict(environment), os.getcwd())
        _ensure_server()
        self._process = _server.Process(target=_run, args=described, daemon=False)
        self._process.start()
        self.pid = self._process.pid

    @property
    def returncode(self) -> int | None:
        return self._process.exitcode

    def poll(self) -> int | None:
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        self._process.join(timeout)
        if self.returncode is None:
            raise subprocess.TimeoutExpired(self.args, timeout)
        return self.returncode

    def send_signal(self, number: int) -> None:
        if self.returncode is None:
            os.kill(self.pid, number)

    def terminate(self) -> None:
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)


def popen(command: Sequence[str], stdout: IO[bytes] | None = None, **others: Any) -> Any:
    """Start a command as ``subprocess.Popen`` does: warm if it is a node's."""
    is_node = list(command[:2]) == [sys.executable, "-m"] and command[2].startswith(PREFIX)
    if not is_node:
        return subprocess.Popen(command, stdout=stdout, **others)
    return WarmProcess(command[2], command[3:], stdout.name, os.environ)


def _ensure_server() -> None:
    """Start the server, where it does not run yet, so that it finds what it is to import.

    Python before 3.12 gives it no ``sys.path``, and says nothing of an import that failed.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join(filter(None, sys.path)))
        multiprocessing.forkserver.ensure_running()


def _end_with_tests() -> None:
    """End where those who test are killed, before later tests meet this node in their domain."""
    tests = multiprocessing.parent_process()
    assert tests is not None
    multiprocessing.connection.wait([tests.sentinel])
    os.kill(os.getpid(), signal.SIGKILL)


def _run(module: str, words: list[str], log: str, environment: dict[str, str], folder: str) -> None:
    """Become the node: in a session of its own, all that it says in its log."""
    is_warm = "warm_up" in sys.modules
    import warm_up  # noqa: F401 - where the server could not, this says why

    assert is_warm, "the server of forks has not imported what nodes need"
    threading.Thread(target=_end_with_tests, daemon=True).start()
    os.setsid()
    os.chdir(folder)
    nothing, written = os.open(os.devnull, os.O_RDONLY), os.open(log, os.O_WRONLY | os.O_APPEND)
    for number, file in enumerate((nothing, written, written)):
        os.dup2(file, number)
    os.environ.clear()
    os.environ.update(environment)
    node = importlib.import_module(module)
    sys.argv = [node.__file__, *words]
    raise SystemExit(node.main())
