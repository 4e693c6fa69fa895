"""The filters over a recording, off line: in a warm process, and as commands from start to end."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from benchmarks.suite import ESTIMATORS
from tissue_probe.analysis.recorded_facts import estimate_again
from tissue_probe.recording.bags.reader import read_recording

#: How often each time is taken; the median counts.
REPETITIONS = 3


def measure(bag: Path, say: Callable[[str], None] = print) -> dict[str, object]:
    """Return how long reading and each filter take after start-up, and each command as a whole.

    Parameters
    ----------
    bag : path
        A recording of the suite.
    say : callable
        Told what is under way.
    """
    recording = read_recording(bag)
    steps = {
        "read": lambda: read_recording(bag),
        **{name: lambda name=name: estimate_again(recording, name) for name in ESTIMATORS},
    }
    say(f"off line: {REPETITIONS} times each over {bag.name}")
    for step in steps.values():
        step()  # imports, and compiles or loads the kernels
    return {
        "recording_seconds": len(recording) * recording.blocks[0].sample_period,
        "warm_seconds": {name: typical_time(step) for name, step in steps.items()},
        "command_seconds": {name: typical_time(lambda n=name: run(bag, n)) for name in ESTIMATORS},
    }


def typical_time(action: Callable[[], object]) -> float:
    """Return the median of ``REPETITIONS`` durations [s]."""
    return median(duration(action) for _ in range(REPETITIONS))


def duration(action: Callable[[], object]) -> float:
    """Return how long an action takes [s]."""
    begin = time.perf_counter()
    action()
    return time.perf_counter() - begin


def run(bag: Path, estimator: str) -> None:
    """Run ``tissue_probe estimate`` as a user does."""
    program = "from tissue_probe.cli import main; main()"
    with TemporaryDirectory() as folder:
        output = Path(folder, "estimates.csv")
        words = ["estimate", bag, "--estimator", estimator, "--output", output]
        command = [sys.executable, "-c", program, *map(str, words)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
