"""A model that is read and compiled beside a node, in a process of its own.

Contents: both ends of it; ``python -m tissue_probe.nodes.model_process`` is the other one.

The node never composes a model: that takes Python a second or more, in which its samples would
wait. It gets plain values, and finds the machine code on disk.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from tempfile import TemporaryFile
from typing import Protocol

from tissue_probe.errors import TissueProbeError
from tissue_probe.nodes.low_priority import lower_session
from tissue_probe.one_line import sentence


class ModelToCompile(Protocol):
    """A question of plain values, which a process can be given."""

    def read(self) -> Callable[[], object]:
        """Compose the model; return a function that compiles it, and returns plain values.

        Raises
        ------
        TissueProbeError, OSError
            If the model cannot be used.
        """


class ModelRefused(TissueProbeError):
    """A model is not read or not compiled; the message says why."""


class ModelProcess:
    """One model on its way.

    Parameters
    ----------
    model : ModelToCompile
        What is to be compiled.
    """

    def __init__(self, model: ModelToCompile) -> None:
        self._begun = time.monotonic()
        self._told, sender = Pipe(duplex=False)
        with TemporaryFile() as asked, sender:
            pickle.dump(model, asked)
            asked.seek(0)
            self._process = subprocess.Popen(
                [sys.executable, "-m", __name__],
                stdin=asked,
                stdout=sender.fileno(),
                # A thread for each core would take all of them from the nodes.
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
                start_new_session=True,
            )

    @property
    def seconds(self) -> float:
        """Time since it began [s]."""
        return time.monotonic() - self._begun

    def wait_until_read(self, patience: float) -> None:
        """Wait until the model is composed, at most so long [s]; from then on its priority is low.

        Raises
        ------
        ModelRefused
            If it cannot be used, or is not composed in time.
        """
        if not self._told.poll(patience):
            raise ModelRefused(
                f"the model was not read within {patience:g} s: the machine is too busy; ask again"
            )
        self._hear()
        lower_session(self._process.pid)

    def is_done(self) -> bool:
        """Return whether it is compiled, or never will be."""
        return self._told.poll()

    def result(self) -> object:
        """Return what the question's function returned.

        Raises
        ------
        ModelRefused
            If it was not compiled.
        """
        return self._hear()

    def close(self) -> None:
        """End it, also within a computation; once is enough."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._told.close()

    def _hear(self) -> object:
        try:
            why, content = self._told.recv()
        except EOFError:
            status = self._process.wait()
            how = f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
            why = f"the process that compiles the model {how}; set the model again"
        if why:
            raise ModelRefused(why)
        return content


def answer_question() -> None:
    """Answer one question: that the model is read, then what its function returns."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # meant for who asks
    model: ModelToCompile = pickle.load(sys.stdin.buffer)
    told = Connection(os.dup(sys.stdout.fileno()), readable=False)
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # an effect of the user's own may print
    try:
        compile_model = model.read()
        told.send(("", None))
        told.send(("", compile_model()))
    except (TissueProbeError, OSError) as error:
        told.send((sentence(error), None))


if __name__ == "__main__":
    answer_question()
