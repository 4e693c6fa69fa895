"""Decisions beside the scan: in a process of their own.

Contents: starting it, asking it, ending it.

The loop that moves the probe must not wait for a decision, not even for the interpreter that a
decision holds: a thread of lower priority that the system takes from the processor while it holds
the interpreter stops the loop with it, the tip in the tissue.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from tissue_probe.nodes.low_priority import lower_priority

_MODULE = "tissue_probe.mapping.exploration.worker"


class DecisionProcess:
    """Runs functions one after another, elsewhere; arguments and results are pickled."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", _MODULE], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._questions, self._answers = self._process.stdin, self._process.stdout
        lower_priority(self._process.pid)
        self._asked: dict[int, Future[Any]] = {}
        self._number = 0
        self._lock = threading.Lock()
        self._is_over = False
        threading.Thread(target=self._hear, name="decisions", daemon=True).start()

    def submit(self, function: Callable[..., Any], *arguments: Any, **named: Any) -> Future[Any]:
        """Have a function called; its result, or exception, comes with the future."""
        future: Future[Any] = Future()
        with self._lock:
            self._number += 1
            if self._is_over:
                future.set_exception(_ended())
                return future
            self._asked[self._number] = future
        try:
            pickle.dump((self._number, function, arguments, named), self._questions)
            self._questions.flush()
        except OSError:
            pass  # it has ended, which is heard in the other thread
        return future

    def close(self) -> None:
        """End it, also within a computation."""
        self._process.kill()
        self._process.wait()

    def _hear(self) -> None:
        while True:
            try:
                number, result, error = pickle.load(self._answers)
            except (EOFError, OSError, pickle.UnpicklingError):
                break
            future = self._asked.pop(number)
            if error is None:
                future.set_result(result)
            else:
                future.set_exception(error)
        with self._lock:
            self._is_over = True
        for future in self._asked.values():
            future.set_exception(_ended())


def _ended() -> RuntimeError:
    return RuntimeError("the process that decides where to probe next has ended")
