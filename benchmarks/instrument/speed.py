"""Processor time of a diagnosis in process, beside an earlier revision.

Contents: three records, processes that stay warm, and turns.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from rich.table import Table

from benchmarks.instrument.case import generator
from benchmarks.instrument.measure import ONE_THREAD
from benchmarks.instrument.multisine import drawn
from benchmarks.instrument.pressed import Tissue
from benchmarks.protocols.course import Smooth
from benchmarks.protocols.motion import COMPLIANT, RIGID, Rig, simulate
from benchmarks.protocols.specimen import Specimen
from benchmarks.start import ROOT, tree_of

Array = np.ndarray
#: How often each record is diagnosed after the first time, by turns with the other revision.
REPETITIONS = 3
RATE, NOISE, ENCODER = 2000.0, 5e-3, 2e-6
NOW, BEFORE = "now", "before"
#: Reads the record and its question from a file, answers each line with the processor time [s].
PROGRAM = """
import json, os, sys
import numpy as np
import tissue_probe as tp
columns = dict(np.load(sys.argv[1]))
asked = json.loads(sys.argv[2])
for _ in sys.stdin:
    before = sum(os.times()[:4])
    found = tp.diagnose(tp.read(columns, force_polarity="compression"), **asked)
    print(sum(os.times()[:4]) - before, found.verdict, *found.effects, flush=True)
"""


@dataclass(frozen=True)
class _Record:
    columns: Mapping[str, Array]
    arguments: Mapping[str, Any]


def measure(
    revision: str | None, say: Callable[[str], None] = print
) -> dict[str, dict[str, float]]:
    """Return the processor time of each record's diagnosis [s], now and before if asked.

    Parameters
    ----------
    revision : str or None
        Of git, to be measured beside.
    say : callable
        Told what each diagnosis takes and says.

    Raises
    ------
    SystemExit
        If git has no such revision.
    """
    found = {}
    with TemporaryDirectory() as name:
        folder = Path(name)
        trees = {NOW: ROOT}
        if revision is not None:
            trees[BEFORE] = tree_of(revision, folder / BEFORE)
        for title, record in _records().items():
            np.savez(folder / "record.npz", **record.columns)
            found[title] = _times(
                folder, record, trees, lambda told, at=title: say(f"{at}, {told}")
            )
    return found


def table(found: Mapping[str, Mapping[str, float]], revision: str | None) -> Table:
    """Return the times, with their ratio where there is an earlier revision."""
    shown = Table(title="Processor time of a diagnosis in process [s]", title_justify="left")
    for column in ("", *([] if revision is None else [revision]), NOW, "now / before"):
        shown.add_column(column, justify="right" if column else "left")
    for title, each in found.items():
        before = each.get(BEFORE)
        ratio = "-" if before is None else f"{each[NOW] / before:.2f}"
        beside = [] if before is None else [f"{before:.2f}"]
        shown.add_row(title, *beside, f"{each[NOW]:.2f}", ratio)
    return shown


def _times(
    folder: Path, record: _Record, trees: Mapping[str, Path], say: Callable[[str], None]
) -> dict[str, float]:
    """Return the median time of each tree; the processes live together and answer by turns."""
    command = [sys.executable, "-c", PROGRAM, "record.npz", json.dumps(record.arguments)]
    processes = {
        key: subprocess.Popen(
            command, cwd=folder, env={**os.environ, **ONE_THREAD, "PYTHONPATH": str(tree)},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )
        for key, tree in trees.items()
    }  # fmt: skip
    taken: dict[str, list[float]] = {key: [] for key in trees}
    for turn in range(REPETITIONS + 1):
        for key, process in processes.items():
            print(turn, file=process.stdin, flush=True)
            seconds, _, told = process.stdout.readline().partition(" ")
            if turn:  # the first time it compiles, and loads what it needs
                taken[key].append(float(seconds))
                say(f"{key}: {float(seconds):.2f} s, {told.strip()}")
    for process in processes.values():
        process.communicate()
    return {key: median(each) for key, each in taken.items()}


def _records() -> dict[str, _Record]:
    """Return the records, always the same."""
    rigid = {"rig": RIGID, "constants": {"tip_mass": 0.0}}
    return {
        "rigid, hertz, 4000 samples": _Record(_rigid(0.0), rigid),
        "rigid, hertz, 4000 samples, encoder's noise": _Record(_rigid(ENCODER), rigid),
        "compliant, hertz, 8000 samples": _Record(
            _compliant(), {"rig": COMPLIANT, "starts": "at-rest"}
        ),
    }


def _rigid(encoder: float) -> dict[str, Array]:
    random = generator("speed", 0)
    times = np.arange(4000) / RATE
    depth = drawn(random, 0.5, 12.0, 3e-4, 0.5).about(1.2e-3)
    force = Tissue(450.0, 4.0, exponent=1.5).in_motion(depth, times)
    return {
        "t": times,
        "u": depth(times) + encoder * random.standard_normal(times.size),
        "F": force + NOISE * random.standard_normal(times.size),
    }


def _compliant() -> dict[str, Array]:
    random = generator("speed", 1)
    times = np.arange(8000) / RATE
    moved = drawn(random, 0.5, 12.0, 3e-4, 0.25)
    end = times[-1]

    def depth(at: Array) -> Array:
        share = np.clip(np.asarray(at) / 0.3, 0.0, 1.0)
        risen = share**4 * (35.0 - 84.0 * share + 70.0 * share**2 - 20.0 * share**3)
        return risen * (1.2e-3 + moved(np.asarray(at)))

    specimen = Specimen(
        450.0, 4.0, 0.04, law="power", length=1e-3, exponent=1.5, one_sided=True
    )  # fmt: skip
    rig = Rig(COMPLIANT, 9700.0, 0.8)
    read = simulate(rig, specimen, Smooth(depth, 0.0, end + 0.1, 24.0), times, 0.0)
    force = read.force + NOISE * random.standard_normal(times.size)
    return {"t": times, "u": depth(times), "F": force}
