"""Node processes as copies of one that has imported everything: most of a start is imports.

A copy is a process like any other: its own arguments, environment, session, signals, DDS. What it
does not show is that a node imports all that it needs: ``test_start`` runs each one as a program.
"""

from __future__ import annotations

import atexit
import gc
import os
import runpy
import signal
import subprocess
import sys
from collections.abc import Sequence
from multiprocessing import get_context
from typing import BinaryIO

from rclpy.utilities import get_default_context

#: What copies have imported; machine code and Numba, too, which the simulated probe needs.
IMPORTED = [
    *(f"tissue_probe.nodes.{name}"
      for name in ("driver", "estimator", "mapper", "recorder", "replay", "scan", "stage")),
    "tissue_probe.devices.simulated",
]  # fmt: skip


class Forked:
    """A process, as ``subprocess.Popen`` shows one."""

    def __init__(self, command: Sequence[str], log: BinaryIO) -> None:
        self.args = list(command)
        context = get_context("forkserver")
        context.set_forkserver_preload(IMPORTED)
        given = (self.args, log.name, dict(os.environ))
        self._process = context.Process(target=_run, args=given, daemon=True)
        self._process.start()
        self.pid = self._process.pid

    @property
    def returncode(self) -> int | None:
        """How it ended; None while it has not."""
        return self._process.exitcode

    def poll(self) -> int | None:
        """Return how it ended; None while it has not."""
        return self._process.exitcode

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end."""
        self._process.join(timeout)
        if self._process.exitcode is None:
            raise subprocess.TimeoutExpired(self.args, timeout)
        return self._process.exitcode

    def send_signal(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def terminate(self) -> None:
        """Ask it to end."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """End it by force."""
        self.send_signal(signal.SIGKILL)


def _run(command: list[str], log: str, environment: dict[str, str]) -> None:
    """Become what a command line of ``python -m`` starts."""
    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    output = os.open(log, os.O_WRONLY | os.O_APPEND)
    os.dup2(output, 1)
    os.dup2(output, 2)
    os.environ.clear()
    os.environ.update(environment)
    _, option, module, *arguments = command
    assert option == "-m", command
    sys.argv = [module, *arguments]
    try:
        runpy.run_module(module, run_name="__main__", alter_sys=True)
    finally:
        _let_go()


def _let_go() -> None:
    """Do what the end of a program does, and that of a copy does not.

    DDS must let go of the memory that it shares with others: who waits for a lock in it, waits for
    ever.
    """
    atexit._run_exitfuncs()
    context = get_default_context()
    context.try_shutdown()
    if context.handle is not None:
        context.handle.destroy_when_not_in_use()
    gc.collect()
