"""The end of a process beside a node: one pickled question on its standard input, words back.

Contents: hearing the question, saying words and why there are no more.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from tissue_probe.errors import TissueProbeError
from tissue_probe.one_line import sentence

Say = Callable[[object], None]


def answer_question(answer: Callable[[Any, Say], object]) -> None:
    """Answer one question; then the process ends.

    Parameters
    ----------
    answer : callable
        Called with the question, and a function that says a word before the last; returns the last.
        A TissueProbeError or OSError of it is said as a sentence.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # meant for who asks
    question = pickle.load(sys.stdin.buffer)
    told = Connection(os.dup(sys.stdout.fileno()), readable=False)
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # an effect of the user's own may print
    try:
        told.send(("", answer(question, lambda word: told.send(("", word)))))
    except (TissueProbeError, OSError) as error:
        told.send((sentence(error), None))
