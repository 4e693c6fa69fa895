"""A diagnosis beside a node: one question to a process of its own, of low priority.

Contents: starting it, looking whether it has answered, ending it.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import time
from contextlib import ExitStack
from tempfile import TemporaryFile
from typing import IO

from tissue_probe.monitoring.identification import RecordsQuestion
from tissue_probe.monitoring.question import Question, Verdict
from tissue_probe.nodes.low_priority import lower_session

_MODULE = "tissue_probe.analysis.monitor_worker"


class DiagnosisFailed(Exception):
    """A diagnosis gave no verdict; the message says why."""


class DiagnosisProcess:
    """One diagnosis under way.

    Parameters
    ----------
    question : Question or RecordsQuestion
        Samples, and the model that is asked about.

    Attributes
    ----------
    pid : int
        Of the process.
    """

    def __init__(self, question: Question | RecordsQuestion) -> None:
        # Files in place of pipes: nothing here waits for the process, nor it for this one.
        with TemporaryFile() as asked, ExitStack() as files:
            pickle.dump(question, asked)
            asked.seek(0)
            self._told = files.enter_context(TemporaryFile())
            self._process = _start_process(asked, self._told)
            self._files = files.pop_all()
        self._begun = time.monotonic()
        self.pid = self._process.pid
        lower_session(self.pid)

    @property
    def seconds(self) -> float:
        """Time since it began [s]."""
        return time.monotonic() - self._begun

    def verdict(self) -> Verdict | None:
        """Return the answer; None while there is none yet.

        Raises
        ------
        DiagnosisFailed
            If the process has ended without one, or says why there is none.
        """
        status = self._process.poll()
        if status is None:
            return None
        self._told.seek(0)
        content = self._told.read()
        self.close()
        if status:
            how = f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
            raise DiagnosisFailed(f"the process that diagnoses {how}; ask again")
        answer = pickle.loads(content)
        if isinstance(answer, str):
            raise DiagnosisFailed(answer)
        found: Verdict | None = answer
        return found

    def close(self) -> None:
        """End it, also within a computation; once is enough."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._files.close()


def _start_process(asked: IO[bytes], told: IO[bytes]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", _MODULE],
        stdin=asked,
        stdout=told,
        # A thread for each core would take all of them from the nodes.
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        start_new_session=True,
    )
