"""What the diagnosis says of a record, as far as it is kept and compared.

Contents: asking about one record, and about all in two processes.

Each record is asked about in a process of its own that shares no search with a copy: which of two
processes is ahead is chance, and the last digits with it. So two runs agree in all but the time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from multiprocessing import get_context

from rich.progress import track
from threadpoolctl import threadpool_limits

from benchmarks.golden.records import Answer, Asked, makers
from benchmarks.ruler import marks
from tissue_probe.diagnosis.fitting.effort import Effort
from tissue_probe.errors import TissueProbeError

#: Records that are asked about at once.
PROCESSES = 2
#: Loading models takes seconds in a new process. A record that takes less than this is asked about
#: again, for a time without: in longer ones loading is no more than a tenth.
AGAIN = 30.0
#: Effects that are less probable are not kept.
WORTH_KEEPING = 1e-3


@dataclass(frozen=True)
class Told:
    """What is said of a record.

    Attributes
    ----------
    right : bool
        By the marks of its set.
    verdict : str
        As said; "refused" where there is no diagnosis.
    effects : tuple of str
        What is missing.
    probabilities : mapping of str to float
        That an effect is missing, of each effect of the ranking.
    revisions : tuple of str
        Of the samples, in their order.
    responses : float
        Computed in all, each over all samples of the first record.
    seconds : float
        Processor time of the diagnosis, its models loaded.
    refused : str
        The sentence where there is no diagnosis; else empty.
    """

    right: bool
    verdict: str
    effects: Sequence[str] = ()
    probabilities: Mapping[str, float] = field(default_factory=dict)
    revisions: Sequence[str] = ()
    responses: float = 0.0
    seconds: float = 0.0
    refused: str = ""


def measure(made: Sequence[Callable[[], Asked]] = ()) -> dict[str, Told]:
    """Return what is said of each record by its name; of all if none are given."""
    every = made or makers()
    with get_context("fork").Pool(PROCESSES, maxtasksperchild=1) as pool:
        found = track(pool.imap(ask, every), "asked about", len(every))
        return dict(found)


def ask(make: Callable[[], Asked]) -> tuple[str, Told]:
    """Make a record, and diagnose it; return its name, and what is said of it."""
    asked = make()
    with threadpool_limits(1):
        told = _told(asked)
        if told.seconds < AGAIN and not told.refused:
            told = _told(asked)
    return asked.name, told


def _told(asked: Asked) -> Told:
    effort, begun = Effort([asked.first]), time.process_time()
    try:
        with effort.count_responses():
            found = marks.answer(asked.first, asked.second, asked.arguments)
    except Exception as error:
        # As in ``marks``: whatever ends a diagnosis is a refusal.
        kind = "" if isinstance(error, TissueProbeError) else f"{type(error).__name__}: "
        return Told(False, "refused", refused=f"{kind}{error}")
    return Told(
        asked.right(found),
        found["verdict"],
        tuple(found["effects"]),
        _probabilities(found),
        tuple(found["revisions"]),
        round(effort.done, 1),
        round(time.process_time() - begun, 2),
    )


def _probabilities(found: Answer) -> dict[str, float]:
    every = {each["effect"]: each["probability"] for each in found["ranking"]}
    return {name: round(each, 4) for name, each in every.items() if each > WORTH_KEEPING}
