"""One question to a process of its own beside a node, of low priority.

Contents: starting it, hearing its words, ending it. The other end is ``tissue_probe.side_answer``.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import time
from multiprocessing import Pipe
from tempfile import TemporaryFile
from typing import Any

from tissue_probe.errors import TissueProbeError
from tissue_probe.nodes.low_priority import lower_session


class SideFailed(TissueProbeError):
    """A process beside a node has no answer; the message says why."""


class SideProcess:
    """One question under way.

    Parameters
    ----------
    module : str
        Which runs as the process.
    question : object
        Of plain values; pickled.
    does : str
        The work of the process, to go after "the process that".

    Attributes
    ----------
    pid : int
        Of the process.
    """

    def __init__(self, module: str, question: object, does: str) -> None:
        self._does = does
        self._begun = time.monotonic()
        self._told, sender = Pipe(duplex=False)
        # A file in place of a pipe: nothing here waits until the process has read it.
        with TemporaryFile() as asked, sender:
            pickle.dump(question, asked)
            asked.seek(0)
            self._process = subprocess.Popen(
                [sys.executable, "-m", module],
                stdin=asked,
                stdout=sender.fileno(),
                # A thread for each core would take all of them from the nodes.
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
                start_new_session=True,
            )
        self.pid = self._process.pid

    @property
    def seconds(self) -> float:
        """Time since it began [s]."""
        return time.monotonic() - self._begun

    def lower(self) -> None:
        """Lower its priority below that of all nodes."""
        lower_session(self.pid)

    def has_said(self, patience: float = 0.0) -> bool:
        """Return whether it has said a word, or has ended; wait for that, at most so long [s]."""
        return self._told.poll(patience)

    def hear(self) -> Any:
        """Return its next word; waits for it.

        Raises
        ------
        SideFailed
            If it has ended without one, or says why there is none.
        """
        try:
            why, word = self._told.recv()
        except EOFError:
            status = self._process.wait()
            how = f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
            why = f"the process that {self._does} {how}; ask again"
        if why:
            raise SideFailed(why)
        return word

    def close(self) -> None:
        """End it, also within a computation; once is enough."""
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        self._told.close()
