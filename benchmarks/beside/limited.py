"""A tool in a process of its own that may take so much of the processor, and no more.

Contents: running one, and what is said of one that took more.
"""

from __future__ import annotations

import resource
import signal
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from benchmarks.beside.data import Set
from benchmarks.beside.results import Result

#: Seconds of the processor: nobody waits for an answer that takes forty times the five which a
#: diagnosis of such a record should take.
MOST_SECONDS = 200.0


def limited(
    name: str, tool: Callable[[Set, Path], Result], of: Set, data: Path, most: float = MOST_SECONDS
) -> Result:
    """Return the result of a tool; one without errors, of infinite seconds, where it is ended.

    Parameters
    ----------
    name : str
        Of the tool.
    tool : callable
        Returns the result of a set in a folder.
    of : Set
        The set.
    data : path
        The folder of the sets.
    most : float
        Seconds of the processor that it may take, its predictions included.

    Raises
    ------
    RuntimeError
        If the tool fails; its own process says why.
    """
    fork = get_context("fork")
    hear, say = fork.Pipe(duplex=False)
    process = fork.Process(target=_run, args=(say, tool, of, data, most))
    process.start()
    say.close()
    try:
        result: Result = hear.recv()
    except EOFError:
        process.join()
        if process.exitcode != -signal.SIGXCPU:
            raise RuntimeError(f"{name} failed on {of.name}; see above") from None
        return Result(of.name, name, "", (np.nan,) * len(of.tests), np.inf)
    process.join()
    return result


def _run(
    say: Connection, tool: Callable[[Set, Path], Result], of: Set, data: Path, most: float
) -> None:
    """Run a tool, and send its result."""
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (round(most), hard))
    say.send(tool(of, data))
