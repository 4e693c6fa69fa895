"""The live suite, as it runs and as it ran before, held for a while and measured.

Contents: which runs are made and what is gathered of each.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from benchmarks import recorded, suite
from benchmarks.usage import cpu_seconds, memory_megabytes

#: Time between activation and the first look at the processor time [s].
SETTLING = 2.0

Results = dict[str, object]


def measure(folder: Path, seconds: float, say: Callable[[str], None] = print) -> Results:
    """Return what was measured apart, alone, and with a subscriber of every single sample.

    The first two compare the suite with that of before, in which each estimator had a process of
    its own, and every number that it published one by one was recorded: ``apart``.

    Parameters
    ----------
    folder : path
        Gets ``run.mcap``, the recording of the run without the subscriber.
    seconds : float
        Time over which processor time is counted, in each run [s].
    say : callable
        Told what is under way.

    Raises
    ------
    SessionError
        If the suite cannot be started or breaks down.
    """
    say(f"live: as before, each estimator in a process of its own, {seconds:g} s")
    apart = run(folder / "run_apart.mcap", seconds, apart=True)
    say(f"live: the suite alone, the estimators in one process, {seconds:g} s")
    alone = run(folder / "run.mcap", seconds)
    say(f"live: with a subscriber of {suite.PER_SAMPLE_TOPIC}, {seconds:g} s")
    subscribed = run(folder / "run_with_subscriber.mcap", seconds, subscribed=True)
    return {"seconds": seconds, "apart": apart, "alone": alone, "with_subscriber": subscribed}


def run(bag: Path, seconds: float, *, subscribed: bool = False, apart: bool = False) -> Results:
    """Run the suite once into a recording and return what was measured of it.

    Raises
    ------
    SessionError
        If the suite cannot be started or breaks down.
    """
    bag.unlink(missing_ok=True)
    received = bag.with_suffix(".received")
    with ExitStack() as stack:
        pids = {}
        if subscribed:
            pids["subscriber"] = stack.enter_context(suite.subscriber(received)).pid
        chosen = suite.processes(bag.absolute(), apart=apart)
        session = stack.enter_context(suite.acquiring(bag, chosen, subscribed=subscribed))
        pids |= {name: process.pid for name, process in session.processes.items()}
        usage = measure_usage(pids, partial(suite.spend, session), seconds)
    counts = recorded.counts(bag)
    if subscribed:
        counts.append(recorded.count_single(bag, **json.loads(received.read_text())))
    return {
        "counts": counts,
        "lateness": recorded.lateness(bag),
        "latency": recorded.latencies(bag),
        **usage,
    }


def measure_usage(
    pids: Mapping[str, int], wait: Callable[[float], None], seconds: float
) -> dict[str, dict[str, float]]:
    """Return the cores that each process keeps busy over ``seconds``, and its memory then."""
    wait(SETTLING)
    before, begin = cpu_seconds(pids), time.monotonic()
    wait(seconds)
    after, duration = cpu_seconds(pids), time.monotonic() - begin
    return {
        "cpu_cores": {name: (after[name] - before[name]) / duration for name in pids},
        "memory_megabytes": memory_megabytes(pids),
    }
